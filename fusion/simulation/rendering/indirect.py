"""Light that comes to a surface by one bounce off another one: lamp at the camera -> B -> A -> camera.

What the lamp lights is divided into cells, each the picture of one patch B of surface. A diffuse patch under a lamp of
the intensity I at the distance r_B, seen in the solid angle w_B, sends to a point A at the distance d the irradiance

    I cos(b) / r_B^2 * R_B / pi * cos(b') cos(a') / d^2 * area_B,      area_B = w_B r_B^2 / cos(b)

so that r_B and b cancel. The direct light gives A the irradiance I cos(a) / r_A^2, and both go on to the camera alike.
Surfaces that the lamp does not light send nothing, and of more bounces there are none.
"""

from dataclasses import dataclass, fields
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Camera
from fusion.sensor.view import Image, Indirect, View
from fusion.simulation.rendering.casting import CastBodies, Floats

LIFT = 1e-4  # shadow rays start and end this far above the surfaces, as a share of the depth
FAINT = 0.02  # of a point's indirect light, at most, comes from sources whose shadows are not looked at
GRAZING = 1e-3  # cosine: flatter light is weak, and rounding would let a plane shine on itself
ROUNDING = 2e-6  # of a few products in single precision, per metre
ROWS = 256  # points at once: 256 x 4800 sources are 5 MB an array
CELLS = 36  # patches along the longer side of the image; the time grows with the power of four


@dataclass(frozen=True)
class Bounce:
    """How indirect light is computed."""

    cell_px: int | None = None  # side of a patch [px]; None: a share of the image
    shadows: bool = True  # things between two patches hold the light back
    # by how much the lamp lights more than is seen, on each side, over the image: a diffuser has no sharp end (guess)
    beyond: float = 0.5

    def side(self, camera: Camera) -> int:
        """[px] of a patch."""
        return self.cell_px or max(1, round(max(camera.shape) / CELLS))

    def lit(self, camera: Camera) -> Camera:
        """A camera at the lamp whose pixels are the patches that it lights."""
        height, width = (max(1, round((1 + 2 * self.beyond) * n / self.side(camera))) for n in camera.shape)
        across, down = ((1 + 2 * self.beyond) * n / k for n, k in ((camera.width, width), (camera.height, height)))
        cx, cy = camera.cx + self.beyond * camera.width, camera.cy + self.beyond * camera.height
        return Camera(
            width, height, camera.fx / across, camera.fy / down, (cx + 0.5) / across - 0.5, (cy + 0.5) / down - 0.5
        )


class LampLit(NamedTuple):
    """What the lamp lights, and the normals (h, w, 3) of its faces, towards the camera."""

    view: View
    flat: Floats


@dataclass(frozen=True)
class _Patches:
    """What the cells of the image see, flattened: points and normals (n, 3), and as (n,) the rest."""

    points: Floats
    normals: Floats
    reach: Floats  # distance to the camera [m]
    facing: Floats  # cosine of the incidence
    sends: Floats  # reflectance / pi times the solid angle
    area: Floats  # [m^2]

    def part(self, rows: NDArray[np.intp]) -> "_Patches":
        return _Patches(*(getattr(self, own.name)[rows] for own in fields(self)))


def indirect_of(view: View, flat: Floats, stage: CastBodies, bounce: Bounce, lamp: "LampLit | None") -> Indirect:
    """Ratio and path (h, w) of the light of one bounce; 0 where there is none, or nothing is seen.

    Computed at the centres of cells, and between them interpolated along the surface.

    Args:
        flat: (h, w, 3) normals of the faces, towards the camera.
        lamp: what `bounce` says that the lamp lights; None where that is what is seen.
    """
    assert view.depth is not None
    v, u = (_centres(n, bounce.side(view.camera)) for n in view.depth.shape)
    seen = _patches(view, flat, np.ix_(v, u))
    lit = seen if lamp is None else _patches(*lamp, np.ix_(*map(np.arange, lamp.view.camera.shape)))
    ratio, longer = _gathered(seen, lit, stage if bounce.shadows else None)
    coarse = np.dstack([ratio, ratio * longer]).reshape(len(v), len(u), 2)
    fine = _interpolated(coarse, view, flat, v, u)
    with np.errstate(all="ignore"):
        path = np.where(fine[..., 0] > 0, fine[..., 1] / fine[..., 0], 0)
    return Indirect(fine[..., 0], path.astype(np.float32))


def _centres(pixels: int, cell: int) -> NDArray[np.intp]:
    """Middle pixels of equal cells of about `cell` px."""
    count = max(1, round(pixels / cell))
    return ((np.arange(count) + 0.5) * pixels / count - 0.5).round().astype(np.intp)


def _patches(view: View, flat: Floats, at: tuple[NDArray[np.intp], ...]) -> _Patches:
    """What some pixels see; each stands for as many as there are for each of them."""
    assert view.depth is not None and view.reflectance is not None
    rays, depth = view.camera.rays()[at], view.depth[at]
    stretch = view.stretch[at]
    cells = view.depth.size / (at[0].size * at[1].size)  # [px] that each stands for
    solid = _pixel_areas(view.camera)[at] * cells / stretch**3
    normals = flat[at]
    facing = -(normals * np.dstack([rays, np.ones_like(depth)])).sum(axis=-1) / stretch
    reach = depth * stretch
    flat_values = (reach, facing, view.reflectance[at] / np.pi * solid, solid * reach**2 / np.maximum(facing, 0.02))
    points = np.dstack([rays * depth[..., None], depth])
    return _Patches(
        points.reshape(-1, 3),
        normals.reshape(-1, 3),
        *(np.ascontiguousarray(value, np.float32).reshape(-1) for value in flat_values),
    )


def _pixel_areas(camera: Camera) -> Image:
    """Area (h, w) of each pixel on the plane z = 1."""
    if min(camera.shape) < 2:
        return np.full(camera.shape, 1 / (camera.fx * camera.fy), np.float32)
    rays = camera.rays()
    down, right = (np.asarray(np.gradient(rays, axis=axis)) for axis in (0, 1))
    return np.abs(right[..., 0] * down[..., 1] - right[..., 1] * down[..., 0])


def _gathered(patches: _Patches, lit: _Patches, stage: CastBodies | None) -> tuple[Floats, Floats]:
    """Amplitude ratio (n,) and mean extra path (n,) [m] at the points of the patches, of the light of others."""
    seen, lit = np.flatnonzero(np.isfinite(patches.reach)), lit.part(np.flatnonzero(np.isfinite(lit.reach)))
    ratio, longer = np.zeros(len(patches.reach), np.float32), np.zeros(len(patches.reach), np.float32)
    for start in range(0, len(seen), ROWS):
        rows = seen[start : start + ROWS]
        some = patches.part(rows)
        light, distance = _exchange(some, lit)
        if stage is not None:
            light *= _unblocked(some, lit, light, stage)
        total = light.sum(axis=1)
        extra = (lit.reach + distance - some.reach[:, None]) / 2
        ratio[rows] = total * some.reach**2 / np.maximum(some.facing, 0.02)
        longer[rows] = (light * extra).sum(axis=1) / np.maximum(total, 1e-30)
    return ratio, longer


def _exchange(some: _Patches, lit: _Patches) -> tuple[Floats, Floats]:
    """Irradiance (some, lit) that comes to the ones from the others, the lamp's intensity being 1, and how far [m]."""
    a, b = some.points.T[:, :, None], lit.points.T[:, None]
    n_a, n_b = some.normals.T[:, :, None], lit.normals.T[:, None]
    x, y, z = (b[axis] - a[axis] for axis in range(3))
    squared = x * x + y * y + z * z
    # d cos a' and d cos b': positive where the surfaces look at each other
    to_b = n_a[0] * x + n_a[1] * y + n_a[2] * z
    to_a = -(n_b[0] * x + n_b[1] * y + n_b[2] * z)
    # a patch of finite size: the disc's 1 / (d^2 + area / pi) instead of 1 / d^2
    spread = squared + lit.area / np.pi
    distance = np.sqrt(squared)
    light = lit.sends * to_a * to_b / np.maximum(squared * spread, 1e-12)
    least = GRAZING * distance + ROUNDING * some.reach[:, None]
    light[(to_a < least) | (to_b < least)] = 0
    return light, distance


def _unblocked(some: _Patches, lit: _Patches, light: Floats, stage: CastBodies) -> NDArray[np.bool_]:
    """(some, lit) False where something stands between two patches that exchange noticeable light."""
    free = np.ones(light.shape, bool)
    i, j = np.nonzero(light > FAINT * light.sum(axis=1)[:, None] / light.shape[1])
    a, b = (patches.points + LIFT * patches.points[:, 2:] * patches.normals for patches in (some, lit))
    free[i, j] = ~stage.blocked(a[i], b[j])
    return free


def _interpolated(coarse: Floats, view: View, flat: Floats, v: NDArray[np.intp], u: NDArray[np.intp]) -> Floats:
    """Values (rows, columns, k) at the centres of cells as images (h, w, k), between centres on the same surface."""
    assert view.depth is not None
    points = view.camera.points(view.depth)
    top, down = _between(view.depth.shape[0], v)
    left, right = _between(view.depth.shape[1], u)
    total = np.zeros((*view.depth.shape, coarse.shape[2]), np.float32)
    weights = np.zeros(view.depth.shape, np.float32)
    for i, along in ((top, 1 - down), (np.minimum(top + 1, len(v) - 1), down)):
        for j, across in ((left, 1 - right), (np.minimum(left + 1, len(u) - 1), right)):
            pixel = np.ix_(v[i], u[j])
            off = np.abs(((points[pixel] - points) * flat).sum(axis=-1)) / view.depth
            alike = np.clip((flat[pixel] * flat).sum(axis=-1), 0, 1)
            # off the plane by 1 % of the distance, or turned by 30 deg: another surface
            same = np.exp(-((off / 0.01) ** 2)) * alike**8 + np.float32(1e-6)
            weight = np.nan_to_num(along[:, None] * across * same)
            weights += weight
            total += weight[..., None] * coarse[np.ix_(i, j)]
    return (total / np.maximum(weights, 1e-12)[..., None]).astype(np.float32)


def _between(pixels: int, centres: NDArray[np.intp]) -> tuple[NDArray[np.intp], Floats]:
    """For each pixel the centre before it and the share of the way to the next; held at the borders."""
    if len(centres) == 1:
        return np.zeros(pixels, np.intp), np.zeros(pixels, np.float32)
    place = np.interp(np.arange(pixels), centres, np.arange(len(centres)))
    before = np.minimum(place.astype(np.intp), len(centres) - 2)
    return before, (place - before).astype(np.float32)
