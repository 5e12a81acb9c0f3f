"""The part of an image that follows one smooth bend, as lens and sensor make it: what hangs on a wall does not."""

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from fusion.calibration.depth.walls.tiles import TileGrid, side_of, tiles_of
from fusion.geometry.robust import robust_std

CLOSER = 5.0  # robust standard deviations about a smooth surface
BORDER = 3  # [px] around what is not wall: mixed pixels
SAMPLE = 8000  # pixels that are fitted
MOST_OF_IT = 0.55  # share of the cells that must follow: things cover less than the wall does
SMOOTH = 1.5  # [cells] width of the smoothing that takes a step away
STEP = 0.3  # of a thing's height: three quarters are taken where the border lies between two cells (guess)
STARTS, BEST, STEPS = 100, 8, 10  # random planes, those that are bent, and rounds of each
Array = NDArray[np.floating]


def smooth_part(off: Array, rays: Array, near: NDArray[np.bool_], closest: float) -> NDArray[np.bool_]:
    """Pixels (h, w) of `near` that follow the bend most of the image follows.

    Cells, half as wide as tiles, say where things are: noise of pixels hides what is smaller than it, and a bend that
    is fitted to all of them leans on the things.

    Args:
        off: (h, w) share by which the depth is off a plane.
        rays: (h, w, 2) x / z and y / z.
        near: (h, w) pixels that may belong to the wall.
        closest: nothing is cut that is off by less.
    """
    cells = tiles_of(near, max(2, side_of(near.shape[1]) // 2))
    bent = _bend(cells.mean(rays[..., 0]), cells.mean(rays[..., 1]))
    means = cells.mean(np.where(near, off, 0.0))
    rest, follow = _follow(bent, means, closest)
    near = near & np.append(follow | ~_things(cells, rest, follow), True)[cells.label]
    x, y = rays[..., 0], rays[..., 1]
    bend, keep = _bend(x, y), near
    for _ in range(4):
        v, u = np.nonzero(keep)
        step = max(1, len(v) // SAMPLE)
        rest = off - bend @ _fit(bend[v[::step], u[::step]], off[v[::step], u[::step]])
        keep = near & (np.abs(rest) < max(CLOSER * robust_std(rest[keep]), closest))
    # a single lost pixel is noise; a patch of them is a thing, and its border is mixed
    other = cv2.morphologyEx((~keep & np.isfinite(off)).astype(np.uint8), cv2.MORPH_OPEN, np.ones((3, 3), np.uint8))
    return keep & (cv2.dilate(other, np.ones((2 * BORDER + 1,) * 2, np.uint8)) == 0)


def _bend(x: Array, y: Array) -> Array:
    """(..., 7) shapes of a smooth bend at rays."""
    return np.stack([np.ones_like(x), x, y, x * x, x * y, y * y, (x * x + y * y) ** 2], axis=-1)


def _fit(bend: Array, off: Array) -> Array:
    return np.asarray(np.linalg.lstsq(bend.T @ bend, bend.T @ off, rcond=1e-12)[0])


def _things(cells: TileGrid, rest: Array, follow: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(n,) cells that do not follow and begin with a step: an error of the sensor grows off the bend without one.

    A step is what smoothing takes away at the border: of a slope, however steep, it takes nothing.
    """
    off, outside, inside = cells.image(rest), *(cells.image(part.astype(float)) == 1 for part in (follow, ~follow))
    sharp, square = off - _smooth(off), np.ones((3, 3), np.uint8)
    number, label = cv2.connectedComponents(inside.astype(np.uint8), connectivity=8)
    things = np.zeros(off.shape, bool)
    for one in range(1, number):
        own = label == one
        border = outside & (cv2.dilate(own.astype(np.uint8), square) > 0)
        if not border.any():  # an island
            things |= own
            continue
        first = own & (cv2.dilate(border.astype(np.uint8), square) > 0)
        second = own & ~first & (cv2.dilate(first.astype(np.uint8), square) > 0)  # the first may see both
        height = float(np.median(off[own]))
        steps = [np.median(sharp[row]) - np.median(sharp[border]) for row in (first, second) if row.any()]
        things |= own & (max(np.sign(height) * step for step in steps) > STEP * abs(height))
    return np.asarray(things[cells.place[:, 0], cells.place[:, 1]], bool)


def _smooth(image: Array) -> Array:
    """The image (h, w), smoothed over what is known of it; slopes go on beyond its border."""
    margin = min(4, *(n - 1 for n in image.shape))
    wide = np.pad(image, margin, mode="reflect", reflect_type="odd")
    share = gaussian_filter(np.isfinite(wide).astype(float), SMOOTH)
    smooth = gaussian_filter(np.nan_to_num(wide), SMOOTH) / np.maximum(share, 1e-12)
    return np.asarray(smooth[margin : margin + image.shape[0], margin : margin + image.shape[1]])


def _follow(bend: Array, off: Array, closest: float) -> tuple[Array, NDArray[np.bool_]]:
    """What the bend of most cells leaves over (n,), and which follow it: least trimmed squares (Rousseeuw 1984)."""
    count = max(int(MOST_OF_IT * len(off)), min(len(off), bend.shape[1]))
    rng = np.random.default_rng(2)
    starts = [np.arange(len(off)), *(_flattest(bend, off, rng, count) if len(off) > 3 else ())]
    tried = [_settled(bend, off, start, count) for start in starts]
    rest = min(tried, key=lambda rest: float(np.sort(rest**2)[:count].sum()))
    keep = np.argsort(np.abs(rest))[:count]
    for _ in range(STEPS):
        rest = off - bend @ _fit(bend[keep], off[keep])
        follow = np.abs(rest) < max(CLOSER * robust_std(rest[keep]), closest)
        keep = np.flatnonzero(follow)
    return np.asarray(rest), np.asarray(follow, bool)


def _flattest(bend: Array, off: Array, rng: np.random.Generator, count: int) -> list[NDArray[np.intp]]:
    """The cells (`count`,) nearest to each of the random planes that most follow."""
    planes = []
    for _ in range(STARTS):
        three = rng.choice(len(off), 3, replace=False)
        rest = np.abs(off - bend[:, :3] @ np.linalg.lstsq(bend[three, :3], off[three], rcond=None)[0])
        near = np.argpartition(rest, count - 1)[:count]
        planes.append((float((rest[near] ** 2).sum()), near))
    return [near for _, near in sorted(planes, key=lambda plane: plane[0])[:BEST]]


def _settled(bend: Array, off: Array, keep: NDArray[np.intp], count: int) -> Array:
    """(n,) what a bend leaves over that is fitted to the cells nearest to it."""
    for _ in range(STEPS):
        rest = np.asarray(off - bend @ _fit(bend[keep], off[keep]))
        keep = np.argpartition(np.abs(rest), count - 1)[:count]
    return rest
