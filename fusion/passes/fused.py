"""One volume of all frames of all passes."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from fusion.errors import TrackingError
from fusion.geometry import pose
from fusion.mesh.cleanup import fill_small_holes, large_parts
from fusion.mesh.mesh import Mesh
from fusion.mesh.shape import CRUMB
from fusion.mesh.vertices import vertices_kept
from fusion.passes.one_pass import Pass, corner
from fusion.passes.settings import MergeSettings
from fusion.progress import each, stage
from fusion.scan.cleaning.seen import looked_through
from fusion.volume.prepared import Prepared, fuse
from fusion.volume.volume import Volume, VolumeSettings

Array = NDArray[np.float64]
LOWEST = 0.2  # percentile of a mesh's heights that is its foot
CELL = 2.0  # voxels
RIM = 3  # vertices from the border of what is looked through: a pixel, and what noise and depth of the rim add (guess)
MARGIN = 0.25  # of the object's size around it in which nothing else is fused; what is farther away may clear space


@dataclass(frozen=True)
class Near:
    """Cells around the object's surface, in the first pass's frame: low corner [m], edge [m], (a, b, c) bool."""

    low: Array
    cell: float
    cells: NDArray[np.bool_]

    @staticmethod
    def of(points: Array, cell: float, reach: float) -> "Near":
        """All cells within a reach [m] of points (n, 3)."""
        low = points.min(axis=0) - reach - 2 * cell
        shape = np.ceil((points.max(axis=0) + reach + 2 * cell - low) / cell).astype(int) + 1
        cells = np.zeros(shape, bool)
        cells[tuple(np.rint((points - low) / cell).astype(int).T)] = True
        around = ndimage.distance_transform_edt(~cells) * cell
        return Near(low, cell, np.asarray(around <= reach))

    @property
    def high(self) -> Array:
        return self.low + self.cell * (np.array(self.cells.shape) - 1)

    def holds(self, points: NDArray) -> NDArray[np.bool_]:
        """(n,) of points (n, 3); NaN is outside."""
        index = np.rint((np.nan_to_num(points, nan=-1e6) - self.low) / self.cell).astype(np.int64)
        inside = ((index >= 0) & (index < self.cells.shape)).all(axis=1)
        out = np.zeros(len(points), bool)
        out[inside] = self.cells[tuple(index[inside].T)]
        return out


def parts_alone(passes: Sequence[Pass], T: Array) -> list[Mesh]:
    """The mesh of each pass, in its own frame, without what another pass looked through."""
    out = []
    for i, one in enumerate(passes):
        assert one.mesh.normals is not None
        passing = np.zeros(len(one.mesh.vertices), bool)
        for j, other in enumerate(passes):
            if j != i:
                between = pose.inverse(T[j]) @ T[i]
                normals = one.mesh.normals.astype(float) @ between[:3, :3].T
                passing |= other.outlook.through(pose.transform(between, one.mesh.vertices), normals)
        kept = ~_without_rims(passing, one.mesh.faces)
        out.append(large_parts(vertices_kept(one.mesh, kept), CRUMB)[0] if kept.any() else one.mesh)
    return out


def cut(frame: Prepared, T_object_camera: Array, T: Array, near: Near, floor: float) -> Prepared:
    """A frame without what is near the object and not its own: plate, table, hand. What is far away may stay.

    Args:
        frame: of a pass.
        T_object_camera: (4, 4) in the pass's own frame.
        T: (4, 4) from there to the first's.
        near: the object's surface.
        floor: height in the pass's own frame from which on the object is seen alone [m].
    """
    points = frame.surface.points.reshape(-1, 3).astype(float)
    own = pose.transform(T_object_camera, points)
    there = pose.transform(T, own)
    # what lies beside the volume would reach into it by the truncation, which is less than the margin
    margin = MARGIN * (near.high - near.low).max()
    inside = ((there >= near.low - margin) & (there <= near.high + margin)).all(axis=1)
    taken = inside & ~(near.holds(there) & (own[:, 2] > floor))
    return replace(frame, depth=np.where(taken.reshape(frame.depth.shape), np.float32(np.nan), frame.depth))


def fused(passes: Sequence[Pass], T: Array, settings: MergeSettings) -> tuple[Mesh, VolumeSettings]:
    """The object alone, in the first pass's frame, integrated from all frames.

    Args:
        passes: k of them.
        T: (k, 4, 4) from each one's frame to the first's.
        settings: what was asked for.

    Raises:
        TrackingError: nothing of the object is left.
        VolumeError: the voxel settings do not fit into memory.
    """
    voxel = settings.voxel or min(one.voxel for one in passes)
    truncation = settings.truncation or max(one.truncation for one in passes)
    with stage("object"):
        alone = parts_alone(passes, T)
        points = np.concatenate([pose.transform(T[i], mesh.vertices) for i, mesh in enumerate(alone)])
        near = Near.of(points, CELL * voxel, truncation)
        floors = [
            float(np.percentile(m.vertices[:, 2], LOWEST)) + one.hidden for m, one in zip(alone, passes, strict=True)
        ]
    chosen = VolumeSettings(voxel, truncation, bounds=(corner(near.low), corner(near.high)))
    volume = Volume(chosen)
    frames, poses = [], []
    for i, k, frame in each(
        [(i, k, f) for i, one in enumerate(passes) for k, f in enumerate(one.frames)], "integrating"
    ):
        own = passes[i].trajectory.poses[k]
        if frame is None or not np.isfinite(own).all():
            continue
        fuse(volume, cut(frame, own, T[i], near, floors[i]), T[i] @ own)
        frames.append(frame)
        poses.append(T[i] @ own)
    with stage("mesh"):
        return _clean(volume.surface(), frames, np.array(poses), chosen, settings), chosen


def _clean(mesh: Mesh, frames: list[Prepared], poses: Array, chosen: VolumeSettings, settings: MergeSettings) -> Mesh:
    if len(mesh.faces):
        mesh = vertices_kept(mesh, ~looked_through(mesh, frames, poses, chosen.truncation))
    if not len(mesh.faces):
        raise TrackingError("nothing is left of the object that the passes share")
    mesh = large_parts(mesh, CRUMB)[0]
    return fill_small_holes(mesh, settings.fill_holes) if settings.fill_holes > 0 else mesh


def _without_rims(marked: NDArray[np.bool_], faces: NDArray[np.integer]) -> NDArray[np.bool_]:
    """Marked vertices (n,) without those of narrow strips: at a rim pixels show the object and what is behind it."""
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    inner = marked.copy()
    for _ in range(RIM):
        border = edges[~inner[edges].all(axis=1)]
        inner[border] = False
    for _ in range(RIM):
        inner[edges[inner[edges].any(axis=1)]] = True
    return np.asarray(inner & marked)
