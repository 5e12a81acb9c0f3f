"""Camera and poses together by Levenberg's and Marquardt's method (Marquardt 1963), the poses solved for view by view.

OpenCV's `calibrateCamera` adds up what several threads find, in the order in which they come: the same pictures give
other last digits every time. Here they give the same bits.
"""

from collections.abc import Callable

import numpy as np

from fusion.geometry.pose import Array

Linear = Callable[[int, Array, Array], tuple[Array, Array]]  # view, pose, parameters -> (m, k + 6), (m,)
MOST = 100  # steps
SETTLED = 1e-12  # of its size, by which the sum of squares still falls
STIFFEST = 1e12  # damping beyond which no step is any better


def adjusted(
    linear: Linear, parameters: Array, poses: Array, free: Array, weight: Array | None = None
) -> tuple[Array, Array]:
    """Parameters (k,) and poses (views, 6) with the least sum of squares.

    Args:
        linear: derivative and misfit of a view; the first k columns are those of the parameters, then of its pose.
        free: (k,) True for the parameters that may change.
        weight: (k,) of their own squares in the sum; None: 0.
    """
    weight = np.zeros(len(free)) if weight is None else weight
    blocks = [linear(n, pose, parameters) for n, pose in enumerate(poses)]
    total, damping = _squares(blocks) + weight @ parameters**2, 1e-3
    for _ in range(MOST):
        step, steps = _step(blocks, damping, free, weight, parameters)
        tried = [linear(n, pose, parameters + step) for n, pose in enumerate(poses + steps)]
        found = _squares(tried) + weight @ (parameters + step) ** 2
        if found < total:
            settled = total - found < SETTLED * total
            parameters, poses, blocks, total = parameters + step, poses + steps, tried, found
            damping = max(damping / 10, 1e-12)
            if settled:
                break
        else:
            damping *= 10
            if damping > STIFFEST or found - total < SETTLED * total:
                break
    return parameters, poses


def _squares(blocks: list[tuple[Array, Array]]) -> float:
    total = float(sum(r @ r for _, r in blocks))
    return total if np.isfinite(total) else float("inf")


def _step(
    blocks: list[tuple[Array, Array]], damping: float, free: Array, weight: Array, at: Array
) -> tuple[Array, Array]:
    """Change of the parameters (k,) and of the poses (views, 6)."""
    k = len(free)
    N, g = np.diag(weight), weight * at
    solved = []
    for J, r in blocks:
        whole, slope = J.T @ J, J.T @ r
        whole[np.diag_indices_from(whole)] *= 1 + damping
        # of the pose: what it does by itself, and what it does where the parameters change
        V = np.linalg.solve(whole[k:, k:], np.column_stack([slope[k:], whole[k:, :k]]))
        N += whole[:k, :k] - whole[:k, k:] @ V[:, 1:]
        g += slope[:k] - whole[:k, k:] @ V[:, 0]
        solved.append(V)
    step = np.zeros(k)
    unit = 1 / np.sqrt(np.maximum(np.diag(N)[free], 1e-300))  # a pixel and a lens coefficient differ by far
    step[free] = -unit * np.linalg.solve(N[np.ix_(free, free)] * np.outer(unit, unit), unit * g[free])
    return step, np.array([-(V[:, 0] + V[:, 1:] @ step) for V in solved])
