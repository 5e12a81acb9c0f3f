"""The depth error: over distance as one curve, over the image as maps, and of every candidate law as bars."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.calibration.depth.maps.curve import DepthCurve
from fusion.report.kit.page import Figure
from fusion.report.kit.palette import BLUE, DIVERGING, GREY, INK, ORANGE, new_figure, styled, to_svg

SHORT = 10  # letters of a map's title in the usual size
SHOWN = 5  # maps in a row
BARS = 16  # candidates shown; the others stand in the table
Array = NDArray[np.floating]


def curve_figure(curve: DepthCurve, distance: Array, offset: Array, offset_std: Array) -> Figure:
    """Offset against distance: walls (w,) [m] with whiskers of one standard deviation, the law with its 90 % band."""
    known = np.isfinite(offset)
    largest = float(np.abs(curve.bias).max()) * 1e3
    title = f"On the optical axis the depth is off by up to {largest:.1f} mm"
    with styled():
        figure = new_figure(11.0, 4.0)
        ax = figure.subplots()
        ax.axhline(0, color=INK, linewidth=0.8)
        low, high = ((curve.bias + side * curve.half_width) * 1e3 for side in (-1, 1))
        ax.fill_between(curve.distance, low, high, color=BLUE, alpha=0.2, linewidth=0, label="90 % interval")
        ax.plot(curve.distance, curve.bias * 1e3, color=BLUE, label="fitted law")
        ax.errorbar(
            distance[known],
            offset[known] * 1e3,
            offset_std[known] * 1e3,
            fmt="o",
            color=ORANGE,
            markersize=4,
            capsize=3,
            label="walls, one standard deviation",
        )
        ax.set_xlabel("distance along the optical axis [m]")
        ax.set_ylabel("measured less true depth [mm]")
        ax.legend(loc="best")
        svg = to_svg(figure, "depth-curve")
    caption = "Whiskers: mostly the distance's own deviation. The band holds the law's uncertainty; walls, not pixels, "
    return Figure(
        title, svg, title + ".", caption + "count as measurements. What --sensor knew already is undone first."
    )


def maps_figure(images: Sequence[tuple[str, Array, Array]]) -> Figure:
    """Residual maps (rows, columns) [m] of some walls before and after the correction, one colour scale for all.

    Args:
        images: (title, before, after) of each wall shown, NaN where nothing is known.
    """
    everything = np.concatenate([np.ravel(part) for _, *pair in images for part in pair])
    known = np.abs(everything[np.isfinite(everything)]) * 1e3
    half = max(float(np.percentile(known, 98)) if len(known) else 1.0, 0.1)
    before, after = (
        float(np.sqrt(np.nanmean(np.concatenate([np.ravel(image[row]) for image in images]) ** 2))) * 1e3
        for row in (1, 2)
    )
    title = f"Residuals from the walls: {before:.2f} mm rms as recorded, {after:.2f} mm corrected"
    with styled():
        figure = new_figure(11.0, 3.7)
        axes = figure.subplots(2, len(images), squeeze=False)
        for column, (name, *pair) in enumerate(images):
            for row, image in enumerate(pair):
                ax = axes[row, column]
                drawn = ax.imshow(image * 1e3, cmap=DIVERGING, vmin=-half, vmax=half, interpolation="nearest")
                ax.set_xticks([])
                ax.set_yticks([])
                ax.grid(visible=False)
                if row == 0:
                    ax.set_title(name, fontsize="small" if len(name) > SHORT else None)
                if column == 0:
                    ax.set_ylabel("as recorded" if row == 0 else "corrected")
        figure.colorbar(drawn, ax=axes, label="measured less wall [mm]", shrink=0.8, extend="both")
        svg = to_svg(figure, "depth-maps")
    caption = "Each square is the mean over a tile of pixels. The wall's own tilt is taken out, its distance is not; "
    return Figure(title, svg, title + ".", caption + "corrected: by the law fitted to the other walls.")


def candidates_figure(names: Sequence[str], errors: Array, offsets: Array, chosen: int) -> Figure:
    """Held-out error (n,) [m] of every candidate as bars, the part of it on the axis, the chosen one marked.

    With more than 16 candidates the first, the chosen and those with the least errors are shown.
    """
    order = np.argsort(errors)[:BARS]
    shown = np.array(sorted({0, chosen, *map(int, order)}, key=lambda i: -errors[i]))
    title = f"On walls left out: {errors[0] * 1e3:.2f} mm rms without correction, "
    title += f"{errors[chosen] * 1e3:.2f} mm with {names[chosen]}"
    with styled():
        figure = new_figure(11.0, 0.9 + 0.24 * len(shown))
        ax = figure.subplots()
        place = np.arange(len(shown))
        colors = [BLUE if i == chosen else GREY for i in shown]
        ax.barh(place, errors[shown] * 1e3, color=colors, height=0.7)
        mark: dict[str, Any] = {
            "marker": "D",
            "color": ORANGE,
            "markeredgecolor": "white",
            "markersize": 6,
            "linestyle": "none",
        }
        ax.plot(offsets[shown] * 1e3, place, label="of it on the optical axis", **mark)
        for at, i in enumerate(shown):
            ax.annotate(
                f"{errors[i] * 1e3:.2f}", (errors[i] * 1e3, at), (4, 0), textcoords="offset points", va="center"
            )
        ax.set_yticks(place, [names[i] + (" (chosen)" if i == chosen else "") for i in shown])
        ax.grid(axis="y", visible=False)
        ax.set_xlabel("error on a wall that was left out [mm rms]")
        ax.margins(x=0.08, y=0.01)
        if np.isfinite(offsets[shown]).any():
            ax.legend(loc="upper right")
        svg = to_svg(figure, "candidates")
    caption = "The choice weighs every wall by its noise, and takes a simpler law where it is as good; so the shortest "
    return Figure(title, svg, title + ".", caption + "bar in plain millimetres is not always the chosen one.")
