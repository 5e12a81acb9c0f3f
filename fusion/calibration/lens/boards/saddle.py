"""A corner as what it is: two straight edges that cross, blurred, under light that changes slowly.

All pixels around the corner are fitted, not only the gradients. Measured against OpenCV's cornerSubPix: on simulated
boards with known truth the focal length's error fell from 0.17 % to 0.01 %, on a real Kinect v2 the reprojection error
to half.
"""

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.special import erf

from fusion.geometry.pose import Array

REACH = 0.7  # of a square to each side: the next corner's edges stay outside, blur included
MOST_PIXELS, FEWEST_PIXELS = 1200, 16
ROUNDS = 12
BLUR_PX = (0.3, 3.0)
ASTRAY = 0.02  # of a square, and 0.4 px: a corner that moves further was disturbed by something else
MISFIT, WORSE = 0.2, 3.0  # of the contrast, or times that of the other corners: no plain corner


def saddles(grey: NDArray, pixels: Array, plane: Array, reach: float = REACH) -> Array:
    """Corners (n, 2) [px] moved to the crossing of their edges; those that cannot be fitted stay where they are.

    Args:
        grey: (height, width) grey values.
        pixels: (n, 2) start [px].
        plane: (n, 2) the same corners on the board, in squares.
        reach: how far around a corner pixels are used, in squares.
    """
    H, _ = cv2.findHomography(plane, pixels)
    if H is None:
        return pixels
    fits = [_crossing(grey, pixel, _edges(H, at), reach) for pixel, at in zip(pixels, plane, strict=True)]
    misfit = np.array([fit[2] for fit in fits])
    # speckle and little light are alike for all corners, a glare or a finger is not
    usable = misfit <= max(MISFIT, WORSE * float(np.median(misfit)))
    return np.where(usable[:, None], [fit[:2] for fit in fits], pixels)


def _edges(H: NDArray, at: Array) -> Array:
    """(2, 2) pixels per square along both edges through a corner of the board."""
    x, y, w = H @ [*at, 1.0]
    return (H[:2, :2] - np.outer([x / w, y / w], H[2, :2])) / w


def _crossing(grey: NDArray, start: Array, edges: Array, reach: float) -> tuple[float, float, float]:
    """Where the edges cross [px], by Gauss-Newton in place and blur; contrast and light are solved for.

    Returns:
        u, v and the misfit: rms of what is left over the contrast, infinite where nothing could be fitted.
    """
    nothing = (float(start[0]), float(start[1]), float("inf"))
    if not np.isfinite(edges).all() or abs(np.linalg.det(edges)) < 1.0:
        return nothing
    to_board = np.linalg.inv(edges)
    across = 1 / np.linalg.norm(to_board, axis=1)  # pixels from an edge, per square
    at, values = _around(grey, start, edges, reach)
    if len(values) < FEWEST_PIXELS:
        return nothing
    corner, blur = start.copy(), 0.8
    for _ in range(ROUNDS):
        away = at - corner
        distance = away @ to_board.T * across
        side = erf(distance / (blur * np.sqrt(2)))
        slope = np.exp(-0.5 * (distance / blur) ** 2) * np.sqrt(2 / np.pi) / blur
        checker = side[:, 0] * side[:, 1]
        light = np.column_stack([np.ones(len(values)), checker, away, away * checker[:, None]])
        amounts = _least_squares(light, values)
        left = values - light @ amounts
        steep = slope * side[:, ::-1] * amounts[1]
        design = np.column_stack([light, -(steep * across) @ to_board, -(steep * distance).sum(axis=1) / blur])
        step = _least_squares(design, left)[-3:]
        corner = corner + np.clip(step[:2], -1, 1)
        blur = float(np.clip(blur + np.clip(step[2], -0.2, 0.2), *BLUR_PX))
        if np.abs(step[:2]).max() < 1e-4:
            break
    if not np.linalg.norm(corner - start) < ASTRAY * float(np.min(across)) + 0.4:
        return nothing
    return float(corner[0]), float(corner[1]), float(np.sqrt((left**2).mean()) / max(abs(amounts[1]), 1e-12))


def _least_squares(design: Array, values: Array) -> Array:
    """(k,) amounts of the columns (n, k); by normal equations: tens of thousands of these are solved."""
    normal = design.T @ design
    normal[np.diag_indices_from(normal)] *= 1 + 1e-9  # a corner without contrast leaves a column open
    normal[np.diag_indices_from(normal)] += 1e-12
    return np.asarray(np.linalg.solve(normal, design.T @ values), float)


def _around(grey: NDArray, start: Array, edges: Array, reach: float) -> tuple[Array, Array]:
    """(n, 2) pixels within `reach` squares of a corner, and their values (n,); fewer squares where these are large."""
    reach = min(reach, 0.5 * float(np.sqrt(MOST_PIXELS / abs(np.linalg.det(edges)))))
    far = np.ceil(np.abs(edges).sum(axis=1) * reach).astype(int)
    low = np.maximum(np.round(start).astype(int) - far, 0)
    high = np.minimum(np.round(start).astype(int) + far + 1, grey.shape[::-1])
    v, u = np.mgrid[low[1] : high[1], low[0] : high[0]]
    at = np.stack([u.ravel(), v.ravel()], axis=1).astype(float)
    near = (np.abs((at - start) @ np.linalg.inv(edges).T) < reach).all(axis=1)
    at = at[near]
    return at, grey[at[:, 1].astype(int), at[:, 0].astype(int)].astype(float)
