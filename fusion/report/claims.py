"""The part of the page about one claim: curve, mask picture, parameters, look-alikes, what to record next."""

from collections.abc import Iterator
from html import escape
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.explain import Explanation
from fusion.discrepancy.verdict.verdict import rivals_said
from fusion.report.evidence import Claim, cleaned, inside, spread, variables_here
from fusion.report.figures.explanation import Curve, Unit, claim_figure
from fusion.report.page import Figure, Section
from fusion.report.tables import numbers_table
from fusion.sensor.effects import EFFECTS
from fusion.sensor.parameter import parameters

Vector = NDArray[np.float64]

BINS = 40
FEWEST = 4  # tiles of a bin: fewer tell nothing
DOTS = 600  # of single tiles in a curve: more only make the page larger
SHOWN = 2  # variables of a law; that of the region comes on top
CERTAIN = 1e-12  # noise is not known well enough to tell smaller probabilities apart


def claim_section(found: Explanation, claim: Claim, mask: NDArray[Any], unit: Unit) -> Section:
    """Everything about one claim, the plain sentence first."""
    entry = claim.entry
    what = "an unknown effect" if entry["effect"] == "unknown" else plain(entry["effect"])
    title = f"{'Also missing' if claim.number else 'Missing'}: {what}"
    curves = [_curve(found, claim, name, unit) for name in shown_variables(found, entry)]
    curves = [curve for curve in curves if len(curve.at) > 1]
    strongest = max((float(np.abs(curve.law).max()) for curve in curves), default=0.0)
    text = Figure(
        f"It shifts the measurement by up to {strongest:.2g} {unit.text}",
        f"claim-{claim.number}",
        f"Recorded residuals with the fitted {plain(entry['effect'])} over {', '.join(c.variable for c in curves)}.",
        "Above: the fitted effect at single tiles as small dots; points are the recordings once everything else is "
        "corrected. Below: what no choice of poses explains, without the effect and with it. Points are means over "
        "tiles, whiskers one standard deviation of the noise. Bright pixels of the picture tell most for the claim.",
    )
    figures = (claim_figure(curves, mask, unit, text),) if curves else ()
    return Section(title, lead(entry), figures, html=parameters_table(entry) + questions(entry))


def plain(name: str) -> str:
    """An effect's name as words."""
    return name.replace("_", " ")


def chance(probability: float) -> str:
    """A false alarm probability in words."""
    if probability <= CERTAIN:
        return "Noise alone would practically never do this."
    if probability < 0.1:
        digits = max(1, 10 ** (len(str(round(1 / probability))) - 1))
        return f"Noise alone would do this about once in {round(1 / probability / digits) * digits:,} such data sets."
    return f"Noise alone would do this in {100 * probability:.0f} of 100 such data sets."


def quantity(value: Any, std: float | None, unit: str) -> tuple[str, str, str]:
    """Value, standard deviation and unit as text; small lengths in millimetres."""
    values = np.atleast_1d(np.asarray(value, float))
    if unit.split("/")[0] == "m" and np.abs(values).max(initial=0) < 0.1:
        values, std, unit = values * 1e3, None if std is None else std * 1e3, "m" + unit
    known = std is not None and std > 0
    places = int(np.clip(1 - np.floor(np.log10(std)), 0, 9)) if known and std is not None else -1
    said = [f"{v:.{places}f}" if known and abs(v) < 1e6 else f"{v:.4g}" for v in values[:8]]
    text = ", ".join(said) + (" ..." if len(values) > 8 else "")
    return text, f"{std:.{places}f}" if known else ("exact" if std == 0 else "not given"), "" if unit == "1" else unit


def lead(entry: dict[str, Any]) -> str:
    """What it is, how much it explains and how sure it is, in sentences."""
    evidence = entry["evidence"]
    what = "all misfit, judged on recordings that took no part in its fit"
    if entry["channel"] == "noise":
        what = "what is wrong with the noise"
    said = entry["where"]["text"].removeprefix(f"{entry['effect']}: ").replace("`", "")
    said = f"Law: {said}" if entry["where"]["text"].startswith(entry["effect"]) else said
    gain = f"It explains {evidence['heldout_gain']:.0%} of {what}."
    hidden = 1 - evidence["visible_share"]
    share = (
        f"{hidden:.0%} of its trace could be errors of poses as well; it is judged by the rest."
        if hidden > 0.02
        else ""
    )
    return f"{said[:1].upper()}{said[1:]}. {gain} {chance(evidence['false_alarm_probability'])} {share}"


def shown_variables(found: Explanation, entry: dict[str, Any]) -> list[str]:
    """The law's own variables that tiles have, at most two, and that of the region."""
    known = variables_here(found)
    kinds = {kind.name: kind for kind in EFFECTS}
    kind = kinds.get(entry["effect"])
    own = [*(kind.variables if kind else ()), *entry["where"]["variables"], "depth"]
    names = [name for name in dict.fromkeys(own) if name in known and np.ptp(known[name]) > 0]
    shown = names[:SHOWN]
    if len(shown) == SHOWN and set(shown) in ({"range", "depth"}, {"disparity", "depth"}):
        shown = shown[:1]
    regions = [bound["variable"] for bound in entry["where"]["region"] if bound["variable"] in known]
    return list(dict.fromkeys([*shown, *regions]))


def _curve(found: Explanation, claim: Claim, variable: str, unit: Unit) -> Curve:
    """Weighted means over bins of the variable, inside the claim's bounds on other variables."""
    values = variables_here(found)[variable]
    law = np.asarray(found.gauge.root @ claim.white)
    without, rest = cleaned(found.gauge, claim.white + claim.left), cleaned(found.gauge, claim.left)
    bounds = claim.entry["where"]["region"]
    used = inside(found, [bound for bound in bounds if bound["variable"] != variable])
    weights = 1 / spread(found.gauge) ** 2
    shares = [np.where(i, weights, 0) / weights[i].sum() for i in bins(found, variable, values, used)]
    means = np.array(shares).reshape(-1, len(values))
    shifts, before, after = (means @ part * unit.factor for part in (law, without, rest))
    noise = np.linalg.norm(means @ found.gauge.bare, axis=1) * unit.factor
    own = [(bound["low"], bound["high"]) for bound in bounds if bound["variable"] == variable]
    order = np.flatnonzero(used)[np.argsort(values[used], kind="stable")]
    some = order[np.linspace(0, len(order) - 1, min(len(order), DOTS)).astype(int)]
    each = np.stack([values[some], law[some] * unit.factor])
    return Curve(variable, means @ values, shifts, each, before, after, noise, own[0] if own else None)


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


def parameters_table(entry: dict[str, Any]) -> str:
    """The fitted parameters as HTML."""
    kinds = {kind.name: kind for kind in EFFECTS}
    kind = kinds.get(entry["effect"])
    meanings = {about.label: about.meaning for about in parameters(kind).values()} if kind else {}
    rows = []
    for name, known in entry["parameters"].items():
        value, std, unit = quantity(known["value"], known["std"], known["unit"])
        rows.append([name + (f": {meanings[name]}" if meanings.get(name) else ""), value, std, unit])
    head = ["parameter", "value", "+- one standard deviation", "unit"]
    return "<h3>Parameters</h3>" + numbers_table(head, rows) if rows else ""


def questions(entry: dict[str, Any]) -> str:
    """What else it could be and what to record next, as HTML."""
    alike = [plain(name) for name in rivals_said(entry)]
    other = (
        f"In this data it looks the same as: {', '.join(alike)}. Which of them it is stays open; the correction fits "
        "either way."
        if alike
        else "No other effect of the catalogue looks like it in this data."
    )
    if entry["effect"] == "unknown":
        other = (
            "No effect of the catalogue has this form; what is known of it is its law, which is in the model as a table"
        )
        if entry.get("nearest"):
            other += f". The nearest entry is {plain(entry['nearest']['effect'])}, but {entry['nearest']['reason']}"
    following = plain(entry["record_next"]) or "Nothing more is needed to tell it from others."
    parts = (("What else it could be", other), ("What to record next", following[:1].upper() + following[1:]))
    return "".join(f"<h3>{escape(title)}</h3><p>{escape(text.rstrip('.'))}.</p>" for title, text in parts)
