"""What a sample of frames measured at the vertices of a finished mesh, as displacements along the normals.

Depth is taken as the volume takes it (see `volume/integration/planes`): the pixel half, its four neighbours an eighth
each, and between pixels what lies between. So the spread of these looks is that of what was averaged.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.geometry import pose
from fusion.mesh.mesh import Mesh
from fusion.recording.ahead import ahead
from fusion.volume.prepared import Prepared

Array = NDArray[np.float64]
FACING = 0.1  # least cosine between normal and line of sight
NEAREST = 0.05  # [m] of depth; no depth camera measures nearer
Measured = tuple[NDArray[np.intp], tuple[NDArray[np.intp], NDArray[np.intp]], tuple[Array, Array]]
STENCIL = np.array([[0, 1, 0], [1, 4, 1], [0, 1, 0]], np.float32) / 8


class PlacedFrame(NamedTuple):
    """A frame and where it was taken from."""

    frame: Prepared
    pose: Array  # (4, 4) `T_object_camera`


@dataclass(frozen=True)
class Looks:
    """What k frames measured at m vertices; a frame that does not see a vertex has weight 0 there."""

    # (m, k) measured point minus vertex along its normal, positive outside [m]; 0 where not seen
    off: NDArray[np.float32]
    spread: NDArray[np.float32]  # (m, k) standard deviation of that by the sensor's model [m]; 0 where not seen
    weight: NDArray[np.float32]  # (m, k) how much the frame counted in the volume, in any unit
    # (k, k) how different two places of the camera are [rad]: the larger of turn and of shift over distance
    apart: Array
    poses: Array  # (k, 4, 4) `T_object_camera`
    pixel: Array  # (m,) what a pixel covers at the vertex, mean over the frames that see it [m]; NaN where none does

    @property
    def seen(self) -> NDArray[np.bool_]:
        """(m, k) which frames see which vertices."""
        return self.weight > 0

    def at(self, some: NDArray[np.intp]) -> "Looks":
        """The same of some of the vertices."""
        off, spread, weight = (table[some] for table in (self.off, self.spread, self.weight))
        return Looks(off, spread, weight, self.apart, self.poses, self.pixel[some])

    def share(self) -> NDArray[np.float32]:
        """(m, k) of each frame in what the volume made of a vertex; sums to 1, or 0 where no frame sees it."""
        return self.weight / np.maximum(self.weight.sum(axis=1, keepdims=True), 1e-30)


def look(mesh: Mesh, frames: Iterable[PlacedFrame], near: float) -> Looks:
    """What placed frames measured at the vertices of a mesh.

    Args:
        frames: in any order; asked for one after the other, so they may be read as they are asked for.
        near: largest difference in depth [m]: what lies farther off is another surface.
    """
    assert mesh.normals is not None
    count, columns, poses = len(mesh.vertices), [], []
    pixel, times = np.zeros((2, count))

    def asked(placed: PlacedFrame) -> tuple[PlacedFrame, Measured]:
        return placed, _measured(mesh, placed.frame, placed.pose, near)

    for answer in ahead(asked, frames):
        (frame, T), (which, at, off) = answer()
        column = np.zeros((3, count), np.float32)
        surface = frame.surface
        ray, along = off
        column[0, which] = ray * along
        column[1, which] = surface.sigma[at] * np.abs(along)
        column[2, which] = frame.weight[at] * np.abs(along)
        column[:, ~np.isfinite(column).all(axis=0)] = 0
        pixel[which] += (surface.points[(*at, np.full(len(which), 2))]) / surface.camera.fx
        times[which] += 1
        columns.append(column)
        poses.append(T)
    table = np.stack(columns, axis=2) if columns else np.zeros((3, count, 0), np.float32)
    with np.errstate(invalid="ignore"):
        pixel /= times
    where = np.array(poses).reshape(-1, 4, 4)
    off, spread, weight = table
    return Looks(off, spread, weight, _apart(where, mesh.vertices.mean(axis=0)), where, pixel)


def _measured(mesh: Mesh, frame: Prepared, T: Array, near: float) -> Measured:
    """Vertices that the frame shows, their pixels (v, u), and the difference in depth [m] with what it is along n."""
    assert mesh.normals is not None
    camera, surface = frame.surface.camera, frame.surface
    towards = T[:3, 3] - mesh.vertices
    facing = np.einsum("ij,ij->i", mesh.normals, towards) > FACING * np.linalg.norm(towards, axis=1)
    which = np.flatnonzero(facing)
    points = pose.transform(pose.inverse(T), mesh.vertices[which].astype(float))
    u, v = np.clip(np.nan_to_num(camera.project(points), nan=-9), -9, 99999).T
    z = points[:, 2]
    inside = (z > NEAREST) & (u >= 0) & (u <= camera.width - 1) & (v >= 0) & (v <= camera.height - 1)
    which, u, v, points, z = which[inside], u[inside], v[inside], points[inside], z[inside]
    ray = _between(frame.depth, u, v) - z
    u, v = np.rint(u).astype(int), np.rint(v).astype(int)
    with np.errstate(invalid="ignore"):
        shown = (np.abs(ray) < near) & np.isfinite(surface.sigma[v, u])
    which, u, v, ray = which[shown], u[shown], v[shown], ray[shown]
    # per metre of depth a point moves by ray / z, of which the normal takes its part (towards the camera: negative)
    along = np.einsum("ij,ij->i", points[shown] / z[shown, None], mesh.normals[which] @ T[:3, :3])
    return which, (v, u), (ray, along)


def _between(depth: NDArray[np.float32], u: Array, v: Array) -> Array:
    """Depth (m,) [m] at places in the image [px]; of the nearest pixel alone where a neighbour is missing."""
    mixed = cv2.filter2D(depth, cv2.CV_32F, STENCIL, borderType=cv2.BORDER_REPLICATE)
    mixed = np.where(np.isfinite(mixed), mixed, depth)
    h, w = depth.shape
    left, top = np.minimum(u.astype(int), w - 2), np.minimum(v.astype(int), h - 2)
    a, b = u - left, v - top
    upper = (1 - a) * mixed[top, left] + a * mixed[top, left + 1]
    lower = (1 - a) * mixed[top + 1, left] + a * mixed[top + 1, left + 1]
    out = (1 - b) * upper + b * lower
    return np.asarray(np.where(np.isfinite(out), out, depth[np.rint(v).astype(int), np.rint(u).astype(int)]))


def _apart(poses: Array, middle: Array) -> Array:
    """(k, k) [rad] how different views are."""
    turn = poses[:, None, :3, :3].swapaxes(-1, -2) @ poses[None, :, :3, :3]
    angle = np.arccos(np.clip((np.trace(turn, axis1=-2, axis2=-1) - 1) / 2, -1, 1))
    shift = np.linalg.norm(poses[:, None, :3, 3] - poses[None, :, :3, 3], axis=-1)
    far = np.linalg.norm(poses[:, :3, 3] - middle, axis=1)
    return np.asarray(np.maximum(angle, shift / np.maximum((far[:, None] + far[None]) / 2, 1e-9)))
