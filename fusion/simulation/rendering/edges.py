"""Depth edges, to a sixty-fourth of a pixel: found between neighbouring pixels, then bisected by more rays."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Camera
from fusion.sensor.edges.nearest import REACH_PX, Crossings, Indices, nearest_edges
from fusion.sensor.view import Edges, Image, View
from fusion.simulation.rendering.casting import CastBodies, Floats

JUMP = 0.002  # share of the depth: smaller steps are no edge
EDGE_ON = 0.5  # share of the depth by which a plane may change within a pixel
STEPS = 6  # 1/64 px, within which a jump must stay one: at 1 m and 600 px, a slope below 89.3 deg does not

# depth (n,) [m] between pixels, NaN for nothing: asked with flat indices (n,) of two neighbours, the share (n,) of the
# way from the first to the second, and the ray (n, 2) there
Between = Callable[[Indices, Indices, Image, Floats], Image]


def edges_of(view: View, flat: Floats, stage: CastBodies) -> Edges:
    """The nearest depth edge of every pixel of a rendered view.

    An edge is where the surface ends, or where the depth changes by more than 2 mm per metre within 1/64 px,
    otherwise than the slopes on both sides say.

    Args:
        flat: (h, w, 3) normals of the faces, towards the camera.
    """

    def cast(first: Indices, second: Indices, share: Image, ray: Floats) -> Image:
        found = stage.first(np.column_stack([ray, np.ones(len(ray), np.float32)])).t
        found[np.isinf(found)] = np.nan
        return found

    return edges_between(view, flat, cast)


def edges_between(view: View, flat: Floats, between: Between, reach: float = REACH_PX) -> Edges:
    """The same, as far as `reach` [px], of a view whose depth between pixels is told by rays or by images."""
    assert view.depth is not None and view.incidence is not None
    with np.errstate(all="ignore"):
        pairs = [_candidates(view.depth, flat, view.camera, axis) for axis in (1, 0)]
    first, second = (np.concatenate(side) for side in zip(*pairs, strict=True))
    crossings = _bisected(first, second, view, flat, between)
    with np.errstate(all="ignore"):
        amplitude = np.cos(view.incidence) / (view.depth * view.stretch) ** 2
    if view.reflectance is not None:
        amplitude = amplitude * view.reflectance
    return nearest_edges(crossings, view.depth, amplitude, reach)


def _candidates(depth: Image, flat: Floats, camera: Camera, axis: int) -> tuple[Indices, Indices]:
    """Indices of neighbours, and of the ones to the right or below, whose depths the slopes do not explain."""
    nothing = np.diff(np.isnan(depth), axis=axis)
    v, u = np.nonzero(_bent(depth, axis) | nothing)
    first = v * camera.width + u
    second = first + (1 if axis == 1 else camera.width)
    nothing = nothing[v, u]
    keep = nothing | _torn(depth, flat, camera, first, second)
    first, second, nothing = first[keep], second[keep], nothing[keep]
    keep = nothing | _torn(depth, flat, camera, second, first)
    return first[keep], second[keep]


def _bent(depth: Image, axis: int) -> NDArray[np.bool_]:
    """Pairs along an axis over which the depth changes, and otherwise than over both pairs beside it.

    A cheap first look: on a plane the inverse depth changes by the same from pixel to pixel.
    """
    inverse = 1.0 / depth
    change = np.diff(inverse, axis=axis)
    least = JUMP / 4 * (inverse[:-1] if axis == 0 else inverse[:, :-1])
    bent = ~(np.abs(np.diff(change, axis=axis)) < (least[:-1] if axis == 0 else least[:, :-1]))
    border = [(0, 0), (0, 0)]
    border[axis] = (1, 1)
    bent = np.pad(bent, border, constant_values=True)
    both = bent[:-1] & bent[1:] if axis == 0 else bent[:, :-1] & bent[:, 1:]
    return both & (np.abs(change) > least)


def _torn(depth: Image, flat: Floats, camera: Camera, own: Indices, other: Indices) -> NDArray[np.bool_]:
    """(n,) True where `other` pixels do not lie in the tangent planes of their neighbours."""
    rays, depth = camera.rays().reshape(-1, 2), depth.reshape(-1)
    predicted = _plane(depth[own], flat.reshape(-1, 3)[own], rays[own], rays[other])
    # a plane seen so much from its edge says nothing about the next pixel
    known = np.abs(predicted - depth[own]) < EDGE_ON * depth[own]
    return ~(known & (np.abs(predicted - depth[other]) <= JUMP * depth[own]))


def _plane(depth: Image, normals: Floats, own: Floats, other: Floats) -> NDArray[np.floating]:
    """Depth (n,) [m] along other rays (n, 2) of the planes that own rays meet; NaN where they do not meet them."""
    facing = normals[:, 0] * own[:, 0] + normals[:, 1] * own[:, 1] + normals[:, 2]
    along = normals[:, 0] * other[:, 0] + normals[:, 1] * other[:, 1] + normals[:, 2]
    with np.errstate(all="ignore"):
        predicted = depth * facing / along
    return np.where(predicted > 0, predicted, np.nan)


def _bisected(first: Indices, second: Indices, view: View, flat: Floats, between: Between) -> Crossings:
    """Halve the way between two pixels until the surface changes within 1/64 px; leaves out creases and slopes."""
    assert view.depth is not None
    rays, depth, planes = view.camera.rays().reshape(-1, 2), view.depth.reshape(-1), flat.reshape(-1, 3)
    low, high = np.zeros(len(first), np.float32), np.ones(len(first), np.float32)
    ends = np.column_stack([depth[first], depth[second]])
    for _ in range(STEPS):
        middle = (low + high) / 2
        ray = rays[first] + middle[:, None] * (rays[second] - rays[first])
        found = between(first, second, middle, ray)
        gaps = [
            _gap(found, ends[:, side], _plane(depth[i], planes[i], rays[i], ray))
            for side, i in enumerate((first, second))
        ]
        later = gaps[0] <= gaps[1]  # the middle still shows the first surface
        low, high = np.where(later, middle, low), np.where(later, high, middle)
        ends[later, 0], ends[~later, 1] = found[later], found[~later]
    sudden = ~(np.abs(ends[:, 1] - ends[:, 0]) < JUMP * ends.min(axis=1))
    return Crossings(first[sudden], second[sudden], ((low + high) / 2)[sudden], ends[sudden])


def _gap(found: Image, end: Image, plane: Image) -> NDArray[np.floating]:
    """(n,) how badly depths fit to a surface: to its nearest known depth or to its plane; nothing fits nothing."""
    gap = np.fmin(np.abs(found - end), np.abs(found - plane))
    return np.where(np.isnan(end), np.where(np.isnan(found), 0.0, np.inf), np.nan_to_num(gap, nan=np.inf))
