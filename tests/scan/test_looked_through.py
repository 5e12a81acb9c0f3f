"""What was there in a few frames only goes; the object stays, its rims too."""

from dataclasses import replace

import numpy as np
import pytest

from fusion.geometry.camera import Camera
from fusion.mesh.mesh import Mesh
from fusion.recording.recording import Frame
from fusion.scan.seen import looked_through
from fusion.sensor.sensor import Sensor
from fusion.simulation.demo import looking_at
from fusion.simulation.demo_object import demo_object
from fusion.simulation.render import RayCaster
from fusion.simulation.shapes import box, joined
from fusion.simulation.turntable import Turntable
from fusion.volume.prepared import fuse, prepare
from fusion.volume.volume import Volume, VolumeSettings

CAMERA = Camera(160, 120, 190.0, 191.0, 80.3, 59.1)
COUNT, STEP_DEG = 18, 20.0
BOUNDS = ((-0.2, -0.2, 0.01), (0.2, 0.2, 0.35))
LOW, HIGH = (0.11, -0.03, 0.08), (0.19, 0.03, 0.16)  # of an arm beside the owl
NEAR = 0.012


def seen(arm_in):
    """Frames of the owl in a room, an arm beside it in some of them; their poses, and the surface of all."""
    start = looking_at(np.array([0.6, 0.05, 0.28]), np.array([0.0, 0.0, 0.10]))
    poses = Turntable(degrees_per_frame=STEP_DEG, frames=COUNT).T_object_camera(start, STEP_DEG * np.arange(COUNT))
    things = [demo_object(), box((-2, -2, -1), (2, 2, 2), (90, 90, 90))]
    without, beside = RayCaster(joined(things)), RayCaster(joined([*things, box(LOW, HIGH, (200, 80, 80))]))
    depths = [(beside if k in arm_in else without).view(CAMERA, T).depth for k, T in enumerate(poses)]
    frames = [prepare(Frame(k, 0.1 * k, depth), CAMERA, Sensor()) for k, depth in enumerate(depths)]
    volume = Volume(VolumeSettings(0.004, NEAR, bounds=BOUNDS))
    for frame, T in zip(frames, poses, strict=True):
        # as a scan does: what stands behind takes no part, and wipes nothing away
        fuse(volume, alone(frame), T)
    return frames, poses, volume.surface()


def alone(frame):
    return replace(frame, depth=np.where(frame.depth < 1.0, frame.depth, np.float32(np.nan)))


def of_arm(mesh):
    return ((mesh.vertices > np.array(LOW) - 0.01) & (mesh.vertices < np.array(HIGH) + 0.01)).all(axis=1)


def test_an_arm_that_came_in_goes_and_the_object_stays():
    frames, poses, mesh = seen(arm_in=(4, 5))
    marked, arm = looked_through(mesh, frames, poses, NEAR), of_arm(mesh)
    assert arm.sum() > 300  # it is there
    assert marked[arm].mean() > 0.8
    assert marked[~arm].mean() < 0.005


def test_what_stays_beside_the_object_stays():
    frames, poses, mesh = seen(arm_in=range(COUNT))
    assert looked_through(mesh, frames, poses, NEAR).mean() < 0.005


@pytest.mark.parametrize("frames", [[], [None, None]])
def test_without_frames_nothing_is_looked_through(frames):
    mesh = Mesh(np.eye(3), np.array([[0, 1, 2]]), normals=np.eye(3))
    assert not looked_through(mesh, frames, np.full((len(frames), 4, 4), np.nan), NEAR).any()
