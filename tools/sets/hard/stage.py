"""Renders frames: things that stand still are cast once per place of the camera, the others in every frame."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tools.sets.hard.things import Thing
from tools.sets.planted.stage import Pinhole

Array = NDArray[np.float64]

NOTHING, STILL, OBJECT, OTHER = 0, 1, 2, 3


@dataclass(frozen=True)
class Moving:
    """A thing with its poses (n, 4, 4) in the world and where it is in the picture at all (n,); its part."""

    thing: Thing
    poses: Array
    shown: NDArray[np.bool_]
    part: int = OTHER


@dataclass(frozen=True)
class Seen:
    """One frame (h, w): z [m] (inf where nothing), cosine of incidence, part, colours (h, w, 3)."""

    z: Array
    cosine: Array
    part: NDArray[np.int8]
    colour: Array


@dataclass
class Stage:
    """World: z up, the plate's top at z = 0. `T_world_camera` (n, 4, 4)."""

    camera: Pinhole
    still: Thing
    moving: list[Moving]
    T_world_camera: Array

    def __post_init__(self) -> None:
        self._kept: tuple[Array, Seen] | None = None

    def frame(self, i: int) -> Seen:
        """Frame i without noise."""
        T = self.T_world_camera[i]
        rays, back = self.camera.rays, self._behind(T)
        z, cosine, part, colour = back.z.copy(), back.cosine.copy(), back.part.copy(), back.colour.copy()
        for one in self.moving:
            if not one.shown[i]:
                continue
            T_thing_camera = np.linalg.inv(one.poses[i]) @ T
            at = self._window(T_thing_camera, one.thing.solid.reach)
            t, c, point = one.thing.solid.hit(T_thing_camera, rays[at].reshape(-1, 3))
            t, c = t.reshape(rays[at].shape[:2]), c.reshape(rays[at].shape[:2])
            first = t < z[at]
            z[at][first], cosine[at][first], part[at][first] = t[first], c[first], one.part
            colour[at][first] = one.thing.paint.at(point[first.ravel()]) * _lit(c[first])[:, None]
        return Seen(z, cosine, part, colour)

    def _behind(self, T: Array) -> Seen:
        if self._kept is None or (self._kept[0] != T).any():
            h, w = self.camera.height, self.camera.width
            t, c, point = self.still.solid.hit(T, self.camera.rays.reshape(-1, 3))
            colour = self.still.paint.at(point) * _lit(c)[:, None]
            colour[~np.isfinite(t)] = 20
            part = np.where(np.isfinite(t), STILL, NOTHING).astype(np.int8)
            images = t.reshape(h, w), c.reshape(h, w), part.reshape(h, w), colour.reshape(h, w, 3)
            self._kept = T, Seen(*images)
        return self._kept[1]

    def _window(self, T_thing_camera: Array, reach: float) -> tuple[slice, slice]:
        """Rows and columns that a ball about the thing's origin covers."""
        centre = -T_thing_camera[:3, :3].T @ T_thing_camera[:3, 3]
        if centre[2] < 2 * reach:
            return slice(None), slice(None)
        middle, half = centre[:2] / centre[2], 1.2 * reach / (centre[2] - reach)
        cam = self.camera
        u, v = cam.f * middle + [cam.cx, cam.cy]
        wide = cam.f * half + 2
        rows = slice(int(np.clip(v - wide, 0, cam.height)), int(np.clip(v + wide, 0, cam.height)))
        return rows, slice(int(np.clip(u - wide, 0, cam.width)), int(np.clip(u + wide, 0, cam.width)))


def _lit(cosine: Array) -> Array:
    return np.asarray(0.4 + 0.6 * cosine)
