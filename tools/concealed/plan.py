"""Plan: what is concealed in a case, drawn by family."""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from concealed import invented, named
from concealed.decks import Setting, shots_of
from concealed.flight import Flight
from concealed.law import Law
from concealed.matching import Matching
from concealed.shot import Place, Shot

Array = NDArray[np.float64]
Rng = np.random.Generator

FAMILIES = (
    "null",
    "hard null",
    "plain",
    "below noise",
    "masked",
    "partial",
    "mixture",
    "unknown",
    "spread",
    "confusable",
)
DECKS = {"temperature_drift": "warm", "beat": "warm", "stray_light": "card", "multipath": "corner"}
# root mean square of the concealed effect over the noise of a single frame
STRENGTH = {"below noise": (0.05, 0.2), "masked": (0.15, 0.5), "partial": (0.2, 0.8)}
USUAL = (0.3, 1.2)


@dataclass(frozen=True)
class Plan:
    """Attributes:
    missing: laws at work that the sensor model does not hold.
    known: laws at work that it holds, with their true size.
    stated: name of the known law's parameter, its unit, stated value and standard deviation.
    """

    family: str
    setting: Setting
    device: Flight | Matching
    shots: list[Shot]
    missing: list[Law]
    known: list[Law] = field(default_factory=list)
    stated: dict[str, Any] = field(default_factory=dict)
    notes: str = ""

    @property
    def flight(self) -> bool:
        return isinstance(self.device, Flight)

    @property
    def mesh_sigma_m(self) -> float:
        return self.setting.bow_m


def plan(family: str, rng: Rng) -> Plan:
    """A case of a family."""
    flight = bool(rng.random() < 0.5)
    device: Flight | Matching = Flight() if flight else Matching()
    if family in ("null", "hard null"):
        setting, notes = _quiet(family, flight, rng)
        return Plan(family, setting, device, shots_of(rng, setting), [], notes=notes)
    names, makers = _choice(family, flight, rng)
    deck = next((DECKS[name] for name in names if name in DECKS), str(rng.choice(["walls", "walls", "patches"])))
    if family == "confusable":
        deck = "ordered"
    setting = Setting(deck, flight)
    shots = shots_of(rng, setting)
    laws = [makers[name](rng) for name in names]
    if family == "partial":
        laws = [_partly(laws[0], shots, rng)]
    low, high = STRENGTH.get(family, USUAL)
    if family != "spread":
        laws = [_sized(law, device, shots, rng.uniform(low, high) * _sign(law, rng)) for law in laws]
    out = Plan(family, setting, device, shots, laws, notes=" ".join(names))
    return _masking(out, rng) if family == "masked" else out


def _quiet(family: str, flight: bool, rng: Rng) -> tuple[Setting, str]:
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


def _choice(family: str, flight: bool, rng: Rng) -> tuple[list[str], dict[str, Any]]:
    table = named.FLIGHT if flight else named.MATCHING
    if family == "unknown":
        table = invented.FLIGHT if flight else invented.MATCHING
    if family == "spread":
        table = {"noisier": invented.noisier, "remembering": invented.remembering}
        table |= {"darker": invented.darker} if flight else {}
    names = sorted(table)
    if family == "masked":
        names = [n for n in names if n not in ("depth_offset", "disparity_offset", "depth_scale")]
    if family == "confusable":
        alike = ["amplitude_error", "depth_scale", "column_delay", "emitter_parallax", "temperature_drift"]
        names = alike if flight else ["disparity_offset", "depth_scale", "temperature_drift"]
    if family == "mixture":
        single = [n for n in names if n not in DECKS]
        return [str(n) for n in rng.choice(single, min(int(rng.integers(2, 4)), len(single)), replace=False)], table
    return [str(rng.choice(names))], table


def _partly(law: Law, shots: list[Shot], rng: Rng) -> Law:
    """The law in a part of the data only."""
    if any(shot.long for shot in shots):
        region = {"variable": "time", "low": 1500.0, "high": 1e5}
        return replace(law, mask=lambda p: (p.time > 1500.0) * np.ones(p.z.shape), region=(region,))
    if rng.random() < 0.5:
        limit = float(np.median([np.nanmedian(shot.hits.z) for shot in shots]))
        region = {"variable": "depth", "low": limit, "high": 1e5}
        return replace(law, mask=lambda p: (np.nan_to_num(p.z) > limit).astype(float), region=(region,))
    region = {"variable": "u", "low": shots[0].camera.width / 2, "high": shots[0].camera.width}
    return replace(law, mask=lambda p: (p.u > p.shot.camera.width / 2).astype(float), region=(region,))


def _sized(law: Law, device: Flight | Matching, shots: list[Shot], ratio: float) -> Law:
    """The law with a size that makes its root mean square `ratio` times the noise of a frame."""
    squares, count = 0.0, 0
    for shot in shots:
        for frame in range(0, len(shot.times), 5) if shot.long else [0]:
            change = (device.clean(shot, [law], frame) - device.clean(shot, [], frame)) / device.sigma(shot)
            inside = change[shot.interior & (shot.hits.z > 0)]
            squares, count = squares + float(np.nansum(inside**2)), count + inside.size
    return replace(law, size=ratio / max(np.sqrt(squares / max(count, 1)), 1e-9))


def _sign(law: Law, rng: Rng) -> int:
    """Light adds up; everything else may go either way."""
    way = int(rng.choice([-1, 1]))
    return 1 if law.stage == "light" else way


def _masking(plan: Plan, rng: Rng) -> Plan:
    """A known offset, several times larger than the effect, whose stated value is slightly off."""
    unit = 1e-3 if plan.flight else 0.01
    name, symbol = ("depth_offset", "m") if plan.flight else ("disparity_offset", "px")
    size = float(rng.choice([-1, 1]) * rng.uniform(3, 8))
    std = 0.05 * abs(size) * unit
    stage = "delay" if plan.flight else "disparity"

    def acts(p: Place) -> Array:
        return unit * np.ones(p.z.shape)

    law = Law(name, stage, acts, (), size=size)
    about = {"name": name, "unit": symbol, "true": size * unit, "std": std}
    about["value"] = size * unit + std * float(np.clip(rng.standard_normal(), -2, 2))
    return replace(plan, known=[law], stated=about)
