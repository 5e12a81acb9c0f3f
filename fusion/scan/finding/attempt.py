"""The motion of a scan, and the focal length that the scan itself settles."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fusion.recording.images.masks import open_masks
from fusion.recording.recording import Recording
from fusion.scan.finding.frames import load, told_angles
from fusion.scan.finding.pair_fit import Asked
from fusion.scan.finding.region import find_region
from fusion.scan.finding.relieved import relieved
from fusion.scan.finding.turn import motion_alone
from fusion.scan.settings import ScanSettings
from fusion.sensor.sensor import Sensor
from fusion.turntable.motion import Motion
from fusion.turntable.views import Region
from fusion.volume.prepared import Prepared

FEW = 0.05  # of the frames: fewer that something passes before do not pull a motion that all agree on (guess)


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
    moved = motion_alone(frames, asked, region, told, start)
    if told is None and moved.passed > FEW:  # what passes pulls the views along
        moved = motion_alone(moved.frames, asked, region, told, moved.motion)
    motion, frames = moved.motion, relieved(moved.frames, moved.motion.taken_out)
    if told is not None:
        both = zip(frames, loaded, strict=True)
        frames = [f if f is None or seen is None else replace(f, color=seen.color) for f, seen in both]
    return Attempt(recording, region, frames, replace(motion, rejected={**motion.rejected, **broken}), told)
