"""Analytic scenes: rectangles with printed patches, hit by the rays of a pinhole camera."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

MARGIN = 0.02  # of the tangent plane of the image: a bowed panel is seen a little beside its flat one


@dataclass(frozen=True)
class Bow:
    """A smooth shape that a surface really has and its mesh has not: a sum of waves, in metres along the normal."""

    heights: Array  # (k,)
    waves: Array  # (k, 3) cycles along both edges, phase

    def at(self, s: Array, t: Array) -> Array:
        out = np.zeros(s.shape)
        for height, (a, b, phase) in zip(self.heights, self.waves, strict=True):
            out += height * np.cos(2 * np.pi * (a * s + b * t) + phase)
        return out


@dataclass(frozen=True)
class Panel:
    """A rectangle: corner (3,), edges a and b (3,) [m], reflectance of its cells (rows along b, columns along a)."""

    corner: Array
    a: Array
    b: Array
    cells: Array
    bow: Bow | None = None

    @property
    def normal(self) -> Array:
        n = np.cross(self.a, self.b)
        return np.asarray(n / np.linalg.norm(n))


@dataclass(frozen=True)
class Camera:
    """Pinhole without distortion; the centre of the top-left pixel is (0, 0)."""

    width: int
    height: int
    f: float
    cx: float
    cy: float

    def rays(self, du: float = 0.0, dv: float = 0.0) -> Array:
        """(h, w, 3) directions with z = 1, `du, dv` px from the pixel centres."""
        u, v = np.meshgrid(np.arange(self.width) + du, np.arange(self.height) + dv)
        return np.stack([(u - self.cx) / self.f, (v - self.cy) / self.f, np.ones_like(u)], axis=-1)


@dataclass(frozen=True)
class Hits:
    """What the rays met: all (h, w), `z` NaN where nothing is."""

    z: Array
    cosine: Array
    reflectance: Array
    panel: NDArray[np.intp]
    points: Array  # (h, w, 3) world


def cast(panels: list[Panel], T: Array, rays: Array) -> Hits:
    """First panel on every ray; T (4, 4) camera to world."""
    origin, shape = T[:3, 3], rays.shape[:2]
    z, reflectance, cosine = np.full(shape, np.inf), np.zeros(shape), np.zeros(shape)
    which = np.full(shape, -1)
    lengths = np.linalg.norm(rays, axis=-1)
    for i, panel in enumerate(panels):
        window = _window(panel, T, rays)
        directions, nearest = rays[window] @ T[:3, :3].T, z[window]
        n, facing = panel.normal, directions @ panel.normal
        with np.errstate(divide="ignore", invalid="ignore"):
            t = ((panel.corner - origin) @ n) / facing
            at = origin + t[..., None] * directions - panel.corner
            s, q = at @ panel.a / (panel.a @ panel.a), at @ panel.b / (panel.b @ panel.b)
            if panel.bow is not None:
                t = t + panel.bow.at(s, q) / facing
        inside = (s >= 0) & (s < 1) & (q >= 0) & (q < 1) & (t > 0.05) & (t < nearest)
        rows, columns = panel.cells.shape
        cell = panel.cells[(q[inside] * rows).astype(int), (s[inside] * columns).astype(int)]
        nearest[inside], reflectance[window][inside], which[window][inside] = t[inside], cell, i
        cosine[window][inside] = np.abs(facing[inside]) / lengths[window][inside]
    z[which < 0] = np.nan
    return Hits(z, cosine, reflectance, which, origin + (z[..., None] * rays) @ T[:3, :3].T)


def _window(panel: Panel, T: Array, rays: Array) -> tuple[slice, slice]:
    """Rows and columns of the image beyond which no ray meets the panel."""
    corners = np.array([panel.corner, panel.corner + panel.a, panel.corner + panel.b, panel.corner + panel.a + panel.b])
    seen = (corners - T[:3, 3]) @ T[:3, :3]
    if np.min(seen[:, 2]) < 0.05:
        return slice(None), slice(None)
    flat = seen[:, :2] / seen[:, 2:]
    (left, top), (right, bottom) = flat.min(axis=0) - MARGIN, flat.max(axis=0) + MARGIN
    across, down = rays[0, :, 0], rays[:, 0, 1]
    columns = slice(*np.searchsorted(across, [left, right]))
    return slice(*np.searchsorted(down, [top, bottom])), columns


def joined(parts: list[Hits]) -> Hits:
    """Bands of rows as one image."""
    return Hits(**{name: np.concatenate([getattr(part, name) for part in parts]) for name in Hits.__annotations__})


def blocked(panels: list[Panel], hits: Hits, source: Array) -> NDArray[np.bool_]:
    """Points (h, w) that `source` (3,) does not see."""
    out = np.zeros(hits.z.shape, bool)
    away = hits.points - source
    for i, panel in enumerate(panels):
        with np.errstate(divide="ignore", invalid="ignore"):
            t = ((panel.corner - source) @ panel.normal) / (away @ panel.normal)
            at = source + t[..., None] * away - panel.corner
            s, q = at @ panel.a / (panel.a @ panel.a), at @ panel.b / (panel.b @ panel.b)
        out |= (hits.panel != i) & (t > 0) & (t < 0.999) & (s > 0) & (s < 1) & (q > 0) & (q < 1)
    return out


def looking(position: Array, target: Array, roll: float = 0.0) -> Array:
    """(4, 4) pose of a camera at `position` that looks at `target`; world z is up."""
    forward = (target - position) / np.linalg.norm(target - position)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    down = np.cross(forward, right)
    x = np.cos(roll) * right + np.sin(roll) * down
    T = np.eye(4)
    T[:3, :3] = np.column_stack([x, np.cross(forward, x), forward])
    T[:3, 3] = position
    return T


def nudged(T: Array, motion: Array) -> Array:
    """The pose moved by `motion` (6,): rotation [rad] and translation [m] in the camera's own axes."""
    angle = float(np.linalg.norm(motion[:3]))
    step = np.eye(4)
    if angle > 0:
        x, y, z = motion[:3] / angle
        k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        step[:3, :3] = np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k
    step[:3, 3] = motion[3:]
    return T @ step
