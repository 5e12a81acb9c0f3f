"""An owl that turns in a room, and an arm that is beside it in some frames only."""

from dataclasses import replace

import numpy as np

from fusion.geometry.camera import Camera
from fusion.recording.recording import Frame
from fusion.sensor.sensor import Sensor
from fusion.simulation.demo.demo import looking_at
from fusion.simulation.demo.demo_object import demo_object
from fusion.simulation.rendering.render import RayCaster
from fusion.simulation.scene.shapes import box, joined
from fusion.simulation.scene.turntable import Turntable
from fusion.volume.prepared import fuse, prepare
from fusion.volume.volume import Volume, VolumeSettings

CAMERA = Camera(160, 120, 190.0, 191.0, 80.3, 59.1)
COUNT, STEP_DEG = 18, 20.0
BOUNDS = ((-0.2, -0.2, 0.01), (0.2, 0.2, 0.35))
LOW, HIGH = (0.11, -0.03, 0.08), (0.19, 0.03, 0.16)  # of the arm
NEAR = 0.012


def frames_of(arm_in, thing=None, arm=(LOW, HIGH)):
    """Frames of the owl (or a thing) in a room, an arm beside it in some of them; their poses."""
    start = looking_at(np.array([0.6, 0.05, 0.28]), np.array([0.0, 0.0, 0.10]))
    poses = Turntable(degrees_per_frame=STEP_DEG, frames=COUNT).T_object_camera(start, STEP_DEG * np.arange(COUNT))
    things = [thing or demo_object(), box((-2, -2, -1), (2, 2, 2), (90, 90, 90))]
    without, beside = RayCaster(joined(things)), RayCaster(joined([*things, box(*arm, (200, 80, 80))]))
    depths = [(beside if k in arm_in else without).view(CAMERA, T).depth for k, T in enumerate(poses)]
    return [prepare(Frame(k, 0.1 * k, depth), CAMERA, Sensor()) for k, depth in enumerate(depths)], poses


def surface_of(frames, poses):
    """Of all frames, as a scan has it: what stands behind takes no part, and wipes nothing away."""
    volume = Volume(VolumeSettings(0.004, NEAR, bounds=BOUNDS))
    for frame, T in zip(frames, poses, strict=True):
        fuse(volume, alone(frame), T)
    return volume.surface()


def alone(frame):
    """Without the room."""
    return replace(frame, depth=np.where(frame.depth < 1.0, frame.depth, np.float32(np.nan)))


def of_arm(points):
    """(...) bool: points (..., 3) of the object's frame that are the arm's."""
    return ((points > np.array(LOW) - 0.01) & (points < np.array(HIGH) + 0.01)).all(axis=-1)
