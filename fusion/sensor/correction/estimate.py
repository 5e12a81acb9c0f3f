"""A view estimated from a measurement: what can be known of a surface from its depth image alone."""

from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Camera
from fusion.sensor.edges.nearest import Crossings, Indices, nearest_edges
from fusion.sensor.edges.neighbours import pairs_along, steps_along, stride_along
from fusion.sensor.effects.light.illumination_vignetting import IR_AT_1M
from fusion.sensor.effects.light.projector_shadow import shadowed
from fusion.sensor.moment import Moment
from fusion.sensor.view import Edges, Image, View, incidence_of

# share of the depth: smaller steps of a measured image are noise, or slopes up to 85 deg at fx = 585 px
JUMP = 0.02
GAP_PX = 6  # narrower holes are pixels lost at an edge, or single ones


def estimated_view(
    depth: Image,
    camera: Camera,
    ir: NDArray | None = None,
    moment: Moment | None = None,
    projector: float | None = None,
) -> View:
    """The view of a measured depth image (h, w) [m]: normals by central differences, edges to a pixel.

    Normals and incidence are NaN where a neighbour is missing, and rough where the depth is noisy. Nothing is known
    of indirect light, motion and what the camera does not see.

    Args:
        ir: (h, w) amplitude [count]; gives the reflectance, as of a sensor model without effects on the light.
        projector: where it stands on the camera's x axis [m], negative to the left; gives what is lit (1 where
            the depth is missing). None: not known.
    """
    normals = normals_of(depth, camera)
    with np.errstate(all="ignore"):
        view = View(camera, depth, incidence_of(normals, camera), normals, ir=ir)
        view = replace(view, edges=edges_of(view))
        if ir is not None:
            view = replace(view, reflectance=reflectance_of(view))
        if projector is not None:
            lit = 1.0 - shadowed(depth, projector, view)
            view = replace(view, baseline=projector, lit=np.where(np.isfinite(depth), lit, 1.0).astype(depth.dtype))
    return view if moment is None else replace(view, moment=moment)


def reflectance_of(view: View) -> Image:
    """Reflectance (h, w) [1] of a view that has amplitude, depth and incidence."""
    assert view.ir is not None and view.depth is not None
    # beyond 84 deg the amplitude is mostly noise
    facing = 1.0 if view.incidence is None else np.maximum(np.cos(view.incidence), 0.1)
    return np.asarray(view.ir * (view.depth * view.stretch) ** 2 / (IR_AT_1M * facing))


def normals_of(depth: Image, camera: Camera) -> Image:
    """Unit normals (h, w, 3) of a depth image by central differences of its points; NaN where a neighbour misses."""
    points = camera.points(depth)
    normals = np.full(points.shape, np.nan, np.float32)
    with np.errstate(all="ignore"):
        along_u = points[1:-1, 2:] - points[1:-1, :-2]
        along_v = points[2:, 1:-1] - points[:-2, 1:-1]
        normal = np.cross(along_v, along_u)
        normals[1:-1, 1:-1] = normal / np.linalg.norm(normal, axis=-1, keepdims=True)
    return normals


def edges_of(view: View) -> Edges:
    """The nearest edge of every pixel: half way between neighbours whose depths differ by 2 %, and not by a slope.

    Holes narrower than 6 px are bridged, with the edge in their middle; at larger ones the surface ends. The light
    across an edge is measured where there is `ir`, else that of equal reflectances.
    """
    assert view.depth is not None
    filled = bridged(view.depth)
    depth = view.depth.reshape(-1)[filled].astype(np.float32)
    first, second = (np.concatenate(side) for side in zip(jumps_along(depth, 1), jumps_along(depth, 0), strict=True))
    z = depth.reshape(-1)
    middle = np.full(len(first), 0.5, np.float32)
    with np.errstate(all="ignore"):
        light = 1.0 / (depth * view.stretch) ** 2 if view.ir is None else view.ir.reshape(-1)[filled]
        return nearest_edges(Crossings(first, second, middle, np.column_stack([z[first], z[second]])), depth, light)


def bridged(depth: Image) -> Indices:
    """(h, w) index of the pixel that each takes its value from: in narrow holes the nearest one, else itself."""
    own = np.arange(depth.size).reshape(depth.shape)
    missing = ~np.isfinite(depth)
    if not missing.any() or missing.all():
        return own
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (GAP_PX + 1, GAP_PX + 1))
    closed = cv2.morphologyEx((~missing).view(np.uint8), cv2.MORPH_CLOSE, kernel)
    holes = np.flatnonzero(closed.view(bool) & missing)
    if not len(holes):
        return own
    _, label = cv2.distanceTransformWithLabels(
        missing.view(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_5, labelType=cv2.DIST_LABEL_PIXEL
    )
    known, label = np.flatnonzero(~missing), label.reshape(-1)
    seen = np.zeros(depth.size + 1, own.dtype)
    seen[label[known]] = known
    own.reshape(-1)[holes] = seen[label[holes]]
    return own


def jumps_along(depth: Image, axis: int) -> tuple[Indices, Indices]:
    """Indices of neighbours along an axis, and of the ones to the right or below, with an edge in between."""
    z, stride = np.ascontiguousarray(depth).reshape(-1), stride_along(depth, axis)
    missing = np.isnan(z)
    ends = pairs_along(depth, axis, missing[stride:] != missing[:-stride])
    first = steps_along(depth, axis, JUMP)
    with np.errstate(all="ignore"):
        change = _change(z, first, stride)
        # on a slope the inverse depth changes alike from pixel to pixel; of two pairs on each side the flatter one
        # counts, because between two surfaces a pixel may show neither
        place = first // stride % depth.shape[axis]
        before, near, after, far = (
            np.where(
                (place + by >= 0) & (place + by < depth.shape[axis] - 1),
                np.nan_to_num(_change(z, np.clip(first + by * stride, 0, z.size - 1 - stride), stride)),
                0,
            )
            for by in (-2, -1, 1, 2)
        )
        slope = np.maximum(np.minimum(before, near), np.minimum(after, far))
        nearer = np.fmax(1 / z[first], 1 / z[first + stride])
        first = np.union1d(first[(change > JUMP * nearer) & (slope < change / 2)], ends)
    if axis == 0:  # column by column
        first = first[np.lexsort((first // stride, first % stride))]
    return first, first + stride


def _change(z: Image, first: Indices, stride: int) -> Image:
    """Difference (n,) of the inverse depths of pixels and the next ones."""
    return np.abs(1 / z[first + stride] - 1 / z[first])
