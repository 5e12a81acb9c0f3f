"""Points that a colour image shows again: corners with a descriptor and a place, and the motion that brings those of
one image onto those of another.

ORB (Rublee, Rabaud, Konolige and Bradski 2011) by OpenCV; the motion by random samples of three (Fischler and Bolles
1981) in three dimensions, as the depth is known.
"""

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.geometry.depth import PointMap
from fusion.geometry.pose import pose, transform

Array = NDArray[np.float64]

MOST = 500  # landmarks of an image
RATIO = 0.85  # a match must be so much better than the second best (Lowe 2004, sec. 7.1, took 0.8 for SIFT)
SAMPLES = 2000  # of three matches; all wrong with 1 % at a share of right ones of 13 %
SHAPE_SAMPLES = 20_000  # of surfaces, whose matches are worse: at a share of 6 %
TRIED = 200  # of the samples whose three sides are as long in both images
FEWEST = 15  # matches that move alike (guess: three wrong ones fix a motion, that twelve more follow is no chance)
WITHIN = 3.0  # standard deviations
BORDER = 15  # of the image without landmarks: half of what a descriptor looks at [px]
PLACED = 1.5  # standard deviation of a landmark in the image [px]: detector and octaves (guess)


@dataclass(frozen=True)
class Landmarks:
    """Landmarks of an image."""

    points: Array  # (n, 3) in the camera's frame [m]
    sigma: Array  # (n,) standard deviation of a point's place [m]
    descriptors: NDArray[Any]  # (n, 32) uint8 bits, or (n, 33) float32 histograms of a surface

    def __len__(self) -> int:
        return len(self.points)


@dataclass(frozen=True)
class Met:
    """Two images that show the same."""

    T_a_b: Array  # (4, 4)
    left: NDArray[np.int64]  # (m,) landmarks of a that agree
    right: NDArray[np.int64]  # (m,) the same ones of b
    information: Array  # (6, 6) inverse covariance of a left twist, turns about `centre`: [rad], [m]
    centre: Array  # (3,) in the frame of a [m]

    @property
    def count(self) -> int:
        """Landmarks that agree."""
        return len(self.left)


def landmarks(grey: NDArray[np.uint8], surface: PointMap) -> Landmarks:
    """Landmarks of a grey image (h, w) in the pixels of a point map; those beside holes and steps are left out."""
    detector = cv2.ORB_create(MOST, scaleFactor=1.3, nlevels=6, edgeThreshold=BORDER, fastThreshold=10)  # type: ignore[attr-defined]
    found, descriptors = detector.detectAndCompute(np.ascontiguousarray(grey), None)
    if descriptors is None or not len(found):
        return Landmarks(np.zeros((0, 3)), np.zeros(0), np.zeros((0, 32), np.uint8))
    at = np.array([key.pt for key in found])
    u, v = np.rint(at).astype(int).T
    known = np.isfinite(surface.normals[v, u, 0])
    u, v = u[known], v[known]
    points = surface.points[v, u].astype(float)
    aside = PLACED * points[:, 2] / surface.camera.fx
    return Landmarks(points, np.hypot(surface.sigma[v, u], aside), descriptors[known])


def meet(a: Landmarks, b: Landmarks) -> Met | None:
    """The motion that brings landmarks of b onto those of a; None where too few agree on one."""
    if min(len(a), len(b)) < FEWEST:
        return None
    left, right = _matches(a.descriptors, b.descriptors)
    if len(left) < FEWEST:
        return None
    targets, points = a.points[left], b.points[right]
    sigma = np.hypot(a.sigma[left], b.sigma[right])
    rng = np.random.default_rng(0)  # the same images, the same answer
    samples = SAMPLES if a.descriptors.dtype == np.uint8 else SHAPE_SAMPLES
    picks = rng.integers(0, len(left), (samples, 3))
    picks = picks[_rigid_triples(points[picks], targets[picks], sigma[picks])][:TRIED]
    if not len(picks):
        return None
    R, t = _rigid(points[picks], targets[picks], np.ones(picks.shape))
    off = np.linalg.norm(np.einsum("sij,mj->smi", R, points) + t[:, None] - targets, axis=2)
    fits = off < WITHIN * sigma
    best = fits[int(fits.sum(axis=1).argmax())]
    T = np.eye(4)
    for _ in range(4):
        if best.sum() < FEWEST:
            return None
        weights = 1 / sigma[best] ** 2
        R, t = _rigid(points[best][None], targets[best][None], weights[None])
        T = pose(R[0], t[0])
        best = np.linalg.norm(transform(T, points) - targets, axis=1) < WITHIN * sigma
    if best.sum() < FEWEST:
        return None
    information, centre = _information(targets[best], sigma[best])
    return Met(T, left[best], right[best], information, centre)


def _matches(a: NDArray[Any], b: NDArray[Any]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Positions of descriptors that are each other's nearest, and clearly so."""
    if a.dtype != np.uint8:
        return _mutual(a, b)
    pairs = cv2.BFMatcher(cv2.NORM_HAMMING).knnMatch(b, a, k=2)
    pairs = [pair for pair in pairs if len(pair) == 2 and pair[0].distance < RATIO * pair[1].distance]
    good = [(best.trainIdx, best.queryIdx, best.distance) for best, _ in pairs]
    if not good:
        return np.zeros(0, int), np.zeros(0, int)
    left, right, distance = np.array(good).T
    order = np.argsort(distance, kind="stable")
    _, first = np.unique(left[order], return_index=True)
    kept = order[first]
    return left[kept].astype(int), right[kept].astype(int)


def _mutual(a: NDArray[np.float32], b: NDArray[np.float32]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Positions of histograms that are each other's nearest; on surfaces few are clearly so."""
    pairs = cv2.BFMatcher(cv2.NORM_L2, crossCheck=True).match(b, a)
    return np.array([p.trainIdx for p in pairs], int), np.array([p.queryIdx for p in pairs], int)


def _rigid_triples(points: Array, targets: Array, sigma: Array) -> NDArray[np.bool_]:
    """Samples (s) of three matches (s, 3, 3) whose sides are equally long in both images, and long enough to tell."""
    good = np.ones(len(points), bool)
    for a, b in ((0, 1), (1, 2), (2, 0)):
        here = np.linalg.norm(points[:, a] - points[:, b], axis=1)
        there = np.linalg.norm(targets[:, a] - targets[:, b], axis=1)
        spread = WITHIN * np.hypot(sigma[:, a], sigma[:, b])
        good &= (np.abs(here - there) < spread) & (np.minimum(here, there) > 2 * spread)
    return good


def _rigid(points: Array, targets: Array, weights: Array) -> tuple[Array, Array]:
    """Rotations (s, 3, 3) and shifts (s, 3) that bring points (s, k, 3) onto targets by weighted least squares."""
    w = weights[..., None] / weights.sum(axis=1)[:, None, None]
    here, there = (w * points).sum(axis=1), (w * targets).sum(axis=1)
    C = np.einsum("ski,skj->sij", w * (targets - there[:, None]), points - here[:, None])
    u, _, vt = np.linalg.svd(C)
    u[:, :, 2] *= np.sign(np.linalg.det(u) * np.linalg.det(vt))[:, None]
    R = u @ vt
    return R, there - np.einsum("sij,sj->si", R, here)


def _information(points: Array, sigma: Array) -> tuple[Array, Array]:
    weights = 1 / sigma**2
    centre = (weights[:, None] * points).sum(axis=0) / weights.sum()
    J = moved_by(points - centre)
    return np.einsum("mki,m,mkj->ij", J, weights, J), centre


def moved_by(points: Array) -> Array:
    """(m, 3, 6) what a twist (rotation about the origin, shift) moves points (m, 3) by."""
    x, y, z = points.T
    zero, one = np.zeros_like(x), np.ones_like(x)
    rows = [zero, z, -y, one, zero, zero], [-z, zero, x, zero, one, zero], [y, -x, zero, zero, zero, one]
    return np.moveaxis(np.array(rows), 2, 0)
