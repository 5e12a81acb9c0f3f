"""Does the camera see the scene at all? Asked before a long run, in a few coarse pictures."""

from dataclasses import replace

import numpy as np

from fusion.errors import SceneError
from fusion.geometry.camera import Camera
from fusion.recording.images.frame_files import INVALID_COUNT
from fusion.simulation.rendering.render import RayCaster
from fusion.simulation.simulate import Simulation

LOOKS = 12  # frames
WIDTH = 64  # [px]


def check_sight(simulation: Simulation) -> list[str]:
    """What a sensor will not see of a scene, one sentence each, by coarse pictures.

    Raises:
        SceneError: none shows a surface within the range of the depth images.
    """
    scene = simulation.scene
    caster, camera = RayCaster(simulation.mesh), coarse(simulation.camera)
    n = len(simulation)
    depths = []
    for index in sorted({int(i) for i in np.linspace(0, n - 1, min(n, LOOKS))}):
        depth = caster.view(camera, simulation.truth.poses[index]).depth
        depths.append(np.empty(0) if depth is None else depth[np.isfinite(depth)])
    seen = np.concatenate(depths)
    if not len(seen):
        do = 'check the poses (camera to world, z forward) and the unit ("scale": 0.001 for millimetres)'
        raise SceneError(
            "the camera sees nothing of the scene", scene.name, f"no surface in {len(depths)} frames", do=do
        )
    far = (INVALID_COUNT - 1) / simulation.camera.depth_scale
    if np.median(seen) > far or np.median(seen) < 1.0 / simulation.camera.depth_scale:
        found, expected = f"a median depth of {np.median(seen):.3g} m", f"up to {far:.3g} m"
        do = 'check the unit ("scale": 0.001 for millimetres) and depth_scale'
        raise SceneError("the scene lies outside the range of the depth images", scene.name, found, expected, do)
    missed = simulation.sensor.works.told(seen, simulation.sensor.name)
    return [missed] if missed else []


def coarse(camera: Camera) -> Camera:
    """The same field of view in few pixels."""
    factor = min(1.0, WIDTH / camera.width)
    return replace(
        camera,
        width=max(1, round(camera.width * factor)),
        height=max(1, round(camera.height * factor)),
        fx=camera.fx * factor,
        fy=camera.fy * factor,
        cx=(camera.cx + 0.5) * factor - 0.5,
        cy=(camera.cy + 0.5) * factor - 0.5,
    )
