"""A turntable recording as a sensor would have made it; the same seed, the same bits."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Camera
from fusion.geometry.trajectory import Trajectory
from fusion.mesh.mesh import Mesh
from fusion.recording.recording import Frame
from fusion.sensor.effects.readout.lateral_noise import jump
from fusion.sensor.view import Image, View
from fusion.simulation.render import RayCaster, nearest
from fusion.simulation.scene import Scene
from fusion.simulation.shapes import joined


@dataclass(frozen=True)
class Simulation:
    """A simulated recording and its truth.

    Attributes:
        scene: what it was made from.
        seed: of every random number in it.
        timestamps: (n,) [s].
        truth: `T_object_camera` of every frame, the object frame being the world at frame 0.
        turned_deg: (n,) true angles [deg].
        telemetry: columns of `telemetry.csv`: what the table reported.
    """

    scene: Scene
    seed: int
    timestamps: NDArray[np.float64]
    truth: Trajectory
    turned_deg: NDArray[np.float64]
    telemetry: dict[str, NDArray[np.float64]]

    @property
    def camera(self) -> Camera:
        return self.scene.camera

    @property
    def truth_mesh(self) -> Mesh:
        """Everything that turns, in the object frame."""
        return joined(self.scene.moving)

    def frames(self) -> Iterator[Frame]:
        """The frames, rendered one at a time."""
        scene = self.scene
        still = RayCaster(joined(scene.still)).view(scene.camera, scene.T_world_camera)
        moving = RayCaster(self.truth_mesh)
        for index, T_object_camera in enumerate(self.truth.poses):
            view = nearest(moving.view(scene.camera, T_object_camera), still)
            # a generator of its own per frame: the bits do not depend on which frames are asked for
            rng = np.random.default_rng([self.seed, 1, index])
            yield Frame(index, float(self.timestamps[index]), measured(view, scene, rng), lit(view))


def simulate_turntable(scene: Scene, seed: int = 0) -> Simulation:
    """Plan a recording: true angles and poses are drawn now, frames when they are asked for."""
    table = scene.turntable
    turned = table.true_deg(np.random.default_rng([seed, 0]))
    timestamps = scene.frame_s * np.arange(table.frames, dtype=np.float64)
    truth = Trajectory(timestamps, table.T_object_camera(scene.T_world_camera, turned))
    telemetry = {"timestamp": timestamps, "turntable_deg": table.commanded_deg()}
    return Simulation(scene, seed, timestamps, truth, turned, telemetry)


def measured(view: View, scene: Scene, rng: np.random.Generator) -> Image:
    """One measured depth (h, w) [m] of a true view: the sensor's effects, then mixed and lost edge pixels."""
    if view.depth is None:
        raise ValueError("the view has no depth")
    step = jump(view.depth)
    edge = np.abs(np.nan_to_num(step)) > 0
    chance, share = rng.random(view.depth.shape), rng.random(view.depth.shape)
    depth = scene.sensor.sample(view.depth, view, None, rng)
    mixed = edge & (chance >= 1 - scene.edge_mixed)
    depth = np.where(mixed, view.depth + share * step, depth)
    return np.where(edge & (chance < scene.edge_lost), np.nan, depth).astype(np.float32)


def lit(view: View) -> NDArray[np.uint8] | None:
    """Colour (h, w, 3) under a lamp at the camera: darker where the surface turns away."""
    if view.color is None or view.incidence is None:
        return view.color
    shade = 0.45 + 0.55 * np.cos(np.nan_to_num(view.incidence))
    return np.round(view.color * shade[..., None]).astype(np.uint8)
