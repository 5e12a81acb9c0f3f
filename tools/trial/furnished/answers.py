"""The answer of a case, which the engine does not see."""

from typing import Any

from tools.trial.furnished.motions import CameraWalk
from tools.trial.furnished.plan import Spec
from tools.trial.furnished.planted.catalogue import word
from tools.trial.furnished.planted.plant import Planted
from tools.trial.furnished.staging import DrawnStage


def answer_of(
    spec: Spec, stage: DrawnStage, moves: CameraWalk, plants: list[Planted], sigmas: list[float], notes: list[str]
) -> dict[str, Any]:
    """`truth`: names of the effects; `also_right`; `sigma`: the least visible one's own estimate of detection."""
    truth = list(dict.fromkeys(word(name) for name in spec.effects))
    also = dict.fromkeys([*stage.placed.also, *(name for one in plants for name in one.also)])
    sizes = [f"{name}: {one.size}" for name, one in zip(spec.effects, plants, strict=True)]
    return {
        "truth": truth,
        "also_right": [name for name in also if name not in truth],
        "size": "; ".join(sizes) or "0",
        "sigma": round(float(min(sigmas)), 1) if sigmas else 0.0,
        "sigmas": [round(float(x), 1) for x in sigmas],
        "kind": "; ".join([spec.kind, stage.scene.kind, stage.motion, stage.name, *notes]),
        "channel": [one.channel for one in plants],
        "note": _note(stage, moves, plants, notes),
    }


def _note(stage: DrawnStage, moves: CameraWalk, plants: list[Planted], notes: list[str]) -> str:
    sensor, frames = stage.sensor, len(moves.recordings[0].times)
    on = " and on ".join(one.variables for one in plants)
    head = f"depends on {on}. " if plants else "nothing is missing. "
    device = f"baseline {sensor.baseline} m"
    if sensor.flight:
        device = f"{sensor.taps} taps at {[f / 1e6 for f in sensor.frequencies]} MHz"
    return f"{head}{len(moves.recordings)} recordings of {frames} frames, {device}" + (
        ", " + "; ".join(notes) if notes else ""
    )
