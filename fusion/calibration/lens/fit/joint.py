"""Camera, poses and the board's shape together."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fusion.calibration.lens.fit.adjust import adjusted
from fusion.calibration.lens.fit.shape import BoardShape
from fusion.calibration.lens.fit.solve import LensSolution, residual
from fusion.calibration.lens.fit.spread import spread
from fusion.calibration.lens.views import BoardView
from fusion.errors import RecordingError
from fusion.geometry.pose import Array

TOLERATED, SIGNIFICANT = 0.015, 6.0  # share, and standard deviations: beyond both the board is refused
# how far boards are off, one standard deviation (guesses): rows 1.5 % wider, a bow of 1 % of the longer side
USUAL = np.array([0.015, 0.02, 0.02, 0.02])
ROUNDS = 2  # the noise, by which a usual board is weighed, is that of the round before


def board_shape(views: Sequence[BoardView], solution: LensSolution) -> tuple[BoardShape, LensSolution]:
    """The board's shape as the views tell it, and the camera that goes with it.

    Args:
        views: of a flat grid.
        solution: of these views.
    """
    points = np.concatenate([view.points[:, :2] for view in views])
    low, high = points.min(axis=0), points.max(axis=0)
    half = float((high - low).max()) / 2
    sides = (high - low) / 2 / half
    shape = BoardShape(
        (low + high) / 2, half, (float(sides[0]), float(sides[1])), np.zeros(4), np.zeros(4), np.zeros((4, 4))
    )
    k = len(solution.parameters)

    def linear(n: int, pose: Array, values: Array) -> tuple[Array, Array]:
        tried = replace(shape, terms=values[k:])
        return tried.jacobian(tried.on(views[n]), pose, values[:k])

    for _ in range(ROUNDS):
        free = max(2 * len(points) - k - len(USUAL) - 6 * len(views), 1)
        variance = sum(float((r**2).sum()) for r in solution.residuals) / free
        shape = replace(shape, weight=variance / USUAL**2)
        values, poses = adjusted(
            linear,
            np.concatenate([solution.parameters, shape.terms]),
            solution.poses,
            np.ones(k + len(USUAL), bool),
            np.concatenate([np.zeros(k), shape.weight]),
        )
        shape = replace(shape, terms=values[k:])
        left = [residual(shape.on(view), pose, values[:k]) for view, pose in zip(views, poses, strict=True)]
        solution = LensSolution(values[:k], poses, left)
    fitted = [shape.on(view) for view in views]
    return replace(shape, covariance=spread(fitted, solution, shape).board), solution


def check_pitch(ratio: float, std: float, where: object = "board.json") -> None:
    """Refuse a board whose rows and columns are not alike. Raises RecordingError."""
    if abs(ratio - 1) > max(TOLERATED, SIGNIFICANT * std):
        found = f"rows {ratio:.4f} times as far apart as columns (+- {std:.4f})"
        do = "measure both with a ruler; print without 'fit to page', or use another board"
        raise RecordingError("the board's squares are not square", where, found, "the same pitch both ways", do)
