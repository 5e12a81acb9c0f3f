"""A whole small scan: the object comes out right, and its code is read without going back and forth."""

import numpy as np
import pytest

from fusion.mesh.comparison.distances import signed_distances
from fusion.simulation.demo.demo import demo_truth
from tools.reproduce.followed import FRAMES, SETTINGS, followed, returns, small_recording

RETURNS = 25  # as reached; 53 when all of a scan's end stood in one file


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return followed(small_recording(tmp_path_factory.mktemp("whole") / "recording"), SETTINGS)


def test_a_small_scan_is_right(whole):
    scan, _ = whole
    assert int(scan.trajectory.valid.sum()) == FRAMES and not scan.motion.rejected and not scan.steps.slips
    assert abs(np.rad2deg(scan.steps.mean)) == pytest.approx(15.0, abs=0.05)
    assert scan.judgement.worth.word != "failed"
    distance = signed_distances(scan.mesh.vertices, demo_truth())
    # a pixel is 5 mm on the owl, as is the voxel: half of it; measured 1.9 mm
    assert np.sqrt(np.mean(distance**2)) < SETTINGS.voxel / 2 and np.abs(np.median(distance)) < SETTINGS.voxel / 5


def test_a_scan_is_followed_with_few_returns(whole):
    """A count that may only fall."""
    _, files = whole
    assert len(set(files)) > 50 and returns(files) <= RETURNS, files
