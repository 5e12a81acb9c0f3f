"""The motion of a scan, and the focal length that the scan itself settles."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fusion.errors import TrackingError
from fusion.geometry.camera import Camera
from fusion.recording.images.masks import open_masks
from fusion.recording.recording import Recording
from fusion.scan.finding.frames import find_region, load, object_alone, told_angles
from fusion.scan.finding.passing import without_passing
from fusion.scan.finding.plate_seen_whole import on_its_plate
from fusion.scan.finding.poses import about_axis
from fusion.scan.finding.relieved import relieved
from fusion.scan.finding.turn import Asked, find_motion
from fusion.scan.settings import ScanSettings
from fusion.sensor.sensor import Sensor
from fusion.turntable.all_views.together import WORTH
from fusion.turntable.axis import Axis
from fusion.turntable.focal import SURE, FocalCheck, focal_of
from fusion.turntable.motion import Motion
from fusion.turntable.views import Region
from fusion.volume.prepared import Prepared

FEW = 0.05  # of the frames: fewer that something passes before do not pull a motion that all agree on (guess)
ROUNDS = 2  # corrections of the focal length: each starts from a nominal one, pairs points anew and is nearer


@dataclass(frozen=True)
class Attempt:
    """A scan as one camera sees it.

    Attributes:
        recording: with the depth that the sensor's model corrects, and the camera.
        region: where the object is.
        frames: cut to its window, without what stands behind the object and without the errors of depth that the
            motion was found with; None where one cannot be read.
        motion: with the frames that cannot be read among the rejected.
        told: (n,) angles [rad] that log or stated step say, or None.
    """

    recording: Recording
    region: Region
    frames: list[Prepared | None]
    motion: Motion
    told: NDArray[np.float64] | None

    @property
    def misfit(self) -> float:
        """Residual of the frames over the share of the surface that fits [m]: what is left out is no better."""
        support = float(np.nanmedian(self.motion.support))
        return float(np.nanmedian(self.motion.residual)) / max(support, 1e-3)


def attempt(recording: Recording, sensor: Sensor, settings: ScanSettings, start: Motion | None = None) -> Attempt:
    """Find what turns and how; `start` is its motion where that is known but for the camera: no turn is sought anew.

    Raises:
        RecordingError: too few readable frames.
        TrackingError: nothing turns, or not about one axis.
    """
    masks = None if settings.mask is None else open_masks(settings.mask, recording)
    region = find_region(recording, sensor, settings, masks)
    told = told_angles(recording, settings)
    loaded, broken = load(recording, sensor, region, masks, settings.color)
    # print helps to find what nothing was told of; where something was, it judges what came of that
    frames = loaded if told is None else [None if f is None else replace(f, color=None) for f in loaded]
    asked = Asked(recording, sensor, settings)
    moved = _moved(frames, asked, region, told, start)
    if told is None and moved.passed > FEW:  # what passes pulls the views along
        moved = _moved(moved.frames, asked, region, told, moved.motion)
    motion, frames = moved.motion, relieved(moved.frames, moved.motion.taken_out)
    if told is not None:
        both = zip(frames, loaded, strict=True)
        frames = [f if f is None or seen is None else replace(f, color=seen.color) for f, seen in both]
    return Attempt(recording, region, frames, replace(motion, rejected={**motion.rejected, **broken}), told)


@dataclass(frozen=True)
class _Moved:
    """A motion, the frames of the object alone, and the share of them before which something passed."""

    motion: Motion
    frames: list[Prepared | None]
    passed: float


def _moved(
    frames: list[Prepared | None],
    asked: Asked,
    region: Region,
    told: NDArray[np.float64] | None,
    start: Motion | None = None,
) -> _Moved:
    motion = find_motion(frames, asked, region, told, start)
    if start is not None:
        motion = replace(motion, rejected={**motion.rejected, **start.rejected})
    motion = on_its_plate(motion, asked.recording, asked.sensor)
    cut = region.cut(region.window(asked.recording.camera))
    alone = object_alone(frames, cut, motion)
    clean = without_passing(alone, cut, about_axis(motion.axis, motion.angles, motion.shifts))
    changed = [a is not b for a, b in zip(alone, clean, strict=True)]
    return _Moved(motion, clean, float(np.mean(changed)))


def settle_camera(first: Attempt, sensor: Sensor, settings: ScanSettings) -> tuple[Attempt, FocalCheck]:
    """The attempt with the camera that is used, and what the scan says of the stated focal length.

    A scan that contradicts its camera is tried with the focal length that it asks for. Where it fits no better so,
    something else is wrong, and the claim is withdrawn. Where it does, and the camera is only nominal or it is asked
    for, that focal length is taken, and made better once more.
    """
    camera = first.recording.camera
    claim = focal_of(first.motion)
    forced = settings.refine_camera is True
    if not forced and claim.deviations(camera) <= SURE:
        return first, claim
    second = _with_focal_length_of(first, sensor, settings)
    if not forced and (second is None or second.misfit > WORTH * first.misfit):
        return first, claim.withdrawn()
    if second is None or not (forced or refines(settings, camera)):
        return first, claim
    for _ in range(ROUNDS - 1):
        left = focal_of(second.motion)
        third = _with_focal_length_of(second, sensor, settings) if abs(left.relative) > left.std else None
        if third is None or third.misfit > second.misfit / WORTH:
            break
        second = third
    taken = second.recording.camera.fx / camera.fx - 1
    return second, replace(focal_of(second.motion), relative=taken)


def refines(settings: ScanSettings, camera: Camera) -> bool:
    """Whether a focal length that the scan contradicts may be replaced: as asked, else where it is only nominal."""
    return "fx" not in camera.std if settings.refine_camera is None else settings.refine_camera


def _with_focal_length_of(found: Attempt, sensor: Sensor, settings: ScanSettings) -> Attempt | None:
    """The same with the focal length that this attempt asks for; None where nothing turns then.

    The principal point is free in that fit, or its error would pull the focal length along; but it is not taken over:
    depth errors imitate it, and what it is wrong by turns the whole scan, nearly, and bends nothing. Measured on the
    statue of the open challenges, nominal camera: distance std 0.60 mm with the focal length alone, 1.47 mm with both.
    """
    before = found.recording.camera
    camera = found.motion.focal_check.only("focal").camera(before)
    lost = [i for i in found.motion.rejected if found.frames[i] is not None]  # the other camera may place them
    known = found.told is None and not lost and not found.motion.held  # what print or a hand holds is sought again
    start = replace(found.motion, axis=_seen_by(found.motion.axis, before.fx / camera.fx)) if known else None
    try:
        return attempt(replace(found.recording, camera=camera), sensor, settings, start)
    except TrackingError:
        return None


def _seen_by(axis: Axis, smaller: float) -> Axis:
    """An axis where a camera sees it to whose focal length all is `smaller` across its line of sight."""
    squeeze = np.array([smaller, smaller, 1.0])
    direction = squeeze * axis.direction
    return Axis(squeeze * axis.point, direction / np.linalg.norm(direction))
