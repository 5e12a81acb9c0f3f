"""The share of missing values over one variable: measured, as the model had it, and with what was missing in it."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.report.explanations.claim_figures import AXES, mask_panel
from fusion.report.kit.page import Figure
from fusion.report.kit.palette import BLUE, GREY, ORANGE, new_figure, styled, to_svg

Array = NDArray[Any]


@dataclass(frozen=True)
class MissingCurve:
    """Missing values over bins of one variable [%].

    Attributes:
        variable: name as in verdicts.
        at: (k,) of the bins.
        measured, given, extended: (k,) as recorded, by the model without and with the claim.
    """

    variable: str
    at: Array
    measured: Array
    given: Array
    extended: Array


def missing_figure(curves: Sequence[MissingCurve], mask: Array, text: Figure) -> Figure:
    """Measured and predicted shares over one or two variables, and where the claim shows."""
    with styled():
        figure = new_figure(11.0, 3.6)
        axes = figure.subplots(1, len(curves) + 1)
        for column, curve in enumerate(curves):
            ax = axes[column]
            ax.plot(curve.at, curve.given, color=ORANGE, label="without it")
            ax.plot(curve.at, curve.extended, color=BLUE, label="with it")
            ax.plot(curve.at, curve.measured, "o", color=GREY, markersize=3.5, label="recorded")
            ax.set_xlabel(AXES.get(curve.variable, curve.variable))
            ax.set_ylim(0, max(5.0, 1.05 * float(np.max([curve.measured, curve.extended]))))
            if np.all(curve.at > 0) and curve.at.max() > 20 * curve.at.min():
                ax.set_xscale("log")
                ax.xaxis.set_major_formatter("{x:g}")
            if column == 0:
                ax.set_ylabel("missing values [%]")
                ax.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=3, borderaxespad=0.1)
        mask_panel(figure, axes[-1], mask)
        return Figure(text.title, to_svg(figure, text.svg), text.alt, text.caption)
