"""The part of the page about one claim: curve, mask picture, parameters, look-alikes, what to record next."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from fusion.discrepancy.compared import cleaned
from fusion.discrepancy.explain import Explanation
from fusion.discrepancy.verdict.claim import Claim
from fusion.discrepancy.verdict.words import chance, numbers_of, rivals_said, size_of, what_it_is
from fusion.report.explanations.claim_figures import BinnedCurve, Unit, claim_figure
from fusion.report.explanations.evidence import Footprint, inside, spread
from fusion.report.kit.page import Figure, Section
from fusion.report.kit.tables import folded, numbers_table, paragraph, titled
from fusion.sensor.effects import EFFECTS
from fusion.sensor.parameter import parameters
from fusion.sensor.words.in_words import plain

Vector = NDArray[np.float64]

BINS = 40
FEWEST = 4  # tiles of a bin: fewer tell nothing
DOTS = 600  # of single tiles in a curve: more only make the page larger
SHOWN = 2  # variables of a law; that of the region comes on top


def claim_section(found: Explanation, footprint: Footprint, mask: NDArray[Any], unit: Unit) -> Section:
    """Everything about one claim, the plain sentence first."""
    claim = footprint.claim
    what = "an unknown effect" if claim.unknown else plain(claim.effect)
    title = f"{'Also missing' if footprint.number else 'Missing'}: {what}"
    curves = [_curve(found, footprint, name, unit) for name in shown_variables(found, claim)]
    curves = [curve for curve in curves if len(curve.at) > 1]
    strongest = max((float(np.abs(curve.law).max()) for curve in curves), default=0.0)
    text = Figure(
        f"It shifts the measurement by up to {strongest:.2g} {unit.text}",
        f"claim-{footprint.number}",
        f"Recorded residuals with the fitted {plain(claim.effect)} over {', '.join(c.variable for c in curves)}.",
        "Above: the fitted effect at single tiles as small dots; points are the recordings once everything else is "
        "corrected. Below: what no choice of poses explains, without the effect and with it. Points are means over "
        "tiles, whiskers one standard deviation of the noise. Bright pixels of the picture tell most for the claim.",
    )
    figures = (claim_figure(curves, mask, unit, text),) if curves else ()
    return Section(title, lead(claim), figures, html=parameters_table(claim) + questions(claim))


def lead(claim: Claim) -> str:
    """What it is, how large and how sure it is, in sentences."""
    evidence = claim.evidence
    happens, size = what_it_is(claim), size_of(claim)
    said = [f"{happens[:1].upper()}{happens[1:]}."] if happens else []
    said += [f"Its size here: {size}."] if size else []
    sure = chance(evidence.false_alarm_probability)
    said.append(f"{sure[:1].upper()}{sure[1:]}, and recordings that took no part in the fit show it too.")
    hidden = 1 - evidence.visible_share
    if hidden > 0.02:
        said.append(f"{hidden:.0%} of its trace could be errors of poses as well; it is judged by the rest.")
    return " ".join(said)


def shown_variables(found: Explanation, claim: Claim) -> list[str]:
    """The law's own variables that tiles have, at most two, and that of the region."""
    known = found.before.variables
    kinds = {kind.name: kind for kind in EFFECTS}
    kind = kinds.get(claim.effect)
    own = [*(kind.variables if kind else ()), *claim.where.variables, "depth"]
    names = [name for name in dict.fromkeys(own) if name in known and np.ptp(known[name]) > 0]
    shown = names[:SHOWN]
    if len(shown) == SHOWN and set(shown) in ({"range", "depth"}, {"disparity", "depth"}):
        shown = shown[:1]
    regions = [bound.variable for bound in claim.where.region if bound.variable in known]
    return list(dict.fromkeys([*shown, *regions]))


def _curve(found: Explanation, footprint: Footprint, variable: str, unit: Unit) -> BinnedCurve:
    """Weighted means over bins of the variable, inside the claim's bounds on other variables."""
    values = found.before.variables[variable]
    law = np.asarray(found.covariance.root @ footprint.white)
    without, rest = (
        cleaned(found.covariance, footprint.white + footprint.left),
        cleaned(found.covariance, footprint.left),
    )
    bounds = footprint.claim.where.region
    used = inside(found, [bound for bound in bounds if bound.variable != variable])
    weights = 1 / spread(found.covariance) ** 2
    shares = [np.where(i, weights, 0) / weights[i].sum() for i in bins(found, variable, values, used)]
    means = np.array(shares).reshape(-1, len(values))
    shifts, before, after = (means @ part * unit.factor for part in (law, without, rest))
    noise = np.sqrt(np.diag(means @ found.covariance.free @ means.T)) * unit.factor
    own = [(bound.low, bound.high) for bound in bounds if bound.variable == variable]
    order = np.flatnonzero(used)[np.argsort(values[used], kind="stable")]
    some = order[np.linspace(0, len(order) - 1, min(len(order), DOTS)).astype(int)]
    each = np.stack([values[some], law[some] * unit.factor])
    return BinnedCurve(variable, means @ values, shifts, each, before, after, noise, own[0] if own else None)


def bins(found: Explanation, variable: str, values: Vector, used: NDArray[np.bool_]) -> Iterator[NDArray[np.bool_]]:
    """Tiles (n,) of each bin: rows or columns of tiles, else equally many tiles each."""
    if variable in ("u", "v"):
        side = max(patch.tiles.side for patch in found.before.patches)
        edges = np.arange(0.0, float(np.max(values)) + side, float(side))
    else:
        edges = np.unique(np.quantile(values[used], np.linspace(0, 1, BINS + 1)))
    number = np.searchsorted(edges[1:-1], values, side="right")
    for k in range(max(len(edges) - 1, 1)):
        inner = used & (number == k)
        if inner.sum() >= FEWEST:
            yield inner


def parameters_table(claim: Claim) -> Markup:
    """The fitted parameters as HTML, every wave of them, and the law that they are of, folded."""
    kinds = {kind.name: kind for kind in EFFECTS}
    kind = kinds.get(claim.effect)
    meanings = {about.label: about.meaning for about in parameters(kind).values()} if kind else {}
    rows = []
    for name, values in numbers_of(claim):
        which = [f" {k + 1}" if len(values) > 1 else "" for k in range(len(values))]
        meaning = f": {meanings[name]}" if meanings.get(name) else ""
        rows += [[f"{name}{k}{meaning}", value] for k, value in zip(which, values, strict=True)]
    table = numbers_table(["parameter", "value +- one standard deviation"], rows) if rows else ""
    said = claim.where.text.removeprefix(f"{claim.effect}: ").replace("`", "")
    gain = f"It explains {claim.evidence.heldout_gain:.0%} of what is wrong, judged on recordings left out."
    law = folded("Its law", paragraph(f"{said[:1].upper() + said[1:]}. {gain}"))
    return (titled("Parameters") + table if table else Markup()) + law


def questions(claim: Claim) -> Markup:
    """What else it could be and what to record next, as HTML."""
    alike = [plain(name) for name in rivals_said(claim)]
    other = (
        f"In this data it looks the same as: {', '.join(alike)}. Which of them it is stays open; the correction fits "
        "either way."
        if alike
        else "No other effect of the catalogue looks like it in this data."
    )
    if claim.unknown:
        other = (
            "No effect of the catalogue has this form; what is known of it is its law, which is in the model as a table"
        )
        if claim.nearest:
            other += f". The nearest entry is {plain(claim.nearest.effect)}, but {claim.nearest.reason}"
    following = plain(claim.record_next) or "Nothing more is needed to tell it from others."
    parts = (("What else it could be", other), ("What to record next", following[:1].upper() + following[1:]))
    return Markup().join(titled(title, text.rstrip(".") + ".") for title, text in parts)
