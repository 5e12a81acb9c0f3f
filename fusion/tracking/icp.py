"""Point-to-plane alignment of one point map with another, sigma-weighted and robust, coarse to fine."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.geometry import pose
from fusion.geometry.depth import PointMap
from fusion.tracking.association import IN_FRONT, associate

Array = NDArray[np.float64]

FEWEST = 30  # pairs for six unknowns (guess)
# rms error of normals from noisy depth [rad]: what a plane shows of it must not count as relief (guess)
NORMAL_NOISE = 0.03


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

    strides: tuple[int, ...] = (8, 8, 4, 2)
    reaches: tuple[float, ...] = (0.20, 0.10, 0.05, 0.02)
    iterations: tuple[int, ...] = (8, 8, 6, 6)
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
    step = _Step(T, np.zeros((6, 6)), np.zeros((6, 0)), np.full(6, np.inf), 0.0, float("inf"), 0)
    passes = list(zip(settings.strides, settings.reaches, settings.iterations, strict=True))
    for n, (stride, reach, iterations) in enumerate(passes):
        # where most of the view slides along itself, the few points that would stop it look like outliers at first:
        # all but the last pass take in whatever lies within reach
        open_to = reach if n < len(passes) - 1 else 0.0
        sampled = sample(source, stride)
        for _ in range(iterations):
            step = _gauss_newton(find_pairs(sampled, T, model, reach, settings.min_cosine), T, open_to)
            if step.pairs < FEWEST:
                status = f"only {step.pairs} points met the model"
                return IcpResult(T, step.information, 0.0, step.residual, status)
            T = step.T_model_source
            if np.abs(step.twist).max() < 2e-5:  # far below what a pixel shows
                break
    status = "ok"
    if step.inlier_share < settings.min_inlier_share:
        status = f"only {step.inlier_share:.0%} of the visible points fit the model"
    elif step.residual > settings.max_residual:
        status = f"residual {step.residual * 1e3:.1f} mm is above {settings.max_residual * 1e3:.1f} mm"
    unconstrained = _unconstrained(step.information, step.weak)
    return IcpResult(T, step.information, step.inlier_share, step.residual, status, unconstrained)


@dataclass(frozen=True)
class _Step:
    """One Gauss-Newton step: the pose after it, the twist (6,), and how well the pairs fitted before it."""

    T_model_source: Array
    information: Array
    weak: Array
    twist: Array
    inlier_share: float
    residual: float
    pairs: int


def _gauss_newton(pairs: Pairs, T: Array, open_to: float) -> _Step:
    if len(pairs.index) < FEWEST:
        return _Step(T, np.zeros((6, 6)), np.zeros((6, 0)), np.zeros(6), 0.0, float("inf"), len(pairs.index))
    spread = robust_scale(pairs.residual, pairs.sigma) * pairs.sigma
    weight = tukey(pairs.residual / np.maximum(spread, open_to / 4.685)) / spread**2
    centre = pairs.moved.mean(axis=0)
    arm = pairs.moved - centre
    J = np.hstack([np.cross(arm, pairs.normals), pairs.normals])
    twist, weak = _solve(J, (weight, pairs.residual), float(np.sqrt((arm**2).sum(axis=1).mean())))
    shift = pose.pose(np.eye(3), centre)
    kept = weight > 0
    return _Step(
        T_model_source=shift @ pose.exp(twist) @ pose.inverse(shift) @ T,
        information=(J * weight[:, None]).T @ J,
        weak=weak,
        twist=twist,
        inlier_share=float(kept.sum() / max(pairs.visible, 1)),
        residual=float(np.sqrt(np.mean(pairs.residual[kept] ** 2))),
        pairs=len(pairs.index),
    )


def _solve(J: Array, weighted: tuple[Array, Array], radius: float) -> tuple[Array, Array]:
    """Gauss-Newton step (6,), and the motions (6, k) that the surface does not fix, in which it stays still.

    With turns measured at the points' rms distance from their centroid, an eigenvalue over the sum of weights is the
    mean square cosine at which the surface resists a motion. A plane resists sliding only by the noise of its
    normals, and following that noise would be drift (Zhang, Kaess and Singh 2016 hold such directions too).

    Args:
        J: (n, 6) derivatives of the residuals.
        weighted: weights (n,) and residuals (n,).
        radius: rms distance of the points from their centroid [m].
    """
    weight, residual = weighted
    units = np.array([1 / max(radius, 1e-6)] * 3 + [1.0] * 3)
    scaled = J * units
    values, vectors = np.linalg.eigh((scaled * weight[:, None]).T @ scaled)
    strong = values > NORMAL_NOISE**2 * max(float(weight.sum()), 1e-300)
    slope = vectors.T @ (scaled.T @ (weight * residual))
    step = -units * (vectors[:, strong] @ (slope[strong] / values[strong]))
    return np.asarray(step), vectors[:, ~strong]


def _unconstrained(information: Array, weak: Array, angle: float = 0.01, shift: float = 0.005) -> tuple[str, ...]:
    """Axes that lie in weak directions, or in those whose standard deviation exceeds 0.01 rad or 5 mm."""
    units = np.array([angle] * 3 + [shift] * 3)
    values, vectors = np.linalg.eigh(information * np.outer(units, units))
    names = ("rotation x", "rotation y", "rotation z", "shift x", "shift y", "shift z")
    # 0.4: an axis at 45 degrees to a weak direction has half of its square in it
    share = np.maximum((weak**2).sum(axis=1), (vectors[:, values < 1.0] ** 2).sum(axis=1))
    return tuple(name for name, part in zip(names, share, strict=True) if part > 0.4)
