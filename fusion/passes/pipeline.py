"""The merge: every pass laid on the others, all refined together, one volume of all frames."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fusion.coloring.color_mesh import color_from
from fusion.errors import FusionError
from fusion.geometry import pose
from fusion.geometry.trajectory import Trajectory
from fusion.mesh.mesh import Mesh
from fusion.passes.fused import fused
from fusion.passes.one_pass import Pass
from fusion.passes.opened import open_pass
from fusion.passes.poses.arranged import Arranged, arranged
from fusion.passes.poses.colors import printed, slid
from fusion.passes.poses.joint import loose, refined
from fusion.passes.poses.lying import judged
from fusion.passes.poses.sides import REACHED, PassSide, side_of
from fusion.passes.result import Merged, PassPair
from fusion.passes.settings import MergeSettings
from fusion.progress import stage
from fusion.recording.looking.copies import refuse_repeated
from fusion.recording.recording import Recording

Array = NDArray[np.float64]
APART, SEEN = "passes_apart", "passes"  # scalars: [m], and how many passes show a vertex


def between(mesh: Mesh, sides: Sequence[PassSide], T: Array) -> Mesh:
    """The mesh with how many passes show each vertex, and how far these lie from each other there (NaN: one alone)."""
    assert mesh.normals is not None
    heights = np.full((len(sides), len(mesh.vertices)), np.nan)
    for k, side in enumerate(sides):
        back = pose.inverse(T[k])
        points, normals = pose.transform(back, mesh.vertices), mesh.normals.astype(float) @ back[:3, :3].T
        index, known = side.nearest(points, side.noise + REACHED * side.spacing)
        off = np.einsum("ij,ij->i", side.points[index] - points, side.normals[index])
        same = np.einsum("ij,ij->i", normals, side.normals[index]) > 0.5
        heights[k] = np.where(known & same & (np.abs(off) <= side.noise), off, np.nan)
    seen = np.isfinite(heights).sum(axis=0)
    both = seen >= 2
    apart = np.full(len(mesh.vertices), np.nan, np.float32)
    apart[both] = np.nanmax(heights[:, both], axis=0) - np.nanmin(heights[:, both], axis=0)
    return replace(mesh, scalars=mesh.scalars | {SEEN: seen.astype(np.float32), APART: apart})


def merge_passes(passes: Sequence[Pass | Recording | Path | str], settings: MergeSettings | None = None) -> Merged:
    """Merge turntable scans of one object that was turned over, or laid on its side, between them.

    Args:
        passes: two or more: results of `fusion turntable`, or recordings, which are scanned first.
        settings: what is known, and what is asked for.

    Raises:
        FusionError: fewer than two passes, one given twice, or a result that cannot be read.
        TrackingError: a recording cannot be scanned; or the passes share too little surface, show different objects,
            or are symmetric without a colour that decides.
        VolumeError: the voxel settings do not fit into memory.

    >>> merged = fusion.merge_passes(["my_scan", "my_scan_turned_over"])
    >>> merged.pairs[0].overlap > 0.5
    True
    >>> fusion.write_mesh("cup.ply", merged.mesh)
    """
    settings = settings or MergeSettings()
    if len(passes) < 2:
        raise FusionError("a merge needs two passes or more", "PASS", len(passes), do="give the other pass as well")
    given = [one if isinstance(one, Pass) else open_pass(one) for one in passes]
    refuse_repeated([one.recording for one in given])
    sides = [side_of(one) for one in given]
    if settings.transforms is None:
        found = [arranged(given, sides, k, settings.color) for k in range(1, len(given))]
        T = _together(given, sides, found, settings.color)
    else:
        if len(settings.transforms) != len(given):
            found_, asked = f"{len(settings.transforms)} transforms", f"one for each of {len(given)} passes"
            raise FusionError("the transforms do not fit the passes", "--transforms", found_, asked)
        known = pose.inverse(np.asarray(settings.transforms[0], float)) @ np.asarray(settings.transforms, float)
        found, T = [_known(sides, known, k) for k in range(1, len(given))], known
    mesh, chosen = fused(given, T, settings)
    courses = [Trajectory(p.trajectory.timestamps, T[i] @ p.trajectory.poses) for i, p in enumerate(given)]
    mesh = between(mesh, sides, T)
    if settings.color:
        taken = [(p.recording, course) for p, course in zip(given, courses, strict=True)]
        mesh = color_from(mesh, taken).mesh
    with stage("judging"):
        pairs = tuple(_pair(sides, T, k, one) for k, one in enumerate(found, 1))
        return Merged(mesh, tuple(given), T, pairs, tuple(courses), chosen, settings.transforms is not None)


def _together(passes: Sequence[Pass], sides: Sequence[PassSide], found: Sequence[Arranged], color: bool) -> Array:
    """The transforms (k, 4, 4) to the first pass's frame, refined."""
    T = np.tile(np.eye(4), (len(passes), 1, 1))
    for k, one in enumerate(found, 1):
        T[k] = T[one.onto] @ one.lying.T
    with stage("refining"):
        T = refined(sides, T)
        for k, one in enumerate(found, 1):
            pair = sides[one.onto], sides[k]
            shown = printed((passes[one.onto].mesh, passes[k].mesh), pair) if color else None
            own = pose.inverse(T[one.onto]) @ T[k]
            ways = loose(*pair, own)
            if shown is not None and len(ways):
                T[k] = T[one.onto] @ slid(shown, *pair, own, ways)
    return T


def _known(sides: Sequence[PassSide], T: Array, k: int) -> Arranged:
    return Arranged(0, judged(sides[0], sides[k], T[k]), -1.0, False)


def _pair(sides: Sequence[PassSide], T: Array, k: int, one: Arranged) -> PassPair:
    """How pass k lies to the one it was laid on, after the refinement."""
    lying = judged(sides[one.onto], sides[k], pose.inverse(T[one.onto]) @ T[k])
    return PassPair(
        one.onto, lying.overlap, lying.through, lying.rms, lying.score, one.second_score, one.symmetric, one.colors
    )


def before(merged: Merged) -> list[Mesh]:
    """The mesh of each pass where it lies in the merge."""
    out = []
    for one, T in zip(merged.passes, merged.T, strict=True):
        normals = None if one.mesh.normals is None else (one.mesh.normals @ T[:3, :3].T).astype(np.float32)
        out.append(Mesh(pose.transform(T, one.mesh.vertices), one.mesh.faces, normals, one.mesh.colors))
    return out
