"""Whether a board's rows are as far apart as its columns: uneven print spoils the focal length unseen."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fusion.calibration.lens.fit.solve import jacobian, residual, solve
from fusion.calibration.lens.fit.spread import eliminated
from fusion.calibration.lens.views import BoardView
from fusion.errors import RecordingError
from fusion.geometry.pose import Array

STEP = 1e-4
TOLERATED, SIGNIFICANT = 0.015, 6.0  # share, and standard deviations: beyond both the board is refused
ROUNDS = 5


def row_pitch(views: Sequence[BoardView], size: tuple[int, int], begin: Array | None = None) -> tuple[float, float]:
    """(ratio, std): distance of the rows over that of the columns as the views themselves tell it.

    Seen flat from the front it hides behind the focal lengths; boards tilted and turned in the picture show it. The
    standard deviation says which is the case.

    Args:
        begin: parameters of the camera to start from; they say which form its lens has.

    Raises:
        RecordingError: no camera explains the views.
    """
    ratio, start, std = 1.0, begin, float("inf")
    for _ in range(ROUNDS):
        stretched = [replace(view, points=view.points * [1, ratio, 1]) for view in views]
        solution = solve(stretched, size, start)
        start = solution.parameters
        blocks = [_block(v, p, start) for v, p in zip(stretched, solution.poses, strict=True)]
        H, g = sum(block[0] for block in blocks), sum(block[1] for block in blocks)
        unit = 1 / np.sqrt(np.maximum(np.diag(H), 1e-300))
        if np.linalg.cond(H * np.outer(unit, unit)) > 1e12:
            return 1.0, float("inf")
        inverse = np.linalg.inv(H * np.outer(unit, unit)) * np.outer(unit, unit)
        free = max(2 * sum(map(len, views)) - len(start) - 1 - 6 * len(views), 1)
        squares = sum(float((r**2).sum()) for r in solution.residuals)
        std = float(np.sqrt(squares / free * inverse[-1, -1])) * ratio
        change = float(-(inverse @ g)[-1])
        if not abs(change) < 0.5:
            return 1.0, float("inf")
        ratio *= 1 + change
        if abs(change) < 0.1 * std + 1e-5:
            break
    return ratio, std


def check_pitch(ratio: float, std: float, where: object = "board.json") -> None:
    """Refuse a board whose rows and columns are not alike. Raises RecordingError."""
    if abs(ratio - 1) > max(TOLERATED, SIGNIFICANT * std):
        found = f"rows {ratio:.4f} times as far apart as columns (+- {std:.4f})"
        do = "measure both with a ruler; print without 'fit to page', or use another board"
        raise RecordingError("the board's squares are not square", where, found, "the same pitch both ways", do)


def _block(view: BoardView, pose: Array, parameters: Array) -> tuple[Array, Array]:
    """Information and gradient of a view about (the parameters, relative change of the rows' pitch)."""
    J, r = jacobian(view, pose, parameters)
    more = replace(view, points=view.points * [1, 1 + STEP, 1])
    column = (residual(view, pose, parameters) - residual(more, pose, parameters)).reshape(-1, 1) / STEP
    k = len(parameters)
    return eliminated(np.hstack([J[:, :k], column, J[:, k:]]), r, k + 1)
