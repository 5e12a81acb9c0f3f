"""How well the camera is known: covariance, and what becomes of it when a view is left out.

Every view is reduced to what it says about the camera, with its own pose eliminated (Schur complement). Their sum gives
the covariance, and the difference to the sum gives the camera without that view, without solving again.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fusion.calibration.lens.fit.shape import BoardShape
from fusion.calibration.lens.fit.solve import LensSolution, jacobian
from fusion.calibration.lens.views import BoardView
from fusion.errors import RecordingError
from fusion.geometry.pose import Array


@dataclass(frozen=True)
class LensSpread:
    """How well the parameters are known."""

    # (k, k) in the order of the solution's names: from the corners' scatter, or wider where the views disagree, see
    # `spread`
    covariance: Array
    scatter: Array  # (k,) standard deviations if the corners' errors were independent
    jackknife: Array  # (k,) standard deviations from leaving out one view at a time
    shifts: Array  # (views, k) parameters without each view minus those with all
    influence: Array  # (views,) Cook's distance: shift squared in units of the covariance, over k
    sigma_px: float  # scatter of one coordinate of a corner
    board: Array  # (4, 4) covariance of the board's shape; (0, 0) where its shape was held

    @property
    def std(self) -> Array:
        """(k,) standard deviations."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def correlation(self) -> Array:
        """(k, k) correlations."""
        std = self.std
        return self.covariance / np.outer(std, std)


def spread(views: Sequence[BoardView], solution: LensSolution, shape: BoardShape | None = None) -> LensSpread:
    """How well a solution is known.

    The corners of one view share errors (a bent board, blur), so the scatter alone promises too much; the jackknife
    sees that, but is itself uncertain. The covariance is that of the scatter, widened as a whole by as much as the
    jackknife is wider on average.

    Args:
        views: of the board as it is.
        shape: of the board, where it was fitted with the camera and is as uncertain; None: it was known.

    Raises:
        RecordingError: the views leave a parameter open.
    """
    k, own = len(solution.parameters), np.zeros(0) if shape is None else shape.weight
    blocks = [reduced(view, pose, solution.parameters, shape) for view, pose in zip(views, solution.poses, strict=True)]
    S, s = np.array([block[0] for block in blocks]), np.array([block[1] for block in blocks])
    total = S.sum(axis=0) + np.diag(np.concatenate([np.zeros(k), own]))
    unit = 1 / np.sqrt(np.maximum(np.diagonal(total), 1e-300))
    if not np.isfinite(total).all() or np.linalg.cond(total * np.outer(unit, unit)) > 1e12:
        do = "record views with the board tilted in several directions and near the edges"
        raise RecordingError("the views leave the camera open", found=f"{len(views)} views", do=do)
    inverse = np.linalg.inv(total * np.outer(unit, unit)) * np.outer(unit, unit)
    free = 2 * sum(map(len, views)) - len(total) - 6 * len(views)
    squares = sum(float((r**2).sum()) for r in solution.residuals)
    sigma2 = squares / max(free, 1)
    shifts = np.array([_without(total, S[i], s[i], unit)[:k] for i in range(len(views))])
    n = len(views)
    jackknife = np.sqrt((n - 1) / n * ((shifts - shifts.mean(axis=0)) ** 2).sum(axis=0))
    scatter = np.sqrt(sigma2 * np.diag(inverse)[:k])
    wider = float(np.clip(np.sqrt(np.mean((jackknife / scatter) ** 2)), 1, 10))
    covariance = sigma2 * inverse * wider**2
    known = total[:k, :k] - total[:k, k:] @ np.linalg.solve(total[k:, k:], total[k:, :k])
    influence = np.einsum("vi,ij,vj->v", shifts, known / sigma2 if sigma2 else known, shifts) / k
    return LensSpread(
        covariance[:k, :k], scatter, jackknife, shifts, influence, float(np.sqrt(sigma2)), covariance[k:, k:]
    )


def reduced(view: BoardView, pose: Array, parameters: Array, shape: BoardShape | None) -> tuple[Array, Array]:
    """Information and gradient of a view about the camera and, if given, the board's shape, without its own pose."""
    J, r = (jacobian if shape is None else shape.jacobian)(view, pose, parameters)
    return eliminated(J, r, J.shape[1] - 6)


def eliminated(J: Array, r: Array, kept: int) -> tuple[Array, Array]:
    """Normal matrix and gradient of the first `kept` columns of J (m, kept + others), the others solved for."""
    scale = 1 / np.maximum(np.linalg.norm(J, axis=0), 1e-300)
    Q, _ = np.linalg.qr(J[:, kept:] * scale[kept:])
    J_free = J[:, :kept] - Q @ (Q.T @ J[:, :kept])
    return J_free.T @ J_free, J_free.T @ (r - Q @ (Q.T @ r))


def _without(total: Array, S: Array, s: Array, unit: Array) -> Array:
    """(k,) change of the parameters without one view's information and gradient; NaN where that leaves a gap."""
    rest = (total - S) * np.outer(unit, unit)
    if np.linalg.cond(rest) > 1e12:
        return np.full(len(s), np.nan)
    return np.linalg.solve(rest, s * unit) * unit
