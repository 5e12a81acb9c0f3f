"""What pairs of views say of the motion of a scan, as one camera sees it."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Camera
from fusion.recording.images.masks import open_masks
from fusion.scan.finding.alone import object_alone
from fusion.scan.finding.frames import load, seen_again, told_angles
from fusion.scan.finding.pair_fit import Asked, PairFit, fit_pairs
from fusion.scan.finding.passing import Clear, without_passing
from fusion.scan.finding.region import find_region
from fusion.turntable.axis import about_axis
from fusion.turntable.motion import Motion
from fusion.turntable.views import Region
from fusion.volume.prepared import Prepared

FEW = 0.05  # of the frames: fewer that something passes before do not pull a motion that all agree on (guess)


@dataclass(frozen=True)
class Attempt:
    """A scan as one camera sees it."""

    asked: Asked  # the recording with the depth that the sensor's model corrects, and the camera; the settings
    region: Region  # where the object is
    frames: list[Prepared | None]  # cut to its window; None where one cannot be read
    fit: PairFit  # what pairs of these say
    told: NDArray[np.float64] | None  # (n,) angles [rad] that log or stated step say, or None
    broken: dict[int, str]  # frames that cannot be read, and why

    @property
    def camera(self) -> Camera:
        return self.asked.recording.camera

    @property
    def misfit(self) -> float:
        """Residual of the frames over the share of the surface that fits [m]: what is left out is no better."""
        motion = self.fit.motion
        support = float(np.nanmedian(motion.support))
        return float(np.nanmedian(motion.residual)) / max(support, 1e-3)

    def of_object(self, motion: Motion) -> Clear:
        """The frames of the object alone, without what passes before it."""
        region = self.region.cut(self.region.window(self.camera))
        alone = object_alone(self.frames, region, motion)
        return without_passing(alone, region, about_axis(motion.axis, motion.angles, motion.shifts))


def attempt(asked: Asked, look_below: bool = True) -> Attempt:
    """Find what turns and how; `look_below`, see `find_region`.

    Raises:
        RecordingError: too few readable frames.
        TrackingError: nothing turns, or not about one axis.
    """
    recording, settings = asked.recording, asked.settings
    masks = None if settings.mask is None else open_masks(settings.mask, recording)
    told = told_angles(recording, settings)
    region = find_region(recording, asked.sensor, settings, masks, look_below and told is None)
    frames, broken = load(recording, asked.sensor, region, masks, settings.color)
    first = Attempt(asked, region, frames, fit_pairs(frames, asked, region, told), told, broken)
    if told is not None:
        return first
    clear = first.of_object(first.fit.motion)
    if clear.pulled <= FEW:
        return first
    fit = fit_pairs(clear.frames, asked, region, None, first.fit.motion)  # what passes pulls the views along
    return replace(first, frames=clear.frames, fit=fit)


def seen_by(camera: Camera, before: Attempt) -> Attempt:
    """The attempt as a camera of another focal length sees it.

    Where all views turn about one axis by themselves, the same pixels show the object, and its motion is known but for
    the camera. All else is sought anew: the other camera may place frames that had no place, and what print, a hand or
    a log holds.

    Raises:
        RecordingError, TrackingError: as of `attempt`.
    """
    asked, motion = replace(before.asked, recording=replace(before.asked.recording, camera=camera)), before.fit.motion
    if before.told is not None or motion.held or any(before.frames[i] is not None for i in motion.rejected):
        return attempt(asked, look_below=before.region.below is not None)
    squeeze = np.array([before.camera.fx / camera.fx] * 2 + [1.0])
    region = replace(before.region, low=squeeze * before.region.low, high=squeeze * before.region.high)
    window = region.window(camera)
    if window == before.region.window(before.camera) and not (asked.settings.color and asked.recording.color_is_apart):
        loaded = seen_again(before.frames, asked.recording, asked.sensor, window)
    else:
        loaded, _ = load(asked.recording, asked.sensor, region, color=asked.settings.color)
    both = zip(loaded, before.frames, strict=True)
    frames = [None if f is None or b is None else f.masked(np.isfinite(b.depth)) for f, b in both]
    direction = squeeze * motion.axis.direction
    axis = replace(motion.axis, point=squeeze * motion.axis.point, direction=direction / np.linalg.norm(direction))
    fit = fit_pairs(frames, asked, region, None, replace(motion, axis=axis))
    return replace(before, asked=asked, region=region, frames=frames, fit=fit)
