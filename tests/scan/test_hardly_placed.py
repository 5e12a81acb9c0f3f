"""Frames that cannot be placed: told as what it means for a scan, not as a circle without points."""

import numpy as np
import pytest

from fusion.errors import TrackingError
from fusion.geometry.trajectory import Trajectory
from fusion.scan.placing import _circle


def test_a_scan_of_which_hardly_a_frame_follows_the_others_says_so():
    poses = np.full((207, 4, 4), np.nan)
    poses[0] = np.eye(4)
    with pytest.raises(TrackingError, match=r"one thing that turns; found 1 of 207 frames .*hands.*--box"):
        _circle(Trajectory(np.arange(207.0), poses))
