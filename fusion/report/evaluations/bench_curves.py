"""Over distance, angle and brightness: offset, noise, stacked shares, quantisation step."""

from collections.abc import Sequence

import numpy as np
from matplotlib.ticker import LogLocator
from numpy.typing import NDArray

from fusion.evaluation.quantization import Quantization
from fusion.evaluation.still.shares import Shares
from fusion.report.kit.page import Figure
from fusion.report.kit.palette import BLUE, GREY, INK, ORANGE, RED, new_figure, styled, to_svg

AXES = {"depth": ("distance [m]", 1.0), "incidence": ("angle of incidence [deg]", 180 / np.pi),
        "brightness": ("brightness [count]", 1.0)}  # fmt: skip
WIDE = 5.0  # ratio of brightest to darkest beyond which a logarithmic axis reads better
Array = NDArray[np.floating]


def offset_figure(distance: Array, parts: Sequence[tuple[str, Array, Array]], spread: Array, text: Figure) -> Figure:
    """Offset (w,) [m] over distance [m] with thin whiskers of one depth's spread, thick ones of the mean's interval.

    Args:
        parts: (label, offset, half of the 90 % interval) as recorded, and corrected where there is a model.
        spread: (w,) standard deviation of one depth [m].
    """
    order = np.argsort(distance)
    with styled():
        figure = new_figure(11.0, 4.0)
        ax = figure.subplots()
        ax.axhline(0, color=INK, linewidth=0.8)
        for (label, offset, half), color in zip(parts, (BLUE, ORANGE), strict=False):
            x, y = distance[order], offset[order] * 1e3
            if color == BLUE:
                ax.errorbar(x, y, spread[order] * 1e3, fmt="none", ecolor=GREY, elinewidth=1, capsize=3,
                            label="one depth, one standard deviation")  # fmt: skip
            ax.errorbar(x, y, half[order] * 1e3, fmt="o-", color=color, elinewidth=3, markersize=4, linewidth=1,
                        label=f"{label}, 90 % interval")  # fmt: skip
        ax.set_xlabel("distance [m]")
        ax.set_ylabel("measured less true depth [mm]")
        ax.legend(loc="best")
        return Figure(text.title, to_svg(figure, "bench-offset"), text.alt, text.caption)


def noise_figure(depth: Array, axial: Array, expected: Array, lateral: Array, text: Figure) -> Figure:
    """Axial noise (w,) [m] of targets over distance, the model's if there is one, and lateral noise of edges."""
    order = np.argsort(depth)
    wide = np.isfinite(lateral).any()
    with styled():
        figure = new_figure(11.0, 3.6)
        axes = figure.subplots(1, 2 if wide else 1, squeeze=False)[0]
        axes[0].plot(depth[order], axial[order] * 1e3, "o-", color=BLUE, markersize=4, linewidth=1, label="measured")
        if np.isfinite(expected).any():
            axes[0].plot(depth[order], expected[order] * 1e3, "s--", color=ORANGE, markersize=4, label="sensor model")
        axes[0].set_ylabel("axial noise [mm]")
        axes[0].legend(loc="best")
        if wide:
            for side, (label, color) in enumerate((("left edge", BLUE), ("right edge", ORANGE))):
                axes[1].plot(depth[order], lateral[order, side] * 1e3, "o", color=color, markersize=4, label=label)
            axes[1].set_ylabel("lateral noise [mm]")
            axes[1].legend(loc="best")
        for ax in axes:
            ax.set_xlabel("distance [m]")
            ax.set_ylim(bottom=0)
        return Figure(text.title, to_svg(figure, "bench-noise"), text.alt, text.caption)


def shares_figure(shares: Sequence[Shares], text: Figure) -> Figure:
    """Stacked shares of valid, outlier and no-data values over each known variable."""
    with styled():
        figure = new_figure(11.0, 3.6)
        axes = figure.subplots(1, len(shares), squeeze=False, sharey=True)[0]
        for ax, part in zip(axes, shares, strict=True):
            label, factor = AXES[part.variable]
            low, width = part.low * factor, (part.high - part.low) * factor
            base = np.zeros(len(low))
            stacks = ((part.valid, BLUE, "valid"), (part.outliers, RED, "outliers"), (part.missing, GREY, "no data"))
            for values, color, name in stacks:
                ax.bar(low, values * 100, width, base * 100, align="edge", color=color, edgecolor="none",
                       label=name, alpha=0.85)  # fmt: skip
                base = base + values
            if part.variable == "brightness" and part.high[-1] > WIDE * part.low[0]:
                ax.set_xscale("log")
                ax.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
                ax.xaxis.set_major_formatter(lambda value, _: f"{value:g}")  # powers of ten would be formulas
                ax.xaxis.set_minor_formatter(lambda value, _: "")
            ax.set_xlabel(label)
            ax.grid(axis="x", visible=False)
            ax.set_ylim(0, 100)
        axes[0].set_ylabel("share of values [%]")
        axes[-1].legend(loc="upper left", bbox_to_anchor=(1, 1))
        return Figure(text.title, to_svg(figure, "bench-shares"), text.alt, text.caption)


def step_figure(found: Quantization, text: Figure) -> Figure:
    """Quantisation step over distance with its law."""
    with styled():
        figure = new_figure(11.0, 3.4)
        ax = figure.subplots()
        ax.plot(found.depth, found.step * 1e3, "o", color=BLUE, markersize=3.5, label="between the depths that occur")
        if found.law in ("z^2", "constant"):
            z = np.linspace(float(np.min(found.depth)), float(np.max(found.depth)), 100)
            name = {"z^2": "law: z^2", "constant": "law: constant"}[found.law]
            ax.plot(z, found.at(z) * 1e3, color=ORANGE, label=name)
        ax.axhline(found.unit * 1e3, color=GREY, linewidth=1, linestyle=(0, (4, 3)), label="one count of the file")
        ax.set_xlabel("distance [m]")
        ax.set_ylabel("step [mm]")
        ax.set_ylim(bottom=0)
        ax.legend(loc="best")
        return Figure(text.title, to_svg(figure, "bench-steps"), text.alt, text.caption)
