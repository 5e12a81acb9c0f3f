"""What a table was told is asked before it is believed."""

from pathlib import Path

import numpy as np
import pytest

from fusion.errors import FusionError, TrackingError
from fusion.geometry.camera import Camera
from fusion.recording.recording import Recording
from fusion.scan.finding.frames import told_angles
from fusion.scan.settings import ScanSettings
from fusion.turntable.axis import Axis
from fusion.turntable.pairs.edges import AskedErrors, edge_sums
from fusion.turntable.selfcheck import SelfCheck


def logged(angles: list[float]) -> Recording:
    stamps = np.arange(len(angles), dtype=float)
    telemetry = {"timestamp": stamps, "turntable_deg": np.array(angles)}
    camera = Camera(width=4, height=4, fx=4, fy=4, cx=1.5, cy=1.5)
    unread = lambda index: pytest.fail("no frame is read")  # noqa: E731
    return Recording(Path("scan"), "native", camera, stamps, unread, telemetry=telemetry)


@pytest.mark.parametrize("worst", [1e7, -1e300])
def test_angles_that_no_table_counts_are_told_before_any_frame_is_read(worst):
    with pytest.raises(FusionError, match=r"log is not possible.*turntable_deg.*--ignore-log"):
        told_angles(logged([0, 15, worst, 45]), ScanSettings())
    assert told_angles(logged([0, 15, worst, 45]), ScanSettings(use_log=False)) is None


def test_a_usual_log_is_taken_as_it_is():
    np.testing.assert_allclose(told_angles(logged([0, 15, 30, 45]), ScanSettings()), np.deg2rad([0, 15, 30, 45]))


def test_views_without_any_overlap_are_told_with_their_turn():
    axis = Axis(np.array([0, 0, 1.0]), np.array([0, -1.0, 0]))
    angles = np.deg2rad([0, 90, 180, 270.0])
    with pytest.raises(TrackingError, match=r"no two views overlap.*90 deg.*check --step, or turntable_deg"):
        edge_sums(None, (axis, angles), [], 0.03, AskedErrors(SelfCheck(np.zeros(10), 0.5, 1.0)))
