"""A mesh with `sigma`: some frames and vertices are looked at, the causes put together."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fusion.certainty.looks import PlacedFrame, look
from fusion.certainty.shared import VERTICES, shared_errors
from fusion.certainty.sigma import Causes, Sure, put_together
from fusion.geometry.camera import Camera
from fusion.mesh.mesh import Mesh
from fusion.sensor.effects.readout.lateral_noise import LateralNoise
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import View
from fusion.volume.prepared import Prepared

Array = NDArray[np.float64]
FRAMES = 24  # looked at, evenly from the scan: a vertex of a turning object faces a third of them
NEIGHBOURS = 96  # frames that tell what neighbours share, at few vertices; and most that are read once more
EVERY = 3  # of a moving camera's frames one in so many is read once more: reading takes a tenth of tracking
MOST = 40_000  # vertices looked at; between them sigma changes little
PIXEL = 1 / np.sqrt(12)  # [px] what a square pixel mixes, one standard deviation

Read = Callable[[int], Prepared | None]


def vertex_sigma(mesh: Mesh, frames: Sequence[Prepared | None], poses: Array, causes: Causes, near: float) -> Sure:
    """How sure each vertex of a mesh is, which was made of frames that are all at hand.

    Args:
        frames: (n), None for those that could not be read.
        poses: (n, 4, 4) `T_object_camera`, NaN for frames without a place.
        near: truncation of the volume [m]: what lies farther off is another surface.
    """
    some = _some(mesh, MOST)
    looks = look(_of(mesh, some), _taken(frames.__getitem__, poses, FRAMES), near)
    few = look(_of(mesh, _some(mesh, VERTICES)), _taken(frames.__getitem__, poses, NEIGHBOURS), near)
    return put_together(mesh, some, looks, shared_errors(few), replace(causes, frames=len(_placed(poses))))


def vertex_sigma_reading(mesh: Mesh, read: Read, poses: Array, causes: Causes, near: float) -> Sure:
    """The same where frames have to be read once more; `read` gives one, or None where it cannot be read."""
    some, count = _some(mesh, MOST), len(_placed(poses))
    looks = look(_of(mesh, some), _taken(read, poses, int(np.clip(count / EVERY, FRAMES, NEIGHBOURS))), near)
    few = looks.at(np.unique(np.linspace(0, max(len(some) - 1, 0), VERTICES).astype(np.intp))[: len(some)])
    return put_together(mesh, some, looks, shared_errors(few), replace(causes, frames=count))


def _placed(poses: Array) -> NDArray[np.intp]:
    return np.flatnonzero(np.isfinite(poses).all(axis=(1, 2)))


def _taken(read: Read, poses: Array, most: int) -> Iterator[PlacedFrame]:
    """Up to so many frames, evenly from those with a place, each with its pose."""
    placed = _placed(poses)
    for i in placed[np.unique(np.linspace(0, len(placed) - 1, most).round().astype(int))] if len(placed) else ():
        frame = read(int(i))
        if frame is not None:
            yield PlacedFrame(frame, poses[i])


def blur_px(sensor: Sensor, camera: Camera) -> float:
    """What a pixel mixes sideways, one standard deviation [px]: its own square, the matching window, the jitter."""
    windows = [float(effect.window(View(camera, baseline=sensor.baseline))) for effect in sensor.effects]
    widest = max([1.0, *(w for w in windows if w < max(camera.shape) / 4)])  # wider ones shake the whole image
    lateral = sensor.effect("lateral_noise")
    jitter = float(np.mean(lateral.sigma_px)) if isinstance(lateral, LateralNoise) else 0.0
    return float(np.hypot(widest * PIXEL, jitter))


def _some(mesh: Mesh, most: int) -> NDArray[np.intp]:
    count = len(mesh.vertices)
    return np.unique(np.linspace(0, count - 1, min(most, count)).astype(np.intp)) if count else np.zeros(0, np.intp)


def _of(mesh: Mesh, some: NDArray[np.intp]) -> Mesh:
    assert mesh.normals is not None
    return Mesh(mesh.vertices[some], normals=mesh.normals[some])
