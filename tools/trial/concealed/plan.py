"""Plan: what is concealed in a case, drawn by family."""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from tools.trial.concealed.decks import Setting, shots_of
from tools.trial.concealed.drawing import choice, masking, partly, quiet, sign, sized
from tools.trial.concealed.laws.flight import Flight
from tools.trial.concealed.laws.law import Law
from tools.trial.concealed.laws.matching import Matching
from tools.trial.concealed.rig import Table, table_of
from tools.trial.concealed.shot import Shot

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
    "absorbed",
    "wrong metadata",
    "decoy",
    "rig",
    "injected",
)
POWER = "power"  # drawn only when asked for: known effects over a ladder of sizes
LADDER = (0.02, 0.05, 0.1, 0.2)
# root mean square of the concealed effect over the noise of a single frame
STRENGTH = {"below noise": (0.05, 0.2), "masked": (0.15, 0.5), "partial": (0.2, 0.8), "absorbed": (0.02, 0.2)}
USUAL = (0.3, 1.2)
LOOSE_POSES = 12.0  # times the usual error: what nobody surveyed takes a plane's offset, scale and tilt with it


@dataclass(frozen=True)
class Plan:
    """Attributes:
    shots: recordings in order; of a rig, those of the table alone.
    missing: laws at work that the sensor model does not hold.
    known: laws at work that it holds, with their true size.
    stated: name of the known law's parameter, its unit, stated value and standard deviation.
    metadata: what is wrong or missing beside the pictures: "pose", "log", "reflectance", or nothing.
    decoy: the covariate that goes along with the true one.
    ratio: size over the noise of a frame, where that is what is asked.
    table: the turntable, where there is one.
    """

    family: str
    setting: Setting
    device: Flight | Matching
    shots: list[Shot]
    missing: list[Law]
    known: list[Law] = field(default_factory=list)
    stated: dict[str, Any] = field(default_factory=dict)
    notes: str = ""
    metadata: str = ""
    decoy: str = ""
    ratio: float | None = None
    table: Table | None = None

    @property
    def flight(self) -> bool:
        return isinstance(self.device, Flight)

    @property
    def unmoved(self) -> list[Shot]:
        """The shots as they would be if the table turned as it says."""
        return self.shots if self.table is None else [shot for run in self.table.stated for shot in run]

    @property
    def mesh_sigma_m(self) -> float:
        return self.setting.bow_m


def plan(family: str, rng: Rng) -> Plan:
    """A case of a family."""
    flight = bool(rng.random() < 0.5)
    device: Flight | Matching = Flight() if flight else Matching()
    if family == "rig":
        table, law, device = *table_of(rng), Matching()
        shots = [shot for run in table.really for shot in run]
        laws = [] if law is None else [law]
        notes = "turntable" if law is None else law.name
        return Plan(family, Setting("turntable", False), device, shots, laws, notes=notes, table=table)
    if family in ("null", "hard null"):
        setting, notes = quiet(family, flight, rng)
        return Plan(family, setting, device, shots_of(rng, setting), [], notes=notes)
    if family == "wrong metadata":
        return _misled(flight, device, rng)
    names, makers, deck = choice(family, flight, rng)
    loose = LOOSE_POSES if family == "absorbed" else 1.0
    setting = Setting(deck, flight, poses=loose, stated=loose)
    shots = shots_of(rng, setting)
    laws = [makers[name](rng) for name in names]
    if family == "partial":
        laws = [partly(laws[0], shots, setting, rng)]
    low, high = STRENGTH.get(family, USUAL)
    ratio = float(rng.choice(LADDER)) if family == POWER else None
    if family != "spread":
        sizes = [ratio or rng.uniform(low, high) for _ in laws]
        laws = [sized(law, device, shots, size * sign(law, rng)) for law, size in zip(laws, sizes, strict=True)]
    out = Plan(family, setting, device, shots, laws, notes=" ".join(names), ratio=ratio)
    if family == "decoy":
        return replace(out, decoy={"trend": "time", "sides": "u"}[deck])
    if family != "masked":
        return out
    law, stated = masking(flight, rng)
    return replace(out, known=[law], stated=stated)


def _misled(flight: bool, device: Flight | Matching, rng: Rng) -> Plan:
    """Poses worse than stated, no temperature log, or a mesh of one grey; one in three with nothing missing."""
    how = str(rng.choice(["pose", "log", "reflectance"]))
    nothing = how != "log" and bool(rng.random() < 1 / 3)
    names, makers, deck = choice("plain", flight, rng)
    while names[0] in ("multipath", "stray_light"):  # they need what is not told here
        names, makers, deck = choice("plain", flight, rng)
    if how == "log":
        names, deck = ["temperature_drift"], "warm"
    if how == "reflectance":
        deck = "warm" if deck == "warm" else "patches"
    setting = Setting(deck, flight, poses=2.0 if how == "pose" else 1.0)
    shots = shots_of(rng, setting)
    laws = [] if nothing else [makers[name](rng) for name in names]
    laws = [sized(law, device, shots, rng.uniform(*USUAL) * sign(law, rng)) for law in laws]
    notes = how if nothing else f"{how} {names[0]}"
    return Plan("wrong metadata", setting, device, shots, laws, notes=notes, metadata=how)
