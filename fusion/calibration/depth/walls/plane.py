"""The wall in a depth image: one plane that most of the image agrees on, and the pixels that belong to it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.calibration.depth.walls.bend import smooth_part
from fusion.errors import FusionError
from fusion.geometry.camera import Camera

Image = NDArray[np.floating]

TRIES = 200  # random planes: with half the pixels on the wall 1 - (1 - 1/8)^200 find it
TOLERANCE = 0.03  # share of the depth: a sensor's own errors stay below, what stands before a wall does not
CLOSEST = 0.004  # [m] never cut closer than this
LEAST_SHARE = 0.2  # of the pixels with a depth that a wall fills at least
SAMPLE = 8000  # pixels that vote


@dataclass(frozen=True)
class WallPlane:
    """1 / z = (1 + a x + b y) / distance along the ray (x, y, 1); distance on the optical axis [m]."""

    distance: float
    a: float
    b: float

    def depth(self, camera: Camera) -> NDArray[np.floating]:
        """(h, w) depth along every pixel's ray [m]; NaN where a ray does not meet it."""
        rays = camera.rays().astype(float)
        inverse = (1.0 + self.a * rays[..., 0] + self.b * rays[..., 1]) / self.distance
        return np.where(inverse > 0, 1.0 / np.where(inverse > 0, inverse, 1.0), np.nan)

    def inverse_at(self, x: float, y: float) -> float:
        """Distance on the axis over the depth along the ray (x, y, 1)."""
        return 1.0 + self.a * x + self.b * y

    @property
    def tilt(self) -> float:
        """Angle between the optical axis and the normal [rad]."""
        return float(np.arctan(np.hypot(self.a, self.b)))


def find_wall(depth: Image, camera: Camera) -> tuple[WallPlane, NDArray[np.bool_]]:
    """The plane that most pixels of a depth image (h, w) [m] agree on, and the mask (h, w) of its pixels.

    Rotation is free, so a tilted wall is no scale error; what stands before it is left out. FusionError when less than
    a fifth of the known pixels agree.
    """
    known = np.isfinite(depth)
    v, u = np.nonzero(known)
    if len(v) < 100:
        raise FusionError("no wall found", found=f"{len(v)} px with a depth", expected="a wall that fills the view")
    some = np.random.default_rng(0).permutation(len(v))[:SAMPLE]
    rays = camera.rays().astype(float)
    basis = np.dstack([np.ones(camera.shape), rays])
    vote, z = basis[v[some], u[some]], depth[v[some], u[some]].astype(float)
    c = _consensus(vote, z)
    near = np.abs(depth * (basis @ c) - 1) < TOLERANCE
    if near.sum() < LEAST_SHARE * known.sum():
        share = f"{100 * near.sum() / known.sum():.0f} % of the pixels on one plane"
        raise FusionError("no wall found", found=share, expected="20 % or more", do="let the wall fill the view")
    with np.errstate(invalid="ignore"):
        mask = smooth_part(depth * (basis @ c) - 1, rays, near, CLOSEST * float(c[0]))
    return plane_through(depth, mask, camera), mask


def plane_through(depth: Image, mask: NDArray[np.bool_], camera: Camera) -> WallPlane:
    """The plane that fits the pixels of a mask (h, w) of a depth image (h, w) [m] best."""
    rays = camera.rays().astype(float)[mask]
    c = _least_squares(np.column_stack([np.ones(len(rays)), rays]), depth[mask].astype(float))
    return WallPlane(1 / c[0], c[1] / c[0], c[2] / c[0])


def _consensus(basis: NDArray, z: NDArray) -> NDArray[np.floating]:
    """Coefficients (3,) of 1 / z with the most pixels within the tolerance, then of these by least squares."""
    rng = np.random.default_rng(1)
    best: NDArray[np.floating] = np.zeros(3)
    most = -1
    for _ in range(TRIES):
        three = rng.choice(len(z), 3, replace=False)
        try:
            c = np.linalg.solve(basis[three], 1 / z[three])
        except np.linalg.LinAlgError:
            continue
        count = int((np.abs(z * (basis @ c) - 1) < TOLERANCE).sum())
        # seen from the axis a wall has a distance
        if count > most and c[0] > 0:
            best, most = c, count
    for _ in range(3):
        near = np.abs(z * (basis @ best) - 1) < TOLERANCE
        if near.sum() < 10:
            break
        best = _least_squares(basis[near], z[near])
    return best


def _least_squares(basis: NDArray, z: NDArray) -> NDArray[np.floating]:
    """The noise is in z: a row of 1 / z weighs z^2 less."""
    step = max(1, len(z) // 40000)
    A = basis[::step] * z[::step, None]
    # normal equations: three columns of one size, and some thirty times as fast as a decomposition
    return np.linalg.solve(A.T @ A, A.sum(axis=0))
