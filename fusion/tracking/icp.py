"""Point-to-plane alignment of one point map with another, sigma-weighted and robust, coarse to fine."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.geometry import pose
from fusion.geometry.depth import PointMap
from fusion.tracking.association import IN_FRONT, associate

Array = NDArray[np.float64]


@dataclass(frozen=True)
class IcpSettings:
    """How one frame is aligned.

    Attributes:
        strides: one pass per value, coarse to fine: every n-th pixel in both directions.
        reaches: largest distance of a pair in each pass [m].
        iterations: at most, in each pass.
        min_cosine: smallest cosine between the normals of a pair.
        min_inlier_share: below this share of the visible points, the alignment has failed.
        max_residual: rms point-to-plane distance [m] above which the alignment has failed.
    """

    strides: tuple[int, ...] = (8, 4, 2)
    reaches: tuple[float, ...] = (0.10, 0.05, 0.02)
    iterations: tuple[int, ...] = (12, 8, 6)
    min_cosine: float = 0.7
    min_inlier_share: float = 0.4
    max_residual: float = 0.05


@dataclass(frozen=True)
class IcpResult:
    """An alignment and the evidence for it.

    Attributes:
        T_model_source: (4, 4).
        information: (6, 6) inverse covariance of a left twist (rotation about the source points' centroid
            in the model's camera [rad], then shift [m]).
        inlier_share: pairs over points that the model could have met.
        residual: robust rms point-to-plane distance [m].
        status: "ok", or a sentence saying why it failed.
        unconstrained: names of directions that the surface does not fix.
    """

    T_model_source: Array
    information: Array
    inlier_share: float
    residual: float
    status: str
    unconstrained: tuple[str, ...] = ()

    @property
    def ok(self) -> bool:
        """True when the alignment can be used."""
        return self.status == "ok"


@dataclass(frozen=True)
class Pairs:
    """Point-to-plane pairs: r = n . (moved - q), and how the association went.

    Attributes:
        index: (m,) positions in the source arrays.
        moved, normals: (m, 3) in the model's camera.
        pixel: (m,) flat model pixel.
        residual: (m,) [m].
        sigma: (m,) standard deviation of the residual [m].
        visible: number of source points that the model could have met.
        violating: number of source points where the model's camera looked through them.
    """

    index: NDArray[np.int64]
    moved: Array
    normals: Array
    pixel: NDArray[np.int32]
    residual: Array
    sigma: Array
    visible: int
    violating: int


def sample(source: PointMap, stride: int) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]]:
    """Points (n, 3), normals (n, 3) and sigma (n,) of every stride-th pixel that has all three."""
    offset = stride // 2
    points = source.points[offset::stride, offset::stride].reshape(-1, 3)
    normals = source.normals[offset::stride, offset::stride].reshape(-1, 3)
    sigma = source.sigma[offset::stride, offset::stride].ravel()
    known = np.isfinite(normals[:, 0]) & np.isfinite(points[:, 2]) & np.isfinite(sigma)
    return points[known], normals[known], sigma[known]


def find_pairs(
    sampled: tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]],
    T_model_source: Array,
    model: PointMap,
    reach: float,
    min_cosine: float = 0.7,
) -> Pairs:
    """Pair sampled points (see `sample`) with the model at a pose."""
    points, normals, sigma = sampled
    pixel, moved = associate(points, normals, T_model_source, model, reach, min_cosine)
    index = np.flatnonzero(pixel >= 0)
    chosen = pixel[index]
    n = model.normals.reshape(-1, 3)[chosen].astype(float)
    q = model.points.reshape(-1, 3)[chosen].astype(float)
    p = moved[index].astype(float)
    model_sigma = model.sigma.reshape(-1)[chosen]
    # depth noise acts along the line of sight: seen along the normal it shrinks by the cosine
    cosine = np.abs(np.einsum("ij,ij->i", n, q)) / np.linalg.norm(q, axis=1)
    spread = cosine * np.sqrt(sigma[index].astype(float) ** 2 + np.nan_to_num(model_sigma.astype(float)) ** 2)
    residual = np.einsum("ij,ij->i", n, p - q)
    violating = int((pixel == IN_FRONT).sum())
    visible = len(index) + int((pixel <= IN_FRONT).sum())
    return Pairs(index, p, n, chosen, residual, np.maximum(spread, 1e-5), visible, violating)


def tukey(standardised: Array, cut: float = 4.685) -> Array:
    """Tukey's biweight of residuals in units of their scale (Holland and Welsch 1977): 0 beyond the cut."""
    inside = np.clip(1 - (standardised / cut) ** 2, 0, None)
    return inside**2


def robust_scale(residual: Array, sigma: Array) -> float:
    """Ratio of the observed spread to the declared one, from the median; at least 1."""
    if len(residual) == 0:
        return 1.0
    return max(1.0, 1.4826 * float(np.median(np.abs(residual) / sigma)))


def align(source: PointMap, model: PointMap, T_model_source: Array, settings: IcpSettings | None = None) -> IcpResult:
    """Align a point map with a model seen from nearby (Chen and Medioni 1992; Newcombe et al. 2011).

    Args:
        source: the frame to be placed.
        model: what is known of the surface, in the model's camera.
        T_model_source: first guess (4, 4).
        settings: passes and limits.

    Returns:
        The result; a failure is told in its status, never raised.
    """
    settings = settings or IcpSettings()
    T = np.array(T_model_source, float)
    information = np.zeros((6, 6))
    share, rms, scale = 0.0, float("inf"), 1.0
    for stride, reach, iterations in zip(settings.strides, settings.reaches, settings.iterations, strict=True):
        sampled = sample(source, stride)
        for _ in range(iterations):
            pairs = find_pairs(sampled, T, model, reach, settings.min_cosine)
            if len(pairs.index) < 30:
                return IcpResult(T, information, 0.0, rms, f"only {len(pairs.index)} points met the model")
            scale = robust_scale(pairs.residual, pairs.sigma)
            weight = tukey(pairs.residual / (scale * pairs.sigma)) / (scale * pairs.sigma) ** 2
            centre = pairs.moved.mean(axis=0)
            J = np.hstack([np.cross(pairs.moved - centre, pairs.normals), pairs.normals])
            information = (J * weight[:, None]).T @ J
            step = np.linalg.lstsq(_damped(information), -J.T @ (weight * pairs.residual), rcond=None)[0]
            shift = pose.pose(np.eye(3), centre)
            T = shift @ pose.exp(step) @ pose.inverse(shift) @ T
            if np.abs(step[:3]).max() < 2e-5 and np.abs(step[3:]).max() < 2e-5:
                break
        kept = np.abs(pairs.residual) < 4.685 * scale * pairs.sigma
        share = kept.sum() / max(pairs.visible, 1)
        rms = float(np.sqrt(np.mean(pairs.residual[kept] ** 2)))
    status = "ok"
    if share < settings.min_inlier_share:
        status = f"only {share:.0%} of the visible points fit the model"
    elif rms > settings.max_residual:
        status = f"residual {rms * 1e3:.1f} mm is above {settings.max_residual * 1e3:.1f} mm"
    return IcpResult(T, information, float(share), rms, status, _unconstrained(information))


def _damped(information: Array) -> Array:
    """A trace of damping keeps a plane or a cylinder from running away along itself."""
    return information + np.diag(np.maximum(np.diag(information) * 1e-6, 1e-9))


def _unconstrained(information: Array, angle: float = 0.01, shift: float = 0.005) -> tuple[str, ...]:
    """Directions whose standard deviation exceeds 0.01 rad or 5 mm."""
    units = np.array([angle] * 3 + [shift] * 3)
    values, vectors = np.linalg.eigh(information * np.outer(units, units))
    names = ("rotation x", "rotation y", "rotation z", "shift x", "shift y", "shift z")
    weak = vectors[:, values < 1.0]
    return tuple(sorted({names[int(np.abs(column).argmax())] for column in weak.T}))
