"""The pipeline for a turntable: find what turns, place the frames, make the object, judge it."""

import numpy as np
from numpy.typing import NDArray

from fusion.recording.recording import Recording
from fusion.scan.judging.judged import judged
from fusion.scan.making import make
from fusion.scan.motion import find_motion_and_camera
from fusion.scan.opening import open_scan
from fusion.scan.placing import place
from fusion.scan.result import Scan
from fusion.scan.settings import ScanSettings

Array = NDArray[np.float64]


def scan_turntable(recording: Recording, settings: ScanSettings | None = None) -> Scan:
    """Scan an object on a turntable before a camera that stands still.

    Raises:
        RecordingError: too few readable frames.
        TrackingError: nothing turns, or not about one axis.
        VolumeError: the voxel settings make no sense or do not fit into memory.

    >>> scan = fusion.scan_turntable(fusion.open_recording("my_scan"), fusion.ScanSettings(voxel=0.004))
    >>> round(abs(np.rad2deg(scan.steps.mean)))
    15
    >>> fusion.write_mesh("cup.ply", scan.mesh)
    """
    opened = open_scan(recording, settings or ScanSettings())
    found = find_motion_and_camera(opened)
    placed = place(found)
    made = make(placed)
    return judged(made)
