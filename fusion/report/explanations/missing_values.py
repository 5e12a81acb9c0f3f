"""The part of the page about a claim on missing values: which share of the values is lost, and where."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.channels.validity import Validity, validity_of
from fusion.discrepancy.explain import Explanation
from fusion.discrepancy.verdict.claim import Claim
from fusion.report.explanations.claim_figures import AXES, mask_panel
from fusion.report.explanations.claims import lead, parameters_table, questions
from fusion.report.explanations.evidence import painted_mask
from fusion.report.kit.page import Figure, Section
from fusion.report.kit.palette import BLUE, GREY, ORANGE, new_figure, styled, to_svg
from fusion.sensor.words.in_words import plain

Vector = NDArray[np.float64]
BINS = 24
FEWEST = 4  # tiles of a bin
Array = NDArray[Any]


@dataclass(frozen=True)
class MissingCurve:
    """Missing values over bins of one variable [%]."""

    variable: str  # name as in verdicts
    at: Array  # (k,) of the bins
    # measured, given, extended: (k,) as recorded, by the model without and with the claim
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


@dataclass(frozen=True)
class Missing:
    """Shares of missing values (n,): measured, by the model as given, by the extended one; tiles of their own."""

    seen: Validity
    measured: Vector
    given: Vector
    extended: Vector

    @property
    def mask(self) -> NDArray[np.uint8]:
        """(h, w) where values are missing that the given model does not lose: 255 the most."""
        return painted_mask(self.seen.observations, np.abs(self.measured - self.given))


def missing_of(found: Explanation) -> Missing | None:
    """The missing values of every tile; None when there is none."""
    given = validity_of(found.before.sensor, found.before.patches)
    better = validity_of(found.channels.sensor, found.before.patches)
    if given is None or better is None:
        return None
    return Missing(given, given.missing, given.share(), better.share())


def missing_section(number: int, claim: Claim, missing: Missing) -> Section:
    """Everything about one claim on missing values."""
    name = "an unknown law" if claim.unknown else plain(claim.effect)
    title = f"{'Also missing' if number else 'Missing'}: {name} (missing values)"
    curves = [_curve(missing, variable) for variable in _shown(missing, claim)]
    lost = float(np.mean(np.maximum(missing.measured - missing.given, 0.0)))
    text = Figure(
        f"{100 * lost:.1f} % of the values are missing beyond what the model loses",
        f"claim-{number}",
        f"Share of missing values with and without {name}.",
        "Share of the values that are missing, as recorded (points) and as the model predicts it without the claim and "
        "with it. Bright pixels of the picture: most values missing that the given model does not lose.",
    )
    figures = (missing_figure(curves, missing.mask, text),) if curves else ()
    return Section(title, lead(claim), figures, html=parameters_table(claim) + questions(claim))


def _shown(missing: Missing, claim: Claim) -> list[str]:
    known = missing.seen.observations.variables
    return [name for name in claim.where.variables if name in known][:2] or ["depth"]


def _curve(missing: Missing, variable: str) -> MissingCurve:
    values = missing.seen.observations.variables[variable]
    edges = np.unique(np.quantile(values, np.linspace(0, 1, BINS + 1)))
    number = np.searchsorted(edges[1:-1], values, side="right")
    inside = [number == k for k in range(max(len(edges) - 1, 1)) if (number == k).sum() >= FEWEST]
    at = np.array([values[i].mean() for i in inside])
    rows = [[100 * part[i].mean() for i in inside] for part in (missing.measured, missing.given, missing.extended)]
    return MissingCurve(variable, at, *(np.array(row) for row in rows))
