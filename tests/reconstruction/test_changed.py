"""A thing that is moved in a part of the way is told, one that stays is not."""

import numpy as np
import pytest

from fusion.geometry.camera import Camera
from fusion.geometry.pose import exp
from fusion.reconstruction.changed import FRAMES, PARTS, Changed
from fusion.recording.recording import Frame
from fusion.sensor.sensor import Sensor
from fusion.simulation.rendering.render import RayCaster
from fusion.simulation.scene.shapes import box, joined, sheet
from fusion.volume.prepared import fuse, prepare
from fusion.volume.settings import VolumeSettings
from fusion.volume.volume import Volume

CAMERA = Camera(160, 120, 140.0, 140.0, 79.5, 59.5)
COUNT = 24
X, Y, Z = np.eye(3)


def walked(moved_from=COUNT, by=0.08, count=COUNT):
    """A camera goes past a box before a wall; from some frame on the box stands nearer."""
    wall = sheet(-2 * X - 2 * Y + 1.2 * Z, 4 * Y, 4 * X, lambda p: np.tile([90.0, 90, 90], (len(p), 1)))
    scenes = [
        RayCaster(joined((wall, box((-0.2, -0.15, 0.8 - z), (0.2, 0.15, 1.1 - z), (200, 90, 60))))) for z in (0.0, by)
    ]
    poses = np.stack([exp(np.array([0, 0, 0, 0.004 * (k - count / 2), 0, 0])) for k in range(count)])
    depths = [scenes[k >= moved_from].view(CAMERA, T).depth for k, T in enumerate(poses)]
    frames = [prepare(Frame(k, 0.1 * k, depth), CAMERA, Sensor()) for k, depth in enumerate(depths)]
    volume = Volume(VolumeSettings(0.01, 0.03))
    for frame, T in zip(frames, poses, strict=True):
        fuse(volume, frame, T)
    changed = Changed(volume, poses)
    for k, frame in enumerate(frames):
        changed.look(k, frame)
    return changed


def test_what_stays_is_good():
    changed = walked()
    assert PARTS <= len(changed.found) <= FRAMES + 1
    light = changed.light()
    assert light.level == "ok"


def test_what_is_moved_is_told_with_its_frames():
    light = walked(moved_from=18).light()
    assert light.level != "ok"
    assert light.reason.startswith("Frames 18 to ")
    assert "before it" in light.reason
    assert light.do


@pytest.mark.parametrize("count", [1, PARTS - 1])
def test_too_few_frames_say_nothing(count):
    assert walked(count=count).light() is None


def test_frames_that_show_nothing_of_the_model_say_nothing():
    changed = walked()
    bare = Changed(Volume(VolumeSettings(0.01, 0.03)), changed.poses)
    for k in range(COUNT):
        bare.look(k, prepare(Frame(k, 0.0, np.full(CAMERA.shape, np.nan, np.float32)), CAMERA, Sensor()))
    assert bare.light() is None
