"""Rows whose recordings the trial's generator makes: a law at work that the sensor model does not hold."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from tools.trial.concealed.decks import Setting, shots_of
from tools.trial.concealed.drawing import sign, sized
from tools.trial.concealed.laws.flight import Flight
from tools.trial.concealed.laws.law import Law
from tools.trial.concealed.laws.matching import Matching
from tools.trial.concealed.making import written
from tools.trial.concealed.plan import Plan
from tools.trial.once_wrong.row import NOTHING, Makes, Rng
from tools.trial.spoiled.bases import MOST, Base
from tools.trial.spoiled.case import Spoiled, opened

Maker = Callable[[Rng], Law]


def planted(
    deck: str, flight: bool, *makers: Maker, strength: float | None = None, device: Matching | None = None,
    family: str = "plain", unsaid: str = "",
) -> Makes:  # fmt: skip
    """Recordings with laws at work.

    Args:
        strength: root mean square over the noise of a frame; None where a maker says itself how large its law is.
        device: instead of the usual one.
        unsaid: an effect at work that is taken out of sensor.json, and that is what is missing.
    """

    def make(variant: int, rng: Rng, folder: Path) -> tuple[Base, Spoiled]:
        setting = Setting(deck, flight)
        own: Flight | Matching = device or (Flight() if flight else Matching())
        shots = shots_of(rng, setting)
        laws = [maker(rng) for maker in makers]
        if strength is not None:
            laws = [sized(law, own, shots, strength * sign(law, rng)) for law in laws]
        label = written(Plan(family, setting, own, shots, laws), [variant], folder, rng).label
        missing = tuple(label["missing"])
        if unsaid:
            _take_out(unsaid, folder / "sensor.json")
            missing = ({"effect": unsaid, "accept": []},)
        case = opened(folder, MOST)
        return Base(deck, case, missing, (), tuple(label["equivalent"])), Spoiled(case, "", NOTHING)

    return make


def of_size(maker: Maker, size: float) -> Maker:
    """A law as large as it is said, times its unit."""
    return lambda rng: replace(maker(rng), size=size)


def _take_out(effect: str, file: Path) -> None:
    sensor = json.loads(file.read_text(encoding="utf-8"))
    sensor["effects"] = [entry for entry in sensor["effects"] if entry["effect"] != effect]
    file.write_text(json.dumps(sensor, indent=1), encoding="utf-8")
