"""Planes and spheres laid through points by least squares, and how far the points lie off them.

VDI/VDE 2634 sheet 2 (2012) and 3 (2008) and ISO 10360-13 ask for least squares, a free radius, and allow three of a
thousand points to be left out.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
LEFT_OUT = 0.003  # share of the points


@dataclass(frozen=True)
class Plane:
    """Points x with normal . x = offset [m]; the normal is (3,), of length 1."""

    normal: Array
    offset: float

    def away(self, points: Array) -> Array:
        """Signed distances (n,) [m]."""
        return np.asarray(points @ self.normal - self.offset)

    def facing(self, points: Array) -> Array:
        """Normals (n, 3) at points."""
        return np.broadcast_to(self.normal, points.shape)


@dataclass(frozen=True)
class Sphere:
    """Centre (3,) and radius [m]; `outward` is -1 for a hollow one."""

    centre: Array
    radius: float
    outward: int = 1

    def away(self, points: Array) -> Array:
        """Signed distances (n,) [m], positive outside."""
        return np.asarray(np.linalg.norm(points - self.centre, axis=1) - self.radius)

    def facing(self, points: Array) -> Array:
        """Normals (n, 3) at points."""
        out = points - self.centre
        return np.asarray(self.outward * out / np.maximum(np.linalg.norm(out, axis=1, keepdims=True), 1e-12))


Form = Plane | Sphere


def fit_plane(points: Array, towards: Array) -> Plane:
    """Through points (n, 3), its normal on the side of `towards` (3,)."""
    middle = points.mean(axis=0)
    normal = np.linalg.svd(points - middle, full_matrices=False)[2][2]
    normal = normal if normal @ towards >= 0 else -normal
    return Plane(normal, float(normal @ middle))


def fit_sphere(points: Array, outward: int = 1) -> Sphere:
    """Through points (n, 3): linear first, then Gauss and Newton's steps on the distances."""
    middle = points.mean(axis=0)
    p = points - middle
    solved = np.linalg.lstsq(np.column_stack([2 * p, np.ones(len(p))]), (p**2).sum(axis=1), rcond=None)[0]
    centre, radius = solved[:3], float(np.sqrt(max(solved[3] + solved[:3] @ solved[:3], 1e-12)))
    for _ in range(10):
        out = p - centre
        far = np.maximum(np.linalg.norm(out, axis=1), 1e-12)
        J = np.column_stack([-out / far[:, None], -np.ones(len(p))])
        step = np.linalg.lstsq(J, radius - far, rcond=None)[0]
        centre, radius = centre + step[:3], radius + float(step[3])
        if np.abs(step).max() < 1e-9:
            break
    return Sphere(centre + middle, radius, outward)


def refit(form: Form, points: Array) -> Form:
    """The same kind of form through other points."""
    if isinstance(form, Plane):
        return fit_plane(points, form.normal)
    return fit_sphere(points, form.outward)


def form_error(form: Form, points: Array) -> float:
    """Width [m] of the band about a form that holds all points but three of a thousand."""
    low, high = np.quantile(form.away(points), [LEFT_OUT / 2, 1 - LEFT_OUT / 2])
    return float(high - low)
