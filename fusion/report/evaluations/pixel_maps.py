"""Maps over the image: mean and noise of every pixel, residuals from planes; one colour scale for the same thing."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fusion.report.kit.page import Figure
from fusion.report.kit.palette import DIVERGING, SEQUENTIAL, new_figure, styled, to_svg

MOST = 5  # maps in a row
SIDE = 320  # [px] of a map's longer side: more is not seen
Image = NDArray[np.floating]


def thinned(image: Image) -> Image:
    """Every second, third, ... pixel, so that a page stays light."""
    step = max(1, -(-max(image.shape) // SIDE))
    return image[::step, ::step]


def map_rows(
    rows: Sequence[tuple[str, str, Sequence[Image], bool]], columns: Sequence[str], name: str, text: Figure
) -> Figure:
    """Rows of maps, each row with one colour scale.

    Args:
        rows: (title, unit, one image (h, w) per column, True for a scale about zero).
    """
    high = 0.4 + len(rows) * (11.0 / max(len(columns), 3)) * 0.62
    with styled():
        figure = new_figure(11.0 if len(columns) > 1 else 6.5, high if len(columns) > 1 else 0.4 + 3.6 * len(rows))
        axes = figure.subplots(len(rows), len(columns), squeeze=False)
        for r, (title, unit, images, signed) in enumerate(rows):
            low, top = scale(images, signed)
            for c, image in enumerate(images):
                ax = axes[r, c]
                drawn = ax.imshow(thinned(image), cmap=DIVERGING if signed else SEQUENTIAL, vmin=low, vmax=top,
                                  interpolation="nearest")  # fmt: skip
                ax.set_xticks([])
                ax.set_yticks([])
                ax.grid(visible=False)
                if r == 0:
                    ax.set_title(columns[c])
                if c == 0:
                    ax.set_ylabel(title)
            figure.colorbar(drawn, ax=axes[r, :], label=unit, shrink=0.85, extend="both")
        return Figure(text.title, to_svg(figure, name), text.alt, text.caption)


def scale(images: Sequence[Image], signed: bool) -> tuple[float, float]:
    """Lowest and highest value shown: from the 1st to the 99th percentile of all images, about zero when signed."""
    known = np.concatenate([image[np.isfinite(image)][:: max(1, image.size // 20000)] for image in images])
    if not known.size:
        return (-1.0, 1.0) if signed else (0.0, 1.0)
    if signed:
        half = max(float(np.percentile(np.abs(known), 98)), 1e-9)
        return -half, half
    low, high = (float(x) for x in np.percentile(known, [1, 99]))
    return low, max(high, low + 1e-9)
