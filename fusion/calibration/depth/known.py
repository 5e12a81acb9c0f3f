"""Where a depth calibration starts: which camera, what is known of the sensor, and whether they belong together."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fusion.calibration.depth.laws.law_sensor import FITTED
from fusion.errors import FusionError, SensorError
from fusion.geometry.camera import Camera, Principle
from fusion.recording.recording import Recording
from fusion.sensor.correction.unit import refuse_other_unit
from fusion.sensor.effects.readout.depth_scale import DepthScale
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import stretch

NO_PRINCIPLE = (
    "how the camera measures is not stated: errors of a disparity or waves over the range are not looked for, and what "
    'they do is left; state it ("principle" in camera.json: structured_light, active_stereo or itof)'
)

ALONG_STATED = (
    "ok",
    "depth is along the rays of the stated camera; the map in depth_scale takes it to those of --camera",
)


@dataclass(frozen=True)
class Start:
    """What is known before the walls are seen."""

    camera: Camera  # calibrated
    known: Sensor  # effects that are undone first, the ratio of rays among them
    uncorrected: Sensor  # the same model without that ratio: what the new law is added to
    # (h, w) length of the true ray over that of the stated one, where the sensor measures along the ray and the camera
    # was calibrated since; None when they are the same
    ratio: NDArray[np.floating] | None
    # sensor, serial: of the camera
    sensor: str
    serial: str
    notes: tuple[tuple[str, str], ...]  # ("ok" or "warning", sentence)


def start(recordings: Sequence[Recording], camera: Camera | None, sensor: Sensor | None, force: bool = False) -> Start:
    """Check that recordings, camera and model are of one unit, and take from the model what is to be fitted again.

    Raises:
        FusionError: they are not, and `force` is not set; the images differ in size.
    """
    own = recordings[0].camera
    names = _one_unit(recordings, camera, force)
    right = camera or own
    principle = own.principle.or_else(right.principle)
    notes = [("warning", f"{recording.path.name}: {text}") for recording in recordings for text in recording.warnings]
    model = sensor or Sensor(principle=principle)
    if sensor is not None:
        refuse_other_unit(sensor, replace(own, sensor=names[0], serial=names[1]), force)
        if model.principle.or_else(principle) != principle.or_else(model.principle) and not force:
            raise SensorError("the sensor model is of another principle", model.name, model.principle, principle)
    model = replace(model, principle=principle.or_else(model.principle))
    model, texts = _without_usual(model)
    notes += [("ok", text) for text in texts]
    if sensor is None:
        model = replace(model, name=names[0] or "calibrated")
    if model.principle == Principle.UNKNOWN:
        notes.append(("warning", NO_PRINCIPLE))
    # a law that was fitted has it in it already, or walls said that there is none
    open_ = model.principle == Principle.TIME_OF_FLIGHT and not model.fitted & set(FITTED)
    ratio = _ratio(own, right) if open_ else None
    old = model.effect("depth_scale")
    scale = 1 + np.asarray(old.scale) if isinstance(old, DepthScale) else 1.0
    known = model if ratio is None else model.having(DepthScale(np.asarray(scale * ratio - 1, float)))
    if ratio is not None:
        notes.append(ALONG_STATED)
    return Start(replace(right, principle=model.principle), known, model, ratio, *names, tuple(notes))


def _without_usual(model: Sensor) -> tuple[Sensor, list[str]]:
    """The model without effects whose values are usual ones, and what was done, in words.

    A calibration may fit these; what is known of the unit stays and is not fitted a second time.
    """
    again = [e.name for e in model.effects if e.name in FITTED and model.why_not_corrected(e)]
    kept = [e.name for e in model.effects if e.name in FITTED and e.name not in again]
    texts = ["fitted here, as --sensor holds only usual values: " + ", ".join(again)] if again else []
    texts += [f"kept as --sensor has it, and not fitted again: {', '.join(kept)}"] if kept else []
    clean = replace(
        model,
        effects=tuple(e for e in model.effects if e.name not in again),
        std={key: value for key, value in model.std.items() if key[0] not in again},
        sources={key: value for key, value in model.sources.items() if key not in again},
        left_out=(),
    )
    return clean, texts


def _ratio(stated: Camera, right: Camera) -> NDArray[np.floating] | None:
    """z stated over z true of the same range, (h, w); None when it is 1 everywhere."""
    ratio = stretch(right).astype(float) / stretch(stated).astype(float)
    return ratio if np.abs(ratio - 1).max() > 1e-6 else None


def _one_unit(recordings: Sequence[Recording], camera: Camera | None, force: bool) -> tuple[str, str]:
    """Name and serial of the one camera that made all recordings."""
    cameras = [(str(r.path), r.camera) for r in recordings] + ([("--camera", camera)] if camera else [])
    found = []
    for field in ("sensor", "serial"):
        stated = {getattr(c, field): where for where, c in cameras if getattr(c, field)}
        if len(stated) > 1 and not force:
            (first, _), (second, where) = list(stated.items())[:2]
            do = "calibrate each unit by itself, or pass --force"
            raise FusionError(f"recordings of different cameras ({field})", where, second, first, do)
        found.append(next(iter(stated), ""))
    expected = cameras[0][1]
    for where, c in cameras:
        if c.shape != expected.shape:
            sizes = f"{c.width} x {c.height} px", f"{expected.width} x {expected.height} px"
            raise FusionError("images of different sizes", where, *sizes)
    return found[0], found[1]
