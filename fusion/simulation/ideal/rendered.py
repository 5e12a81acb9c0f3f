"""Ideal frames of the own simulator, with all that a renderer can tell beside the depth."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from fusion.sensor.view import Image
from fusion.simulation.ideal.frame import IdealFrame
from fusion.simulation.rendering.exposure import Exposures
from fusion.simulation.simulate import Simulation

FINER = 64  # values a pixel: `simulate` halves the way between two pixels six times


def ideal_of(simulation: Simulation, finer: int = FINER) -> Iterator[IdealFrame]:
    """What stood before the sensor of a simulation: perfect depth, normals, reflectance, the light of its projector.

    Args:
        simulation: its sensor says where a projector stands, and nothing else of it counts.
        finer: values a pixel along rows and columns; 1: only the pixels themselves.

    >>> wall = fusion.simulate(fusion.built_in("wall", {"distance_m": 1.2}), fusion.read_sensor("kinect-v1"))
    >>> from fusion.simulation.ideal.rendered import ideal_of
    >>> next(ideal_of(wall, finer=3))
    <IdealFrame: 640 x 480; depth, normals, reflectance, rows, columns, lit>
    """
    projector = tuple(effect for effect in simulation.sensor.effects if effect.name == "projector_shadow")
    perfect = replace(simulation.sensor, effects=projector)
    exposures = Exposures(simulation.scene, perfect, simulation.camera, simulation.turned_deg)
    placement = -1
    for index in range(len(simulation)):
        poses = simulation.truth.poses
        placement += index == 0 or not np.array_equal(poses[index], poses[index - 1])
        moment = simulation.moment(index, placement, None)
        view = exposures.view(index, moment, np.random.default_rng(0))
        assert view.depth is not None
        frame = IdealFrame(view.depth, view.normals, view.reflectance, lit=view.lit, moment=moment)
        if finer > 1:
            rows, columns = _finer(exposures, simulation, index, finer)
            frame = replace(frame, rows=rows, columns=columns)
        yield frame


def _finer(exposures: Exposures, simulation: Simulation, index: int, finer: int) -> tuple[Image, Image]:
    """Depth (h, finer w) and (finer h, w) [m]: every image of the camera, moved by parts of a pixel."""
    camera, moment = simulation.camera, simulation.moment(index, 0, None)
    height, width = camera.shape
    rows, columns = np.empty((height, finer * width), np.float32), np.empty((finer * height, width), np.float32)
    for place in range(finer):
        off = (place - finer // 2) / finer
        rows[:, place::finer] = exposures.depth(index, moment, replace(camera, cx=camera.cx - off))
        columns[place::finer] = exposures.depth(index, moment, replace(camera, cy=camera.cy - off))
    return rows, columns
