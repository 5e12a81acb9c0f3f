"""What was there in a few frames only goes; the object stays, its rims too."""

import numpy as np
import pytest
from owl_and_arm import CAMERA, COUNT, NEAR, alone, frames_of, of_arm, surface_of

from fusion.mesh.mesh import Mesh
from fusion.recording.recording import Frame
from fusion.scan.cleaning.seen import looked_through
from fusion.sensor.sensor import Sensor
from fusion.volume.prepared import prepare


def test_an_arm_that_came_in_goes_and_the_object_stays():
    frames, poses = frames_of(arm_in=(4, 5))
    mesh = surface_of(frames, poses)
    marked, arm = looked_through(mesh, frames, poses, NEAR), of_arm(mesh.vertices)
    assert arm.sum() > 300  # it is there
    assert marked[arm].mean() > 0.8
    assert marked[~arm].mean() < 0.005


def test_what_stays_beside_the_object_stays():
    frames, poses = frames_of(arm_in=range(COUNT))
    assert looked_through(surface_of(frames, poses), frames, poses, NEAR).mean() < 0.005


def test_an_arm_before_nothing_goes_where_other_frames_face_its_place():
    """A background too far to be measured: nothing is behind what goes. Nothing is nearer than all that is there."""
    frames, poses = frames_of(arm_in=(4,))
    bare = [measured(alone(frame).depth) for frame in frames]
    mesh = surface_of(bare, poses)
    marked, arm = looked_through(mesh, bare, poses, NEAR), of_arm(mesh.vertices)
    assert arm.sum() > 100
    assert marked[arm].mean() > 0.8
    assert marked[~arm].mean() < 0.005


def test_what_is_too_near_in_the_other_frames_stays():
    near = np.full(CAMERA.shape, 0.6, np.float32)
    far = np.full(CAMERA.shape, 0.55, np.float32)
    far[:, 40:120] = np.nan  # 0.45 m away, where the camera measures nothing
    poses = np.tile(np.eye(4), (3, 1, 1))
    poses[1:, 2, 3] = 0.15
    points = np.dstack([CAMERA.rays(), np.ones(CAMERA.shape)])[40:80:8, 60:100:8].reshape(-1, 3) * 0.6
    mesh = Mesh(points, np.zeros((0, 3), int), normals=np.tile([0.0, 0, -1], (len(points), 1)))
    frames = [measured(depth) for depth in (near, far, far)]
    assert not looked_through(mesh, frames, poses, NEAR).any()
    far[:20] = 0.4
    assert looked_through(mesh, [measured(depth) for depth in (near, far, far)], poses, NEAR).all()


def measured(depth):
    return prepare(Frame(0, 0.0, depth), CAMERA, Sensor())


@pytest.mark.parametrize("frames", [[], [None, None]])
def test_without_frames_nothing_is_looked_through(frames):
    mesh = Mesh(np.eye(3), np.array([[0, 1, 2]]), normals=np.eye(3))
    assert not looked_through(mesh, frames, np.full((len(frames), 4, 4), np.nan), NEAR).any()


def test_a_narrow_rest_goes_up_to_the_rim_it_hangs_on():
    """A strip three vertices wide between sides that no frame sees, grown onto a wall's rim: what a finger leaves."""
    wall = np.full((120, 160), 2.0, np.float32)
    wall[:, :80] = 1.0
    frame = prepare(Frame(0, 0.0, wall), CAMERA, Sensor())
    u, v = np.meshgrid(np.arange(40, 121), np.arange(40, 81), indexing="ij")
    there = (u < 80) | (abs(v - 60) < 3)
    index = np.cumsum(there).reshape(there.shape) - 1
    whole = there[:-1, :-1] & there[1:, :-1] & there[:-1, 1:] & there[1:, 1:]
    a, b, c, d = (index[i : i + 80, j : j + 40][whole] for i, j in ((0, 0), (1, 0), (1, 1), (0, 1)))
    points = np.dstack([CAMERA.rays()[v, u], np.ones(u.shape)])[there]
    mesh = Mesh(
        points, np.concatenate([np.c_[a, b, c], np.c_[a, c, d]]), normals=np.tile([0.0, 0, -1], (len(points), 1))
    )
    mesh.normals[(u[there] >= 80) & (abs(v[there] - 60) == 2)] = (0, 1, 0)
    marked = looked_through(mesh, [frame], np.eye(4)[None], NEAR)
    assert marked[(u[there] > 82) & (abs(v[there] - 60) < 2)].all()
    assert not marked[u[there] < 80].any()
