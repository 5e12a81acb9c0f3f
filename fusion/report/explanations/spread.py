"""The noise of repeated frames over one variable: measured, as the model had it, and with what was missing."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.report.explanations.claim_figures import AXES, Unit, mask_panel
from fusion.report.kit.page import Figure
from fusion.report.kit.palette import BLUE, GREY, INK, ORANGE, new_figure, styled, to_svg

Array = NDArray[Any]


@dataclass(frozen=True)
class SpreadCurve:
    """Noise over bins of one variable, in shown units.

    Attributes:
        variable: name as in verdicts.
        at: (k,) of the bins.
        measured: (k,) standard deviation of repeated frames.
        given, extended: (k,) what the model predicts without and with the claim.
    """

    variable: str
    at: Array
    measured: Array
    given: Array
    extended: Array


def spread_figure(curves: Sequence[SpreadCurve], mask: Array, unit: Unit, text: Figure) -> Figure:
    """Measured and predicted noise over one or two variables, their ratio, and where the claim shows."""
    with styled():
        figure = new_figure(11.0, 5.0)
        grid = figure.add_gridspec(2, len(curves) + 1, height_ratios=(1.3, 1))
        for column, curve in enumerate(curves):
            top, low = (figure.add_subplot(grid[row, column]) for row in (0, 1))
            top.plot(curve.at, curve.measured, "o", color=GREY, markersize=3.5, label="recorded")
            for predicted, color, label in (
                (curve.given, ORANGE, "without it"),
                (curve.extended, BLUE, "with it"),
            ):
                top.plot(curve.at, predicted, color=color, label=label)
                ratio = curve.measured / np.maximum(predicted, 1e-300)
                low.plot(curve.at, ratio, "o", color=color, markersize=3.5)
            low.axhline(1, color=INK, linewidth=0.8)
            top.set_ylim(bottom=0)
            top.tick_params(labelbottom=False)
            low.set_xlabel(AXES.get(curve.variable, curve.variable))
            if column == 0:
                top.set_ylabel(f"noise of a pixel [{unit.text}]")
                low.set_ylabel("recorded over predicted")
                top.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=3, borderaxespad=0.1)
        mask_panel(figure, figure.add_subplot(grid[:, -1]), mask)
        return Figure(text.title, to_svg(figure, text.svg), text.alt, text.caption)
