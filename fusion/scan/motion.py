"""The stage that finds what turns, how, and the camera that the scan itself settles."""

from dataclasses import dataclass

from fusion.scan.finding.attempt import Attempt, attempt
from fusion.scan.finding.settled_camera import settle_camera
from fusion.scan.opening import OpenedScan
from fusion.turntable.focal import FocalCheck


@dataclass(frozen=True)
class FoundMotion:
    """What turns and how, as the camera sees it that is used.

    Attributes:
        opened: the recording, and what was asked for.
        attempt: with the camera that is used.
        focal: what the scan says of the stated focal length.
    """

    opened: OpenedScan
    attempt: Attempt
    focal: FocalCheck


def find_motion_and_camera(opened: OpenedScan) -> FoundMotion:
    """The motion, and the camera that it was found with.

    Raises:
        RecordingError: too few readable frames.
        TrackingError: nothing turns, or not about one axis.
    """
    first = attempt(opened.recording, opened.sensor, opened.settings)
    return FoundMotion(opened, *settle_camera(first, opened.sensor, opened.settings))
