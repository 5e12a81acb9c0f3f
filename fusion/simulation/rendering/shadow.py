"""Where the projector or lamp reaches what the camera sees."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.sensor.view import Image, View
from fusion.simulation.rendering.casting import CastBodies, Floats, directions

# A shadow ray ends this far above the surface, as a share of its depth, so that the surface does not shade itself;
# single precision is 1e-7 of a metre per metre, a hundred times finer
LIFT = 2e-5
AT_ONCE = 65536  # rays, whose vectors nearly stay in the processor's cache
SPLIT = 3  # a pixel on the border of a shadow is seen by SPLIT x SPLIT rays


def lit_of(view: View, flat: Floats, stage: CastBodies, x: float) -> Image:
    """Share (h, w) of each pixel that a projector at (x, 0, 0) [m] in the camera frame reaches.

    1 where nothing is seen: that is no shadow. A lamp at the camera (x = 0) reaches all that the camera sees.

    Args:
        flat: (h, w, 3) normals of the faces, towards the camera.
    """
    assert view.depth is not None
    lit = np.ones(view.depth.shape, np.float32)
    if x == 0.0:
        return lit
    seen = np.isfinite(view.depth)
    rays, normals, reached = directions(view.camera), flat.reshape(-1, 3), lit.reshape(-1)
    for start in range(0, len(rays), AT_ONCE):
        part = slice(start, start + AT_ONCE)
        there = np.flatnonzero(seen.reshape(-1)[part])
        block: Any = part if len(there) == len(rays[part]) else start + there
        points = rays[block] * view.depth.reshape(-1)[block, None]
        reached[block] = _reached(points, normals[block], stage, x)
    border = _border(lit, seen) | _narrow(view, x)
    lit[border] = _shares(view, border, stage, x)
    return lit


def _reached(points: Image, flat: Floats, stage: CastBodies, x: float) -> NDArray[np.bool_]:
    """(n,) whether light from the projector reaches the front of points (n, 3)."""
    projector = np.array([x, 0.0, 0.0], np.float32)
    ends = points + (LIFT * points[:, 2:]) * flat
    front = np.einsum("nk,nk->n", projector - points, flat) > 0
    return front & ~stage.blocked(projector, ends)


def _border(lit: Image, seen: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Pixels (h, w) next to one that is lit otherwise."""
    border = np.zeros(lit.shape, bool)
    for a, b in ((np.s_[:, :-1], np.s_[:, 1:]), (np.s_[:-1], np.s_[1:])):
        differs = (lit[a] != lit[b]) & seen[a] & seen[b]
        border[a] |= differs
        border[b] |= differs
    return border


def _narrow(view: View, x: float) -> NDArray[np.bool_]:
    """Pixels (h, w) beside a step of depth that hides a part of them from a projector at x [m]: less than one pixel may
    lie between those that are lit."""
    assert view.depth is not None
    with np.errstate(all="ignore"):
        width = view.camera.fx * abs(x) * np.abs(np.diff(1.0 / view.depth, axis=1))
    steps, narrow = width > 1.0 / SPLIT, np.zeros(view.depth.shape, bool)
    narrow[:, :-1] |= steps
    narrow[:, 1:] |= steps
    return narrow


def _shares(view: View, border: NDArray[np.bool_], stage: CastBodies, x: float) -> NDArray[np.float32]:
    """Share (n,) of the pixels of `border` that is lit, by a grid of rays in each pixel."""
    v, u = np.nonzero(border)
    rays = view.camera.rays()
    along_u, along_v = _steps(rays, v, u)
    offsets = (np.arange(SPLIT, dtype=np.float32) + 0.5) / SPLIT - 0.5
    dv, du = (grid.ravel()[None, :, None] for grid in np.meshgrid(offsets, offsets, indexing="ij"))
    inside = rays[v, u][:, None] + du * along_u[:, None] + dv * along_v[:, None]
    sub = np.concatenate([inside, np.ones((*inside.shape[:2], 1), np.float32)], axis=2).reshape(-1, 3)
    hits = stage.first(sub)
    hit = np.isfinite(hits.t)
    towards = np.where(np.einsum("nk,nk->n", hits.normals, sub) > 0, np.float32(-1), np.float32(1))
    normals = hits.normals * towards[:, None]
    lit = np.ones(len(hit), np.float32)
    lit[hit] = _reached(sub[hit] * hits.t[hit, None], normals[hit], stage, x)
    return lit.reshape(len(v), SPLIT**2).mean(axis=1)


def _steps(rays: Floats, v: NDArray[np.int64], u: NDArray[np.int64]) -> tuple[Floats, Floats]:
    """How the rays (n, 2) of pixels change by one pixel to the right, and down."""
    height, width = rays.shape[:2]
    right, left = np.minimum(u + 1, width - 1), np.maximum(u - 1, 0)
    below, above = np.minimum(v + 1, height - 1), np.maximum(v - 1, 0)
    along_u = (rays[v, right] - rays[v, left]) / np.maximum(right - left, 1)[:, None].astype(np.float32)
    along_v = (rays[below, u] - rays[above, u]) / np.maximum(below - above, 1)[:, None].astype(np.float32)
    return along_u, along_v
