"""What the main things say of themselves fits in two lines, whatever they hold."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh

import fusion

CAMERA = fusion.Camera(64, 48, 60.0, 60.0, 31.5, 23.5)
POSES = fusion.Trajectory(np.arange(500.0), np.tile(np.eye(4), (500, 1, 1)))
BALL = fusion.Mesh.from_trimesh(trimesh.creation.icosphere(4, 0.05))


def recording():
    frame = fusion.Frame(0, 0.0, np.ones((48, 64), np.float32), np.zeros((48, 64, 3), np.uint8))
    return fusion.Recording(Path("some/folder/my_scan"), "made", CAMERA, np.arange(500.0), lambda i: frame, POSES)


def volume():
    made = fusion.Volume(fusion.VolumeSettings(0.01, 0.04))
    made.integrate(np.ones((48, 64)), CAMERA, np.eye(4))
    return made


SHOWN = {
    "Camera": lambda: replace(CAMERA, color=CAMERA, T_color_depth=np.eye(4), distortion=(0.1,), sensor="a sensor"),
    "Trajectory": lambda: POSES,
    "Recording": recording,
    "empty Recording": lambda: replace(recording(), timestamps=np.zeros(0)),
    "Frame": lambda: recording()[0],
    "Sensor": lambda: fusion.read_sensor("kinect-v2-indoors"),
    "Mesh": lambda: replace(BALL, scalars={"sigma": np.zeros(len(BALL.vertices), np.float32)}),
    "empty Mesh": lambda: fusion.Mesh(np.zeros((0, 3))),
    "Mesh without finite points": lambda: fusion.Mesh(np.full((3, 3), np.nan)),
    "Comparison": lambda: fusion.compare(BALL, BALL, fusion.CompareSettings(samples=1000)),
    "Repeat": lambda: fusion.repeat([BALL, fusion.Mesh(BALL.vertices + 0.001, BALL.faces)]),
    "Volume": volume,
    "DenseField": lambda: volume().to_numpy(),
    "empty DenseField": lambda: fusion.Volume(fusion.VolumeSettings(0.01, 0.04)).to_numpy(),
    "Simulation": lambda: fusion.simulate(fusion.built_in("wall"), fusion.Sensor()),
}


@pytest.mark.parametrize("name", SHOWN)
def test_two_lines_at_most_and_no_array(name):
    text = repr(SHOWN[name]())
    assert text.startswith("<" + name.split()[-1] if name.startswith("empty") else "<")
    assert len(text.splitlines()) <= 2
    assert max(map(len, text.splitlines())) < 260  # two lines of a wide terminal
    assert "array(" not in text and "[" not in text


def test_they_say_what_is_there():
    assert repr(BALL) == "<Mesh: 2,562 vertices, 5,120 triangles, 100 x 100 x 100 mm>"
    assert repr(recording()) == ("<Recording my_scan: made, 500 frames of 64 x 48 in 499.0 s; depth, poses>")
    assert repr(recording()[0]) == "<Frame 0: 64 x 48, depth, color, 0.000 s>"
    assert repr(CAMERA) == "<Camera: 64 x 48, fx 60.00 fy 60.00 cx 31.50 cy 23.50 px>"
