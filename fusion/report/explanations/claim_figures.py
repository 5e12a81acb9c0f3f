"""Where and how a claim shows: residual maps before and after, and the law as a curve through the data."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.report.kit.page import Figure
from fusion.report.kit.palette import BLUE, DIVERGING, GREY, INK, ORANGE, SEQUENTIAL, SKY, new_figure, styled, to_svg

Array = NDArray[Any]

AXES = {
    "depth": "depth [m]", "range": "range along the ray [m]", "disparity": "disparity [px]", "u": "column u [px]",
    "v": "row v [px]", "radius": "distance from the image centre [px]", "incidence": "angle of incidence [rad]",
    "amplitude": "amplitude of the infrared image [count]", "reflectance": "reflectance", "time": "time [s]",
    "temperature": "temperature [deg C]", "table_angle": "angle of the turntable [rad]",
}  # fmt: skip


@dataclass(frozen=True)
class Unit:
    """How residuals are shown: factor from native units, the unit's text, what is compared."""

    factor: float
    text: str
    quantity: str


SIGMAS = 4.0  # end of the scale of residuals in standard deviations
LENGTH = Unit(1e3, "mm", "measured less predicted, along the ray")
DISPARITY = Unit(1.0, "px", "measured less predicted disparity")
NOISE = Unit(1.0, "standard deviations", "residual")


@dataclass(frozen=True)
class BinnedCurve:
    """Means over bins of one variable, in shown units."""

    variable: str  # name as in verdicts
    at: Array  # (k,) of the bins
    law: Array  # (k,) the fitted effect
    each: Array  # (2, m) the variable and the fitted effect at single tiles: a law may swing within a bin
    # without, rest: (k,) residuals without and with it, poses set as well as they can be each time
    without: Array
    rest: Array
    std: Array  # (k,) of the residuals by noise alone
    region: tuple[float, float] | None  # bounds in this variable, or None


def maps_figure(
    columns: Sequence[Sequence[tuple[str, Array]]], rows: Sequence[str], unit: Unit, text: Figure
) -> Figure:
    """Residual maps (h, w) with one colour scale: a column per recording, a row per model."""
    known = np.abs(np.concatenate([np.ravel(image) for column in columns for _, image in column]))
    known = known[np.isfinite(known)]
    half = SIGMAS if unit is NOISE else max(float(np.percentile(known, 98)) if len(known) else 1.0, 1e-6)
    with styled():
        figure = new_figure(11.0, 0.4 + 2.3 * len(rows))
        axes = figure.subplots(len(rows), len(columns), squeeze=False)
        for i, column in enumerate(columns):
            for j, (name, image) in enumerate(column):
                ax = axes[j, i]
                drawn = _image(ax, image, cmap=DIVERGING, vmin=-half, vmax=half)
                ax.set_title(name)
                if i == 0:
                    ax.set_ylabel(rows[j])
        figure.colorbar(drawn, ax=axes, label=f"{unit.quantity} [{unit.text}]", shrink=0.8, extend="both")
        return Figure(text.title, to_svg(figure, text.svg), text.alt, text.caption)


def claim_figure(curves: Sequence[BinnedCurve], mask: Array, unit: Unit, text: Figure) -> Figure:
    """Law, data and leftover over one to three variables, and the picture of where the claim shows."""
    with styled():
        figure = new_figure(11.0, 5.0)
        grid = figure.add_gridspec(2, len(curves) + 1, height_ratios=(1.3, 1))
        first: list[Any] = [None, None]
        for column, curve in enumerate(curves):
            top = figure.add_subplot(grid[0, column], sharey=first[0])
            low = figure.add_subplot(grid[1, column], sharey=first[1], sharex=top)
            first = [first[0] or top, first[1] or low]
            _curve(top, low, curve, legend=column == 0)
            if column == 0:
                top.set_ylabel(f"shift [{unit.text}]")
                low.set_ylabel(f"left over [{unit.text}]")
                for ax in (top, low):  # the layout does not see how wide the numbers of shared axes are
                    ax.yaxis.set_label_coords(-0.08 * (len(curves) + 1), 0.5)
            else:
                top.tick_params(labelleft=False)
                low.tick_params(labelleft=False)
        mask_panel(figure, figure.add_subplot(grid[:, -1]), mask)
        return Figure(text.title, to_svg(figure, text.svg), text.alt, text.caption)


def mask_panel(figure: Any, ax: Any, mask: Array) -> None:
    """The picture (h, w) uint8 of where a claim shows."""
    drawn = _image(ax, mask / 2.55, cmap=SEQUENTIAL, vmin=0, vmax=100)
    ax.set_title("Where in the image it shows")
    figure.colorbar(drawn, ax=ax, label="share of the strongest pixel [%]", shrink=0.6, orientation="horizontal")


def _curve(top: Any, low: Any, curve: BinnedCurve, legend: bool) -> None:
    if curve.region is not None:
        ends = np.clip(curve.region, curve.at[0], curve.at[-1])
        for ax in (top, low):
            ax.axvspan(*ends, color=SKY, alpha=0.15, linewidth=0, label="region of the claim")
    whiskers: Any = {"fmt": "o", "markersize": 3.5, "capsize": 2, "linewidth": 1}
    for ax in (top, low):
        ax.axhline(0, color=INK, linewidth=0.8)
    top.errorbar(curve.at, curve.law + curve.rest, curve.std, color=GREY, label="recorded", **whiskers)
    top.plot(*curve.each, ".", markersize=2.5, color=BLUE, label="the effect, fitted")
    low.errorbar(curve.at, curve.without, curve.std, color=ORANGE, label="without it", **whiskers)
    low.errorbar(curve.at, curve.rest, curve.std, color=BLUE, label="with it", **whiskers)
    low.set_xlabel(AXES.get(curve.variable, curve.variable))
    top.tick_params(labelbottom=False)
    if curve.variable == "amplitude" and curve.at[0] > 0 and curve.at[-1] > 5 * curve.at[0]:
        for ax in (top, low):
            ax.set_xscale("log")
            ax.xaxis.set_major_formatter(lambda value, _: f"{value:g}")  # powers of ten would be formulas
            ax.xaxis.set_minor_formatter(lambda value, _: "")
    if legend:
        for ax in (top, low):
            ax.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=3, borderaxespad=0.1)


def _image(ax: Any, image: Array, **how: Any) -> Any:
    ax.set_xticks([])
    ax.set_yticks([])
    ax.grid(visible=False)
    return ax.imshow(image, interpolation="nearest", **how)
