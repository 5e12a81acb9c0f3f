"""Where only print tells that something turns: a ball near the axis shows the same depth all the time, and other print.

What moves by depth there are its rims. From these the surface is followed over all pixels whose print changes, as the
background is followed from what stands still; it ends where the ball does, while a wall with a shadow goes on.
"""

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Camera
from fusion.turntable.tones import contrast
from fusion.turntable.turning.background import CELL, followed

Mask = NDArray[np.bool_]
Image = NDArray[np.float32]
FEWEST = 4  # frames that tell how much a pixel changes
CHANGED = 0.08  # spread of a pixel's contrast over the frames: noise makes 0.02 of it, print 0.2 to 0.4 (guess)
FIELD = 15  # [px] of print that may have one colour: over which half of the pixels must change (guess)

NOISES = 2.5  # limits of what stands still are 5 standard deviations: of a plane, 2 are
REFITS = 5  # of a plane, to what lies in it


def print_moves(
    depths: Image, colors: Sequence[NDArray[np.uint8] | None], usual: tuple[Image, Image], outline: Mask
) -> Mask:
    """(h, w) pixels of what moves whose depth stands still, and whose print does not.

    Args:
        depths: (k, h, w) [m], NaN where missing.
        colors: k images (h, w, 3) of the same pixels, None where there is none.
        usual: (h, w), (h, w) depth of what stands there, and difference up to which it is the same [m].
        outline: (h, w) of what moves by depth, see `outline_of`.
    """
    found = np.zeros(outline.shape, bool)
    part = _around(outline)
    shown = [(d[part], c[part]) for d, c in zip(depths, colors, strict=True) if c is not None]
    if len(shown) < FEWEST or not outline.any():
        return found
    far, limit = usual[0][part], usual[1][part]
    changing = _changing(shown, far, limit)
    step, start = CELL, CELL // 2
    # in cells, as the background is
    cells = np.where(changing, far, np.float32(np.nan))[start::step, start::step]
    sure = (changing & outline[part])[start::step, start::step]
    nearness = np.where(sure, 1 / cells, 0).astype(np.float32)
    _, whole = followed(nearness, sure, cells, limit[start::step, start::step])
    wide = cv2.resize(whole.astype(np.uint8), far.shape[::-1], interpolation=cv2.INTER_NEAREST) > 0
    found[part] = _within(_to_rims(wide & changing, far, limit))
    return found


def outline_of(points: NDArray[np.float64], camera: Camera) -> Mask:
    """(h, w) convex outline in the image of points (n, 3) [m]."""
    outline = np.zeros(camera.shape, np.uint8)
    if len(points):
        hull = cv2.convexHull(camera.project(points).astype(np.float32))
        cv2.fillConvexPoly(outline, np.rint(hull).astype(np.int32), 1)
    return outline > 0


def bent_beyond(moves: Mask, usual: tuple[Image, Image], outline: Mask, reach: tuple[float, float]) -> Mask:
    """(h, w) pixels that move by print beyond an outline, as far away as what is in it, and off the plane most lie in.

    A ball rises over the plate that carries it. The plate's own print moves too, but is flat; a wall behind, over which
    a shadow moves, is farther away.

    Args:
        moves: (h, w), see `print_moves`.
        usual, outline: as there.
        reach: least and greatest depth [m] of what moves.
    """
    far, limit = usual
    with np.errstate(invalid="ignore"):
        v, u = np.nonzero(moves & ~outline & (far > reach[0]) & (far < reach[1]))
    # a plane is linear in 1 / z over the pixels; an error of z is one of z^2 times as much in 1 / z
    z, near = far[v, u].astype(float), limit[v, u] / NOISES
    rows, flat = np.column_stack([u, v, np.ones(len(u))]), np.ones(len(u), bool)
    for _ in range(REFITS):
        if flat.sum() < 3:
            break
        weight = z[flat] ** 2
        plane = np.linalg.lstsq(rows[flat] * weight[:, None], z[flat], rcond=None)[0]
        flat = np.abs(z**2 * (rows @ plane) - z) < near
    bent = np.zeros_like(moves)
    bent[v[~flat], u[~flat]] = True
    return bent


def _to_rims(found: Mask, far: Image, limit: Image) -> Mask:
    """What was found (h, w) and what of the same surface lies within a field of print: rims show little of it."""
    square = np.ones((3, 3), np.uint8)
    found = found.copy()
    for _ in range(FIELD):
        reached = cv2.dilate(np.where(found, far, np.float32(0)), square)
        with np.errstate(invalid="ignore"):
            found |= (reached > 0) & (far < reached + limit)
    return found


def _within(found: Mask) -> Mask:
    """Without the pieces that reach the border: what wanders over so much is a shadow on what stands behind."""
    _, labels = cv2.connectedComponents(found.astype(np.uint8), connectivity=4)
    border = np.concatenate([labels[0], labels[-1], labels[:, 0], labels[:, -1]])
    return found & ~np.isin(labels, border)


def _around(outline: Mask) -> tuple[slice, slice]:
    """Rows and columns of an outline and as much again on each side: what shows a part of it is no wider."""
    spans = []
    for axis, size in ((1, outline.shape[0]), (0, outline.shape[1])):
        at = np.flatnonzero(outline.any(axis=axis))
        first, last = (int(at[0]), int(at[-1]) + 1) if len(at) else (0, 0)
        spans.append(slice(max(0, 2 * first - last), min(size, 2 * last - first)))
    return spans[0], spans[1]


def _changing(shown: list[tuple[Image, NDArray[np.uint8]]], far: Image, limit: Image) -> Mask:
    """(h, w) where the print of frames (depth, colour) changes; only what stands at its usual depth is compared."""
    with np.errstate(invalid="ignore"):
        tones = np.stack([contrast(color, np.abs(depth - far) < limit) for depth, color in shown])
    known = np.isfinite(tones)
    count, filled = known.sum(axis=0), np.where(known, tones, np.float32(0))
    n = np.maximum(count, 1)
    variance = (filled**2).sum(axis=0) / n - (filled.sum(axis=0) / n) ** 2
    asked = (count >= FEWEST).astype(np.float32)
    changed = asked * (variance > CHANGED**2)
    around = [cv2.blur(image.astype(np.float32), (FIELD, FIELD)) for image in (changed, asked)]
    return np.asarray((around[0] > 0.5 * around[1]) & (asked > 0))
