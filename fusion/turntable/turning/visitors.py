"""Hands, arms and people: what moves and reaches out of the picture is no object on a table.

An arm belongs to somebody who stands beside the table, so it leads to the border of the image. Where it touches the
object, both hang together and the frame says nothing of how far the object reaches; the other frames do.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

Mask = NDArray[np.bool_]
MARGIN = 0.01  # of the image beside its border, where a camera measures badly (guess)
APART = 0.05  # [m] from a pixel to the next: another thing, which may pass behind (guess)
GAP = 7  # [px] in what hangs together: where it crosses the depth of what was seen at another time it seems to stand
WIDE = 0.8  # share of the image that a camera measures in at least, beside what is too far (guess)
FEW = 50  # pixels of a frame: noise and edges (guess)
ENOUGH = 0.25  # share of the frames that must show something else, or it is the object that is larger than the image
FAR = 2.2  # times what a quarter of the frames do not reach: a thing that turns is not that much longer one way (guess)


def without_visitors(moving: Mask, depths: NDArray[np.float32]) -> Mask:
    """Moving pixels (k, h, w) without those that hang together with the border of the image, where others are left.

    Args:
        moving: (k, h, w) what moves in each frame.
        depths: (k, h, w) [m], NaN where missing.
    """
    rows, columns = _measured(np.isfinite(depths).mean(axis=0))
    alone = np.stack([_within(m, d, (rows, columns)) for m, d in zip(moving, depths, strict=True)])
    shown, left = moving.sum(axis=(1, 2)), alone.sum(axis=(1, 2))
    clear = left > FEW
    clear &= left > FEW + 0.25 * np.median(left[clear]) if clear.any() else False
    if clear.sum() < max(2, ENOUGH * (shown > 0).sum()):
        return moving
    return alone & clear[:, None, None]


def undisturbed(points: NDArray[np.float64], frames: NDArray[np.int64]) -> Mask:
    """(n,) bool: points of the frames in which nothing reaches far out of where most frames see the object.

    Args:
        points, frames: (n, 3) [m], (n,) of what moves and hangs together.
    """
    seen = np.unique(frames)
    of = [points[frames == i] for i in seen]
    centre = np.median([np.median(p, axis=0) for p in of], axis=0)
    reach = np.array([np.percentile(np.linalg.norm(p - centre, axis=1), 98) for p in of])
    calm = reach < FAR * np.percentile(reach, 25)
    return np.asarray(np.isin(frames, seen[calm]))


def _measured(known: NDArray[np.float64]) -> tuple[slice, slice]:
    """Rows and columns in which the camera measures at all, without their border; `known`: share of frames (h, w)."""
    often = known > 0.2
    found = []
    for axis in (1, 0):
        at = np.flatnonzero(often.any(axis=axis))
        size = known.shape[1 - axis]
        # a band at the border that never measures belongs to the camera; a wider one, to an empty background
        whole = len(at) > 0 and at[-1] - at[0] > WIDE * size
        first, last = (int(at[0]), int(at[-1])) if whole else (0, size - 1)
        margin = 2 + int(MARGIN * (last - first))
        found.append(slice(first + margin, last + 1 - margin))
    return found[0], found[1]


def _within(moving: Mask, depth: NDArray[np.float32], inner: tuple[slice, slice]) -> Mask:
    """Moving pixels (h, w) of the pieces that lie within the picture."""
    edge = np.zeros(moving.shape, bool)
    with np.errstate(invalid="ignore"):
        edge[:, 1:] |= np.abs(np.diff(depth, axis=1)) > APART
        edge[1:] |= np.abs(np.diff(depth, axis=0)) > APART
    whole = cv2.morphologyEx(moving.astype(np.uint8), cv2.MORPH_CLOSE, np.ones((GAP, GAP), np.uint8))
    count, labels = cv2.connectedComponents(whole & ~edge, connectivity=4)
    outside = np.ones(moving.shape, bool)
    outside[inner] = False
    reaching = np.zeros(count, bool)
    reaching[np.unique(labels[outside])] = True
    reaching[0] = False  # edges, which belong to what they bound
    visitor = reaching[labels]
    beside = cv2.dilate(visitor.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
    return moving & ~visitor & ~(beside & (labels == 0))
