"""Drawing: which law is concealed, how large, and in which part of the data."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tools.trial.concealed.decks import GREYS, LONG, Setting
from tools.trial.concealed.laws import invented, named
from tools.trial.concealed.laws.flight import Flight
from tools.trial.concealed.laws.law import Law
from tools.trial.concealed.laws.left_out import LEFT_OUT, WITHHELD
from tools.trial.concealed.laws.matching import Matching
from tools.trial.concealed.shot import Place, Shot

Array = NDArray[np.float64]
Rng = np.random.Generator
Makers = dict[str, Callable[[Rng], Law]]

DECKS = {"temperature_drift": "warm", "beat": "warm", "stray_light": "card", "multipath": "corner"}
DECKS |= {"darker": "patches", "brighter": "patches"}
OFFSETS = ("depth_offset", "disparity_offset", "depth_scale")
# what a design of recordings makes alike, or nearly so
ALIKE = {
    True: ["amplitude_error", "depth_scale", "column_delay", "emitter_parallax", "temperature_drift"],
    False: ["disparity_offset", "depth_scale", "temperature_drift"],
}
DECOYS = {
    ("trend", True): ["amplitude_error", "depth_scale", "cyclic_error", "temperature_drift"],
    ("trend", False): ["disparity_offset", "depth_scale", "temperature_drift"],
    ("sides", True): ["amplitude_error", "column_delay", "emitter_parallax"],
}
# effects that look much like a wall that stands elsewhere
ABSORBED = {
    True: ["depth_offset", "depth_scale", "column_delay", "emitter_parallax"],
    False: ["disparity_offset", "depth_scale"],
}
# effects of which the power is measured: one of each frame of reference
POWER = {True: ["column_delay", "cyclic_error"], False: ["disparity_offset", "vertical_banding"]}


def quiet(family: str, flight: bool, rng: Rng) -> tuple[Setting, str]:
    """The setting of a case in which nothing is missing."""
    kinds = ["walls", "patches", "card", "warm", "corner"] if flight else ["walls", "patches", "warm"]
    kind = str(rng.choice(kinds[:4]))
    if family == "null":
        return Setting(kind, flight), "null"
    how = str(rng.choice(["bow", "order", "pose"]))
    if how == "order":
        return Setting("ordered", flight, float(rng.choice([0.0, 0.0008]))), how
    if how == "pose":
        return Setting(kind, flight, worst_pose=2.5), how
    return Setting(str(rng.choice(["walls", "patches"])), flight, 0.0012), how


def choice(family: str, flight: bool, rng: Rng) -> tuple[list[str], Makers, str]:
    """Names, the table they are from, and the deck they are shown with."""
    table: Makers = named.FLIGHT if flight else named.MATCHING
    if family == "unknown":
        table = invented.FLIGHT if flight else invented.MATCHING
    if family == "spread":
        table = invented.SPREAD_FLIGHT if flight else invented.SPREAD_MATCHING
    names, deck = sorted(table), str(rng.choice(["walls", "walls", "patches"]))
    if family == "masked":
        names = [n for n in names if n not in OFFSETS]
    if family == LEFT_OUT:
        names = [n for n in names if n in WITHHELD]
    if family == "absorbed":
        return [str(rng.choice(ABSORBED[flight]))], table, "plain walls"
    if family == "confusable":
        return [str(rng.choice(ALIKE[flight]))], table, "ordered"
    if family == "decoy":
        deck = str(rng.choice(["trend", "sides"])) if flight else "trend"
        return [str(rng.choice(DECOYS[deck, flight]))], table, deck
    if family == "power":
        return [str(rng.choice(POWER[flight]))], table, "walls"
    if family == "mixture":
        single = [n for n in names if n not in DECKS]
        return [str(n) for n in rng.choice(single, min(int(rng.integers(2, 4)), len(single)), False)], table, deck
    name = str(rng.choice(names))
    return [name], table, DECKS.get(name, deck)


def partly(law: Law, shots: list[Shot], setting: Setting, rng: Rng) -> Law:
    """The law in a part of the data only: the last minutes, one material, a band of distances, half the image."""
    if setting.kind in LONG:
        region = {"variable": "time", "low": 1500.0, "high": 1e5}
        return replace(law, mask=lambda p: (p.time > 1500.0) * np.ones(p.z.shape), region=(region,))
    how = str(rng.choice(["far", "band", "half", "material" if setting.kind == "patches" else "half"]))
    if how == "material":
        dark = 1.5 * float(GREYS[0])
        region = {"variable": "reflectance", "low": 0.0, "high": dark}
        return replace(law, mask=lambda p: (p.shot.hits.reflectance < dark).astype(float), region=(region,))
    if how == "half":
        region = {"variable": "u", "low": shots[0].camera.width / 2, "high": shots[0].camera.width}
        return replace(law, mask=lambda p: (p.u > p.shot.camera.width / 2).astype(float), region=(region,))
    middles = [float(np.nanmedian(shot.hits.z)) for shot in shots]
    low, high = np.quantile(middles, [0.5, 1.0] if how == "far" else [0.3, 0.7])
    high = 1e5 if how == "far" else high

    def band(p: Place) -> Array:
        z = np.nan_to_num(p.z)
        return ((z > low) & (z < high)).astype(float)

    region = {"variable": "depth", "low": float(low), "high": float(high)}
    return replace(law, mask=band, region=(region,))


def sized(law: Law, device: Flight | Matching, shots: list[Shot], ratio: float) -> Law:
    """The law with a size that makes its root mean square `ratio` times the noise of a frame."""
    squares, count = 0.0, 0
    for shot in shots:
        for frame in range(0, len(shot.times), 5) if shot.long else [0]:
            change = (device.clean(shot, [law], frame) - device.clean(shot, [], frame)) / device.sigma(shot)
            inside = change[shot.interior & (shot.hits.z > 0)]
            squares, count = squares + float(np.nansum(inside**2)), count + inside.size
    return replace(law, size=ratio / max(np.sqrt(squares / max(count, 1)), 1e-9))


def sign(law: Law, rng: Rng) -> int:
    """Light adds up; everything else may go either way."""
    way = int(rng.choice([-1, 1]))
    return 1 if law.stage == "light" else way


def masking(flight: bool, rng: Rng) -> tuple[Law, dict[str, Any]]:
    """A known offset, several times larger than the effect, whose stated value is slightly off."""
    unit = 1e-3 if flight else 0.01
    name, symbol = ("depth_offset", "m") if flight else ("disparity_offset", "px")
    size = float(rng.choice([-1, 1]) * rng.uniform(3, 8))
    std = 0.05 * abs(size) * unit

    def acts(p: Place) -> Array:
        return unit * np.ones(p.z.shape)

    law = Law(name, "delay" if flight else "disparity", acts, (), size=size)
    about = {"name": name, "unit": symbol, "true": size * unit, "std": std}
    about["value"] = size * unit + std * float(np.clip(rng.standard_normal(), -2, 2))
    return law, about
