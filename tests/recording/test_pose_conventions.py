"""Poses that another program wrote are read as it meant them, where the user says so."""

import numpy as np
import pytest
import synthetic

from fusion.commands.main import main
from fusion.commands.options.posed import NAMES
from fusion.geometry.conventions import CONVENTIONS
from fusion.geometry.pose import inverse
from fusion.geometry.trajectory import Trajectory
from fusion.recording.native.trajectory_file import read_trajectory, write_trajectory
from fusion.recording.writing.write import write_recording

UP = np.diag([1.0, -1, -1, 1])  # y up and z back for y down and z forward
WRITTEN = {"opengl": lambda T: T @ UP, "world-to-camera": inverse, "opengl-view": lambda T: inverse(T @ UP)}


@pytest.fixture
def folder(tmp_path):
    path = tmp_path / "r"
    write_recording(path, synthetic.CAMERA, synthetic.frames(4), synthetic.trajectory(4))
    return path


def test_the_options_are_those_that_are_known():
    assert set(NAMES) == set(CONVENTIONS)


@pytest.mark.parametrize("name", WRITTEN)
@pytest.mark.parametrize("own", [True, False])
def test_poses_of_a_convention_are_converted(folder, tmp_path, name, own, capsys):
    true = synthetic.trajectory(4)
    place = folder / "groundtruth.txt" if own else tmp_path / "poses.txt"
    write_trajectory(place, Trajectory(true.timestamps, WRITTEN[name](true.poses)))
    given = [] if own else ["--poses", str(place)]
    assert main(["convert", str(folder), str(tmp_path / "out"), "--pose-convention", name, *given]) == 0
    read = read_trajectory(tmp_path / "out" / "groundtruth.txt")
    assert np.allclose(read.poses, true.poses, atol=1e-6)


def test_a_convention_of_no_poses_is_refused(folder, tmp_path, capsys):
    (folder / "groundtruth.txt").unlink()
    given = ["convert", str(folder), str(tmp_path / "out"), "--pose-convention", "ros"]
    assert main(given) == 1
    assert "states no poses" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
