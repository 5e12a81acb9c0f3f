"""Single pixels: a few that stand alone in most recordings, whatever they see, as stuck ones do.

They are no pattern, which all pixels have a share in; a square's mean would spread what one of them has over all.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from fusion.discrepancy.decisions import FALSE_ALARM
from fusion.discrepancy.observe.frame_block import FrameBlock
from fusion.discrepancy.observe.frames import SMOOTH_PX, local_mean
from fusion.discrepancy.observe.interior import interior
from fusion.geometry.robust import robust_std
from fusion.sensor.view import Image

AROUND = np.ones((5, 5), np.uint8)  # neighbours that a pixel is held against, itself left out
AROUND[2, 2] = 0
ROUNDS = 3  # of two beside each other the farther is told first


@dataclass(frozen=True)
class SinglePixel:
    """Column and row of a pixel that stands alone."""

    u: int
    v: int


def single_pixels(blocks: Sequence[FrameBlock]) -> list[SinglePixel]:
    """Pixels beyond all their neighbours in more than half of the blocks, so far that of a pattern of all pixels, be it
    as large as it is seen to be, chance has none; nothing of one placement, where a speck of the scene does the same.
    """
    if len({block.place for block in blocks}) < 2:
        return []
    alone = np.sum([_alone(block) for block in blocks], axis=0)
    return [SinglePixel(int(u), int(v)) for v, u in np.argwhere(2 * alone > len(blocks))]


def without(blocks: Sequence[FrameBlock], pixels: Sequence[SinglePixel]) -> list[FrameBlock]:
    """The blocks, and what is held out of them, with nothing known of some pixels."""
    if not pixels:
        return list(blocks)
    at = [pixel.v for pixel in pixels], [pixel.u for pixel in pixels]

    def clear(image: Image) -> Image:
        image = image.copy()
        image[at] = np.nan
        return image

    def one(block: FrameBlock) -> FrameBlock:
        held = None if block.held is None else one(block.held)
        return replace(block, mean=clear(block.mean), std=clear(block.std), held=held)

    return [one(block) for block in blocks]


def _alone(block: FrameBlock) -> NDArray[np.bool_]:
    """(h, w) pixels beyond all their neighbours."""
    found = np.zeros(block.mean.shape, bool)
    if block.view.depth is None:
        return found
    off = np.where(interior(block.view), block.mean - block.view.depth, np.nan)
    most = -float(ndtri(0.5 * FALSE_ALARM / off.size)) * _usual(block, off)
    for _ in range(ROUNDS):
        high, low = (_highest(np.where(found, np.nan, sign * off)) for sign in (1.0, -1.0))
        with np.errstate(invalid="ignore"):
            beyond = np.maximum(off - high, -low - off)
            # one beside nothing has no neighbours
            more = ~found & np.isfinite(beyond) & (most > 0) & (beyond > most)
        if not more.any():
            break
        found |= more
    return found


def _highest(image: Image) -> Image:
    """(h, w) most that is known of the neighbours of each pixel."""
    known = np.where(np.isfinite(image), image, -np.inf).astype(np.float32)
    return np.asarray(cv2.dilate(known, AROUND, borderValue=-np.inf), float)


def _usual(block: FrameBlock, off: Image) -> Image:
    """(h, w) [m] standard deviation of a pixel among its neighbours: noise, and what all pixels keep beside it."""
    with np.errstate(invalid="ignore"):
        noise = np.sqrt(local_mean(block.std**2) / np.maximum(local_mean(block.count.astype(float)), 1.0))
        noise = np.where(noise > 0, noise, 1.0 if not np.any(noise > 0) else np.median(noise[noise > 0]))
        # some pixels apart: what steps of rounding leave is nothing from most pixels to the next
        k = SMOOTH_PX // 2
        bends = (off[:, k:-k] - 0.5 * (off[:, : -2 * k] + off[:, 2 * k :])) / np.sqrt(1.5) / noise[:, k:-k]
    seen = np.isfinite(bends)
    told = robust_std(bends[seen]) if seen.any() else 0.0
    # where nobody told of noise, neighbours do alone
    return np.asarray(noise * (max(told, 1.0) if np.any(block.std > 0) else told))
