"""How noisy a recording is, by itself: a wall far behind the object must not seem to move."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.robust import MAD_TO_STD

Image = NDArray[np.float32]
BINS = 16  # of depth: noise grows as its square or so
LEAST = 500  # differences that tell a bin: its spread to 5 %
SOME = 500_000  # pixels of all images: some 30 000 differences a bin, whose spread they tell to a hundredth


def noise_over_stated(depths: Image, sigma: Callable[[Image], Image], at: Image) -> Image:
    """Observed over stated noise, at least 1.

    Second differences of neighbours in a row have no part of a plane in them, and little of a curved surface; of
    independent noise their variance is six times its own. Noise that neighbours share shows less there: what is stated
    stands then.

    Args:
        depths: (k, h, w) images [m], NaN where missing.
        sigma: the stated noise of an image [m].
        at: (h, w) depth [m] to answer for.

    Returns:
        (h, w).
    """
    some = depths[:: max(1, depths.size // SOME)]
    stated = np.stack([sigma(image) for image in some])
    bend = some[:, :, :-2] - 2 * some[:, :, 1:-1] + some[:, :, 2:]
    ratio, depth = (np.abs(bend) / stated[:, :, 1:-1]).ravel(), some[:, :, 1:-1].ravel()
    known = np.isfinite(ratio)
    if known.sum() < LEAST:
        return np.ones_like(at)
    ratio, depth = ratio[known], np.log(depth[known])
    borders = np.linspace(depth.min(), depth.max() + 1e-6, BINS + 1)
    which = np.digitize(depth, borders) - 1
    full = [b for b in range(BINS) if np.count_nonzero(which == b) >= LEAST]
    if not full:
        return np.ones_like(at)
    spread = [MAD_TO_STD * float(np.median(ratio[which == b])) / np.sqrt(6) for b in full]
    middle = (borders[:-1] + borders[1:])[full] / 2
    with np.errstate(invalid="ignore", divide="ignore"):
        found = np.interp(np.log(at), middle, spread)
    return np.maximum(np.nan_to_num(found, nan=1.0), 1.0).astype(np.float32)
