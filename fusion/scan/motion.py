"""The stage that finds what turns, how, and the camera that the scan itself settles."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.recording.recording import Recording
from fusion.scan.finding.attempt import attempt
from fusion.scan.finding.pair_fit import Asked
from fusion.scan.finding.settled_camera import settle_camera
from fusion.scan.finding.turn import turned
from fusion.scan.opening import OpenedScan
from fusion.turntable.focal import FocalCheck
from fusion.turntable.motion import Motion
from fusion.turntable.views import Region
from fusion.volume.prepared import Prepared


@dataclass(frozen=True)
class FoundMotion:
    """What turns and how, as the camera sees it that is used."""

    opened: OpenedScan  # the recording, and what was asked for
    recording: Recording  # with corrected depth, and the camera that is used
    region: Region  # where the object is
    # cut to its window, without what stands behind the object and without the errors of depth that the motion was found
    # with; None where one cannot be read
    frames: list[Prepared | None]
    motion: Motion  # with the frames that cannot be read among the rejected
    told: NDArray[np.float64] | None  # (n,) angles [rad] that log or stated step say, or None
    focal: FocalCheck  # what the scan says of the stated focal length


def find_motion_and_camera(opened: OpenedScan) -> FoundMotion:
    """The motion, and the camera that it was found with: pairs of views settle the camera, the model of all the rest.

    Raises:
        RecordingError: too few readable frames.
        TrackingError: nothing turns, or not about one axis.
    """
    settled, focal = settle_camera(attempt(Asked(opened.recording, opened.sensor, opened.settings)))
    motion, frames = turned(settled)
    return FoundMotion(opened, settled.asked.recording, settled.region, frames, motion, settled.told, focal)
