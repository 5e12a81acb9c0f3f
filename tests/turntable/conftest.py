"""A small turntable scene without noise: an owl seen by a camera of 160 x 120 pixels."""

import numpy as np
import pytest

from fusion.geometry import pose
from fusion.geometry.camera import Camera
from fusion.geometry.depth import point_map
from fusion.simulation.demo.demo import looking_at
from fusion.simulation.demo.demo_object import demo_object
from fusion.simulation.rendering.render import RayCaster
from fusion.simulation.scene.turntable import Turntable
from fusion.turntable.axis import Axis
from fusion.turntable.views import Region, usable, view

SMALL = Camera(160, 120, 190.0, 191.0, 80.3, 59.1, principle="itof")
FRAMES = 18
STEP_DEG = 20.0


class OwlScene:
    """Noise-free depths of one turn, the true axis in the camera's frame and the true angles."""

    camera = SMALL

    def __init__(self) -> None:
        T_world_camera = looking_at(np.array([0.5, 0.05, 0.28]), np.array([0.0, 0.0, 0.10]))
        table = Turntable(degrees_per_frame=STEP_DEG, frames=FRAMES)
        poses = table.T_object_camera(T_world_camera, table.commanded_deg())
        caster = RayCaster(demo_object())
        self.depths = np.stack([caster.view(SMALL, T).depth for T in poses])
        T_camera_world = pose.inverse(T_world_camera)
        self.axis = Axis(T_camera_world[:3, 3], T_camera_world[:3, 2])
        self.angles = np.deg2rad(table.commanded_deg())

    def views(self, camera=SMALL):
        """One view per frame, as a camera file states the camera."""
        everywhere = Region(np.full(3, -9.0), np.full(3, 9.0))
        maps = [point_map(depth, camera, 0.001) for depth in self.depths]
        return [view(m, usable(m, everywhere)) for m in maps]


@pytest.fixture(scope="session")
def owl_scene():
    return OwlScene()
