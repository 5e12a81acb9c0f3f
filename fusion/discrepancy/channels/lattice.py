"""The lattice of the stored depths: which depths occur at all, against the steps that the model has."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.channels.channel_step import ChannelStep
from fusion.discrepancy.inference.unrounded import STEP, rounding_of
from fusion.discrepancy.observe.observations import Observations
from fusion.evaluation.quantization import LEVEL, Quantization, quantization_of
from fusion.recording.recording import Recording
from fusion.sensor.effect import Effect
from fusion.sensor.effects import EFFECTS
from fusion.sensor.parameter import parameters
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import View

COARSE = 1.5  # counts of the file: smaller steps are those of the file
ALIKE = 0.1  # of a step: windows are a dozen levels long, their ends rounded to counts
LEAST = 1e-300


def lattice_steps(observations: Observations) -> tuple[Sensor, tuple[ChannelStep, ...]]:
    """The model with the steps in which the depths come, and what was found; nothing where it has them already."""
    sensor, stored = observations.sensor, stored_of(observations)
    views = stored.counts
    law = quantization_of(views, stored.per_metre) if views else None
    if law is None or law.law not in ("z^2", "constant") or (law.value < COARSE * law.unit and law.law == "constant"):
        return sensor, ()
    view = observations.patches[0].view
    known = rounding_of(sensor)
    if known is not None and _same(known, law, view):
        return sensor, ()
    effect, std = _effect(law, view)
    step = ChannelStep(
        "bias",
        effect,
        std,
        corrected=known is not None,
        gain=0.0,
        share=1.0 - law.unit / float(np.median(law.step)),
        probability=_chance(views),
        variables=("depth",),
        text=_said(law, len(views)),
        established=_again(views, law),
    )
    return sensor.having(effect), (step,)


@dataclass(frozen=True)
class Stored:
    """How often each count of the file occurs, one array per recording, and counts per metre."""

    counts: tuple[NDArray[np.int64], ...]
    per_metre: float


def stored_of(observations: Observations) -> Stored:
    """What the files of the recordings hold; nothing where they are made up."""
    recordings = _recordings(observations)
    scale = recordings[0].camera.depth_scale if recordings else 1.0
    return Stored(tuple(_counts(one) for one in recordings), scale)


def _recordings(observations: Observations) -> list[Recording]:
    """One for each place; none of those that are planned or made up."""
    found = {p.block.place: getattr(p.block.stage, "recording", None) for p in observations.patches}
    return [recording for recording in found.values() if isinstance(recording, Recording)]


def _counts(recording: Recording) -> NDArray[np.int64]:
    """How often each count of the file occurs in the first frame: one is enough."""
    depth = np.asarray(recording[0].depth, float)
    stored = np.rint(depth[np.isfinite(depth)] * recording.camera.depth_scale).astype(np.int64)
    return np.bincount(np.clip(stored, 0, 65535))


def _same(known: Effect, law: Quantization, view: View) -> bool:
    """True where the model's step is the one that is seen, at the distances where it is."""
    steps = STEP * known.noise(np.asarray(law.depth, float), view)
    return bool(abs(np.median(law.step / np.maximum(steps, 1e-9)) - 1.0) < ALIKE)


def _effect(law: Quantization, view: View) -> tuple[Effect, dict[str, float]]:
    """The effect of the catalogue that leaves such depths, and the standard deviation of its parameter."""
    kind = next(kind for kind in EFFECTS if law.law in kind.lattice)
    growing = law.law == "z^2" and not view.time_of_flight
    name = kind.lattice[law.law if growing else "constant"]
    # a step of disparity is told at 1 m, where it is one of depth over the focal length and the base
    unit = view.focal_baseline if parameters(kind)[name].unit == "px" else 1.0
    deviation = unit * (law.interval[1] - law.interval[0]) / (2 * LEVEL)
    size = unit * law.value if growing else float(np.median(law.step))
    known: dict[str, Any] = {name: size}
    return kind(**known), {name: deviation}


def _said(law: Quantization, recordings: int) -> str:
    grows = f"{1000 * law.value:.3g} mm at 1 m, growing with the square of the distance"
    how = grows if law.law == "z^2" else f"{1000 * law.value:.3g} mm at every distance"
    seen = "recording" if recordings == 1 else f"{recordings} recordings"
    return (
        f"the depths come in steps of {how}: of the values that the file could hold, those between never occur ({seen})"
    )


def _chance(views: Sequence[NDArray[np.int64]]) -> float:
    """That values which all may occur are left out like this: each is by exp(-usual count)."""
    total: NDArray[np.float64] = np.zeros(max(len(view) for view in views))
    for view in views:
        total[: len(view)] += view
    seen = np.flatnonzero(total[1:]) + 1
    between = total[seen[0] : seen[-1] + 1]
    usual = float(between.mean())
    return float(max(np.exp(-min(usual, 50.0) * min(float((between == 0).sum()), 100.0)), LEAST))


def _again(views: Sequence[NDArray[np.int64]], law: Quantization) -> bool:
    """True when two halves of the recordings, each for itself, show the same steps."""
    halves: list[Any] = [quantization_of(views[k::2], 1.0 / law.unit) for k in (0, 1)]
    if len(views) < 2 or any(half is None for half in halves):
        return False
    return all(half.law == law.law and abs(half.value / law.value - 1.0) < ALIKE for half in halves)
