"""The part of the page about a claim on missing values: which share of the values is lost, and where."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.channels.validity import Validity, validity_of
from fusion.discrepancy.explain import Explanation, variables_of
from fusion.discrepancy.verdict.claim import Claim
from fusion.report.explanations.claims import lead, parameters_table, questions
from fusion.report.explanations.evidence import painted_mask
from fusion.report.explanations.share_figure import MissingCurve, missing_figure
from fusion.report.kit.page import Figure, Section
from fusion.sensor.words.in_words import plain

Vector = NDArray[np.float64]

BINS = 24
FEWEST = 4  # tiles of a bin


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
    known = variables_of(missing.seen.observations)
    return [name for name in claim.where.variables if name in known][:2] or ["depth"]


def _curve(missing: Missing, variable: str) -> MissingCurve:
    values = variables_of(missing.seen.observations)[variable]
    edges = np.unique(np.quantile(values, np.linspace(0, 1, BINS + 1)))
    number = np.searchsorted(edges[1:-1], values, side="right")
    inside = [number == k for k in range(max(len(edges) - 1, 1)) if (number == k).sum() >= FEWEST]
    at = np.array([values[i].mean() for i in inside])
    rows = [[100 * part[i].mean() for i in inside] for part in (missing.measured, missing.given, missing.extended)]
    return MissingCurve(variable, at, *(np.array(row) for row in rows))
