"""Point-to-plane alignment of one point map with another, sigma-weighted and robust, coarse to fine."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.geometry import pose
from fusion.geometry.depth import PointMap
from fusion.tracking.both_sides import shape_seen
from fusion.tracking.equations import Equations, PairLimits, Points, equations, lay_out, thinned

Array = NDArray[np.float64]

FEWEST = 30  # pairs for six unknowns (guess)
# rms error of normals from noisy depth [rad]: what a plane shows of it must not count as relief (guess)
NORMAL_NOISE = 0.03
# of what resists a motion, what both sides must see: a step goes that share of the way, so that six of them come near;
# by chance a plane shows three hundredths
SHAPE = 0.2
SETTLED = 1e-4  # steps below end the last pass [rad], [m]: the next would be a fifth of it, below what a pixel shows
NEAR = 0.02  # steps below this share of its reach end a pass before (guess)


@dataclass(frozen=True)
class IcpSettings:
    """How one frame is aligned."""

    # one pass per value, coarse to fine: about how many points take part, if there are as many
    points: tuple[int, ...] = (2000, 4000, 40000)
    reaches: tuple[float, ...] = (0.20, 0.05, 0.02)  # largest distance of a pair in each pass [m]
    iterations: tuple[int, ...] = (12, 6, 6)  # at most, in each pass
    min_cosine: float = 0.7  # smallest cosine between the normals of a pair
    min_inlier_share: float = 0.4  # below this share of the visible points, the alignment has failed
    max_residual: float = 0.05  # rms point-to-plane distance [m] above which the alignment has failed


@dataclass(frozen=True)
class IcpResult:
    """An alignment and the evidence for it."""

    T_model_source: Array  # (4, 4)
    # (6, 6) inverse covariance of a left twist (rotation about the source points' centroid in the model's camera [rad],
    # then shift [m]); zero along what the surface does not fix
    information: Array
    inlier_share: float  # pairs over points that the model could have met
    residual: float  # robust rms point-to-plane distance [m]
    status: str  # "ok", or a sentence saying why it failed
    unconstrained: tuple[str, ...] = ()  # names of directions that the surface does not fix

    @property
    def ok(self) -> bool:
        """True when the alignment can be used."""
        return self.status == "ok"


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
    return align_points(lay_out(source, settings.points[-1]), model, T_model_source, settings)


def align_points(source: Points, model: PointMap, T_model_source: Array, settings: IcpSettings) -> IcpResult:
    """As `align`, with the source laid out before."""
    T = np.array(T_model_source, float)
    scale = 1.0
    passes = list(zip(settings.points, settings.reaches, settings.iterations, strict=True))
    for n, (points, reach, iterations) in enumerate(passes):
        # where most of the view slides along itself, the few points that would stop it look like outliers at first:
        # all but the last pass take in whatever lies within reach
        open_to = reach if n < len(passes) - 1 else 0.0
        some = thinned(source, points)
        shape = shape_seen(source, T, model, reach, settings.min_cosine)
        for _ in range(iterations):
            sums = equations(some, T, model, PairLimits(reach, settings.min_cosine, scale, open_to))
            if sums.pairs < FEWEST:
                status = f"only {sums.pairs} points met the model"
                return IcpResult(T, sums.information, 0.0, float("inf"), status)
            twist, information = _solve(sums, source.radius, shape)
            T, scale = _moved(T, twist, source.centre), sums.scale
            if np.abs(twist).max() < (NEAR * reach if open_to else SETTLED):
                break
    share, residual = sums.kept / max(sums.visible, 1), float(np.sqrt(sums.squares / max(sums.kept, 1)))
    status = "ok"
    if share < settings.min_inlier_share:
        status = f"only {share:.0%} of the visible points fit the model"
    elif residual > settings.max_residual:
        status = f"residual {residual * 1e3:.1f} mm is above {settings.max_residual * 1e3:.1f} mm"
    return IcpResult(T, information, share, residual, status, _unconstrained(information))


def _moved(T: Array, twist: Array, centre: Array) -> Array:
    """A pose (4, 4) after a twist (6,) about where it brings a point (3,)."""
    about = T[:3, :3] @ centre + T[:3, 3]
    R = np.asarray(cv2.Rodrigues(twist[:3])[0])
    return pose.pose(R @ T[:3, :3], R @ (T[:3, 3] - about) + about + twist[3:])


def _solve(sums: Equations, radius: float, shape: Array | None) -> tuple[Array, Array]:
    """Gauss-Newton step (6,) and information (6, 6): none along what the surface does not fix, where it stays still.

    With turns measured at the points' rms distance from their centroid, an eigenvalue over the sum of weights is the
    mean square cosine at which the surface resists a motion. A plane resists sliding only by the noise of its
    normals, and following that noise would be drift (Zhang, Kaess and Singh 2016 hold such directions too).

    Args:
        sums: of all pairs.
        radius: rms distance of the points from their centroid [m].
        shape: of what both sides show, see `shape_seen`; None where that is not known.
    """
    units = np.array([1 / max(radius, 1e-6)] * 3 + [1.0] * 3)
    values, vectors = np.linalg.eigh(sums.information * np.outer(units, units))
    strong = values > NORMAL_NOISE**2 * max(sums.weight, 1e-300)
    if shape is not None:
        strong &= np.einsum("ik,ij,jk->k", vectors, shape, vectors) > SHAPE * values / max(sums.weight, 1e-300)
    values, axes = values[strong], vectors[:, strong]
    step = -units * (axes @ ((axes.T @ (units * sums.slope)) / values))
    return np.asarray(step), np.asarray((axes * values) @ axes.T / np.outer(units, units))


def _unconstrained(information: Array, angle: float = 0.01, shift: float = 0.005) -> tuple[str, ...]:
    """Axes that lie in directions whose standard deviation exceeds 0.01 rad or 5 mm."""
    units = np.array([angle] * 3 + [shift] * 3)
    values, vectors = np.linalg.eigh(information * np.outer(units, units))
    names = ("rotation x", "rotation y", "rotation z", "shift x", "shift y", "shift z")
    # 0.4: an axis at 45 degrees to a weak direction has half of its square in it
    share = (vectors[:, values < 1.0] ** 2).sum(axis=1)
    return tuple(name for name, part in zip(names, share, strict=True) if part > 0.4)
