"""How well the walls and boards of a unit can tell the scale of its scans at best.

A model's size is that of what is seen: across, z / f; so

    sd(scale)^2 = (sd(z) / z)^2 + (sd(f) / f)^2        at the object's distance z.

sd(f): from the corners of all boards, sd(f)^2 = (s^2 (J' J)^-1)_ff, J the derivatives of all corners by f, the centre,
k1, k2, p1, p2 and each board's pose, s the standard deviation of a corner in one direction: the Cramer-Rao bound of the
written pictures and their noise, but at least 0.02 px. f counts as the mean of log fx and log fy.

sd(z): from the walls. Ring by ring of the image (x^2 + y^2 = q), a wall k shows how far its depth is off,

    e(k, q) = laser_k + sum_j a_j g_j(z_k, q),    laser_k ~ N(0, 0.7 mm), each ring with 0.3 mm of noise of its own

and a_j has the spread with which the generator draws it: time of flight: offset, radius^2, and for each modulation the
3rd and 6th wave of the phase (what three samples leave of the harmonics), sine and cosine, of the range; triangulation:
z (the device's constant), z^2 (a shift of the disparity), z^2 q (its warp). The posterior of sum_j a_j g_j(z, 0) at the
object's z is the variance. Someone who knows these forms reaches it, nobody does better from walls: a bound.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from tools.sets.fresh.flight import SHARE, TURN
from tools.sets.fresh.picture import variance
from tools.sets.fresh.unit import LASER
from tools.sets.fresh.views import COLUMNS, ROWS, SQUARE

Array = NDArray[np.float64]

FLOOR = 0.02  # [px] what no detector passes, whatever the noise (guess)
RING = 0.0003  # [m] of fixed pattern and noise that are left in the mean of a ring (guess)


@dataclass(frozen=True)
class Allowed:
    """Relative standard deviations, the corners' [px], and that of the angles [deg] (`angles.py`; NaN: not made)."""

    scale: float
    depth: float
    focal: float
    corner_px: float
    angle: float = np.nan


def allowed(folder: Path, truth: dict[str, Any]) -> Allowed:
    """Of the unit in a folder."""
    corners = np.array(truth["corners"], float)
    pictures = sorted((folder / "board" / "ir").iterdir(), key=lambda file: float(file.stem))
    spread = corner_std(pictures, corners)
    focal = focal_std(truth["camera"], corners, spread)
    z = float(truth["camera_distance_m"])
    depth = depth_std(np.array(truth["walls_m"], float), z, truth["sensor"] == "itof") / z
    return Allowed(float(np.hypot(depth, focal)), depth, focal, spread, truth.get("angle_std_deg", np.nan))


def corner_std(pictures: list[Path], corners: Array) -> float:
    """Of a corner in one direction [px]: the Cramer-Rao bound of its 7 x 7 px, the median, not below FLOOR."""
    found = []
    for picture, true in zip(pictures, corners, strict=True):
        image = np.asarray(cv2.imread(str(picture), cv2.IMREAD_UNCHANGED), float)
        down, across = np.gradient(gaussian_filter(image, 0.5))
        for u, v in np.rint(true).astype(int):
            at = slice(max(v - 3, 0), v + 4), slice(max(u - 3, 0), u + 4)
            slope = np.stack([across[at].ravel(), down[at].ravel()], axis=1)
            information = slope.T @ (slope / variance(image[at]).ravel()[:, None])
            found.append(np.sqrt(np.trace(np.linalg.inv(information)) / 2))
    return max(float(np.median(found)), FLOOR)


def focal_std(camera: dict[str, Any], corners: Array, spread: float) -> float:
    """Relative standard deviation of the focal length by all boards (n, corners, 2)."""
    K = np.array([[camera["fx"], 0, camera["cx"]], [0, camera["fy"], camera["cy"]], [0, 0, 1]])
    bend = np.array(camera["distortion"], float)
    v, u = np.mgrid[:ROWS, :COLUMNS]
    flat = np.stack([u, v, np.zeros(u.shape)], axis=-1).reshape(-1, 3) * SQUARE
    shared, normal = 8, np.zeros((8, 8))
    for seen in corners:
        _, turn, shift = cv2.solvePnP(flat, seen, K, bend)[:3]
        J = cv2.projectPoints(flat, turn, shift, K, bend)[1]  # turn, shift, f, c, k1 k2 p1 p2 k3
        own, rest = J[:, :6], J[:, 6 : 6 + shared]
        normal += rest.T @ rest - rest.T @ own @ np.linalg.solve(own.T @ own, own.T @ rest)
    covariance = spread**2 * np.linalg.inv(normal)
    way = np.zeros(shared)
    way[:2] = 0.5 / camera["fx"], 0.5 / camera["fy"]
    return float(np.sqrt(way @ covariance @ way))


def depth_std(walls: Array, z: float, flight: bool) -> float:
    """Standard deviation [m] of the depth at z by walls at `walls` [m]."""
    own = terms(np.array([z]), np.array([0.02]), flight)[0][0]
    return float(np.sqrt(own @ posterior(walls, flight) @ own))


def posterior(walls: Array, flight: bool) -> Array:
    """Covariance of the sizes of all terms by walls at `walls` [m]."""
    q = np.linspace(0, 0.35, 12)
    rows, spread = terms(np.repeat(walls, len(q)), np.tile(q, len(walls)), flight)
    laser = np.kron(np.eye(len(walls)), np.ones((len(q), len(q))))
    noise = LASER**2 * laser + RING**2 * np.eye(len(rows))
    return np.asarray(np.linalg.inv(rows.T @ np.linalg.solve(noise, rows) + np.diag(1 / spread**2)))


def terms(z: Array, q: Array, flight: bool) -> tuple[Array, Array]:
    """(n, terms) what each term adds [m] at unit size, and the standard deviations of their sizes."""
    if not flight:
        per_px = z**2 / (285.0 * 0.075)
        return np.stack([z, per_px, per_px * q], axis=-1), np.array([0.004, 0.05, 0.08])
    rows, spread = [np.ones_like(z), q], [0.005, 0.009]
    r = z * np.sqrt(1 + q)
    for modulation, phase in enumerate(TURN):
        for order, size in ((3, 0.01), (6, 0.015)):  # of the fundamental, which three samples mistake it for
            rows += [np.cos(order * phase * r), np.sin(order * phase * r)]
            spread += 2 * [size * SHARE[modulation] / phase]
    return np.stack(rows, axis=-1), np.array(spread)
