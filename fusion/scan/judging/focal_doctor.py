"""A check for the input doctor: a turntable recording says by itself whether the focal length is right."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fusion.errors import FusionError
from fusion.geometry.robust import DOUBT, SURE
from fusion.progress import stage
from fusion.recording.checks.stillness import turns_before_a_still_camera, turns_by_its_log
from fusion.recording.looking.finding import Finding
from fusion.recording.looking.sample import Sample
from fusion.recording.recording import Recording
from fusion.scan.finding.frames import load, told_angles
from fusion.scan.finding.region import find_region
from fusion.scan.settings import ScanSettings
from fusion.sensor.presets import default_sensor
from fusion.sensor.sensor import Sensor
from fusion.turntable.all_views.camera_fit import SYSTEMATIC
from fusion.turntable.focal import FocalCheck, check_focal, typical_step
from fusion.turntable.views import ObjectView, Region, usable, view

Array = NDArray[np.float64]
FRAMES, FIRST = 32, 12  # looked at; looked at to find the step where no log tells it
STEP = np.deg2rad(12)  # between these frames: a turn and little more


def check_focal_length(sample: Sample) -> list[Finding]:
    """What turns before a camera that stands still keeps its shape only with the right focal length.

    Silent on other recordings, which cost no time, and where nothing is found to turn about one axis.
    """
    recording = sample.recording
    if not (turns_by_its_log(recording) or turns_before_a_still_camera(sample)):
        return []
    try:
        found = measure(recording)
    except FusionError:  # other checks tell what is broken; what moves need not turn
        return []
    said = f"({found.said()}, from {found.frames} frames)"
    off = found.deviations(recording.camera)
    if off <= DOUBT:
        # a robot's hall, too, has something in it that seems to turn
        close = found.std <= SYSTEMATIC
        seen = "it keeps the turning object in shape" if close else "what turns, if it does, hardly tells it"
        return [Finding("focal length", "ok", f"{seen} {said}")]
    stated, right = recording.camera.fx, recording.camera.fx * (1 + found.relative)
    seen = (
        f"about {100 * found.relative:+.0f} % from what is stated: the turning object keeps its shape with fx "
        f"{right:.0f} instead of {stated:.0f} px {said}"
    )
    do = "calibrate the camera, or pass --refine-camera to fusion turntable"
    if off > SURE and "fx" not in recording.camera.std:
        do = "calibrate the camera; fusion turntable corrects it by itself, but for --keep-camera"
    return [Finding("focal length", "warning", seen, do)]


def measure(recording: Recording) -> FocalCheck:
    """The focal length by some frames of a turntable recording.

    Raises:
        FusionError: nothing turns, or not about one axis.
    """
    sensor = default_sensor(recording.camera)
    settings = ScanSettings()
    told = told_angles(recording, settings)
    with stage("focal length", 4) as step_done:
        region = find_region(recording, sensor, settings)
        step_done()
        step = _step(recording, told, sensor, region)
        step_done()
        # a stride that leaves few frames has not found the step
        stride = min(max(1, round(STEP / max(step, 1e-4))), max(1, len(recording) // FIRST))
        views, chosen = _views(recording, np.arange(0, len(recording), stride)[:FRAMES], sensor, region)
        step_done()
        found = check_focal(views, region, None if told is None else told[chosen])
        step_done()
    return found


def _step(recording: Recording, told: Array | None, sensor: Sensor, region: Region) -> float:
    """Turn between frames [rad]."""
    if told is not None:
        steps = np.abs(np.diff(told))
        return float(np.median(steps[steps > 1e-4])) if (steps > 1e-4).any() else STEP
    if len(recording) <= FRAMES:
        return STEP
    return typical_step(_views(recording, np.arange(FIRST), sensor, region)[0], region)


def _views(
    recording: Recording, chosen: NDArray[np.intp], sensor: Sensor, region: Region
) -> tuple[list[ObjectView], NDArray[np.intp]]:
    """The views of the chosen frames that can be read, and which these are."""
    few = replace(
        recording, timestamps=recording.timestamps[chosen], load=lambda i: recording.load(int(chosen[i])), files=None
    )
    frames, broken = load(few, sensor, region)
    cut = region.cut(region.window(recording.camera))
    return [view(frame.surface, usable(frame.surface, cut)) for frame in frames if frame is not None], np.delete(
        chosen, list(broken)
    )
