"""Object or room: by the size of what stands free in the foreground, else of all that the frames show."""

import numpy as np
import pytest

from fusion.geometry.camera import Camera
from fusion.recording.open import open_recording
from fusion.recording.recording import Frame
from fusion.sensor.presets import default_sensor
from fusion.volume.prepared import prepare
from fusion.volume.subject import free_foreground, subject_of

CAMERA = Camera(160, 120, 130.0, 130.0, 79.5, 59.5, depth_scale=5000.0)


def wall(distance):
    return np.full(CAMERA.shape, distance, np.float32)


def thing(depth, distance, low=(45, 55), high=(85, 100)):
    depth = depth.copy()
    depth[low[0] : high[0], low[1] : high[1]] = distance
    return depth


def on_a_table(distance):
    """A thing on a table that reaches the image's lower border, before a wall."""
    v = np.arange(120)[:, None]
    table = np.where(v > 60, 0.35 * 130 / np.maximum(v - 59.5, 1), np.inf) * np.ones((1, 160))
    depth = np.minimum(table, distance).astype(np.float32)
    return np.minimum(depth, thing(wall(np.inf), 0.7, (70, 65), (85, 95)))


def judged(*depths, **told):
    sensor = default_sensor(CAMERA)
    return subject_of([prepare(Frame(i, 0.0, depth), CAMERA, sensor) for i, depth in enumerate(depths)], **told)


def test_what_fills_the_image_is_judged_by_its_size():
    # the middle four fifths of the pixels' width: 0.98 of the distance
    near, far = judged(wall(1.3)), judged(wall(1.8))
    assert not near.room and near.size == pytest.approx(1.28, abs=0.03)
    assert far.room and far.size == pytest.approx(1.77, abs=0.03) and far.distance == pytest.approx(1.8)


def test_a_camera_that_looks_near_and_far_is_in_a_room():
    assert not judged(wall(0.8), wall(0.9), wall(1.0)).room
    assert judged(wall(0.8), wall(1.0), wall(3.0)).room


def test_what_stands_free_is_what_is_meant():
    found = judged(*[thing(wall(3.0), 0.8 + 0.02 * i) for i in range(5)])
    assert found.free and not found.room and found.distance == pytest.approx(0.84, abs=0.01)
    assert "free in the foreground is 0.21 m large" in found.reason


def test_a_thing_before_nothing_stands_free():
    assert judged(thing(wall(np.nan), 0.8)).free


def test_a_large_thing_that_stands_free_is_a_room():
    found = judged(thing(wall(6.0), 3.0, (10, 10), (110, 150)))
    assert found.free and found.room


def test_one_frame_of_many_with_something_free_does_not_count():
    found = judged(thing(wall(3.0), 0.8), *[wall(3.0)] * 4)
    assert not found.free and found.room


@pytest.mark.parametrize(
    "depth", [wall(1.0), thing(wall(1.0), 3.0), on_a_table(1.2), thing(wall(2.0), 0.8, (0, 55))],
    ids=["wall", "hole in a wall", "on a table", "reaches the border"],
)  # fmt: skip
def test_what_does_not_stand_free(depth):
    assert not free_foreground(depth).any()


def test_what_was_told_is_not_judged():
    assert judged(wall(0.5), room=True).room
    assert not judged(wall(4.0), room=False).room
    free = [thing(wall(3.0), 0.8)] * 3
    assert judged(*free, room=True).distance == pytest.approx(3.0) and judged(*free, room=False).distance < 1


def test_a_single_pixel_is_a_small_thing():
    depth = np.full(wall(1.0).shape, np.nan)
    depth[7, 9] = 1.0
    assert judged(depth).size == 0


@pytest.mark.real
@pytest.mark.parametrize(
    ("name", "room"), [("tum_fr1_rpy", True), ("robot_arm_boxes", False), ("ycbv_0000", False), ("custard_box", False)]
)
def test_real_recordings(shared, name, room):
    real = open_recording(shared / "data" / name, "tum-fr1" if name == "tum_fr1_rpy" else None)
    sensor = default_sensor(real.camera)
    some = np.linspace(0, len(real) - 1, 5).round().astype(int)
    assert subject_of([prepare(real[int(i)], real.camera, sensor) for i in some]).room == room
