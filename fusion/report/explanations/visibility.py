"""Parts of the page on what these recordings could show at all: limits, look-alikes, and what they cannot show."""

import numpy as np

from fusion.discrepancy.compared import depth_per_native
from fusion.discrepancy.explain import Explanation
from fusion.discrepancy.verdict.content import UpperLimit, Verdict
from fusion.report.kit.page import Section
from fusion.report.kit.tables import folded, numbers_table, titled
from fusion.sensor.words.in_words import plain
from fusion.sensor.words.quantity import quantity


def limits_section(found: Explanation, verdict: Verdict) -> Section:
    """What was looked for and not found, the largest first, as the depth it may change at most."""
    per_native = depth_per_native(found.before)
    # a look-alike of a claim has no limit: it may be the claim
    alike = {name for entry in verdict.missing for name in entry.indistinguishable_from}
    limits = [entry for entry in verdict.limits if entry.effect not in alike]
    sized = sorted(
        ((_depth(found, entry, per_native), entry) for entry in limits), key=lambda one: _largest_first(*one)
    )
    rows = []
    for metres, entry in sized:
        upper, _, unit = quantity(entry.upper, None, entry.unit)
        depth = f"{metres * 1e3:.2g}" if np.isfinite(metres) else ""
        rows.append([plain(entry.effect), entry.parameter, f"{upper} {unit}".strip(), depth])
    head = ["effect", "parameter", "smaller than", "changes depth by less than [mm]"]
    title = "What could still be there"
    if not rows:
        return Section(title)
    lead = "Looked for and not found. Each is smaller than this, 95 times out of 100."
    return Section(title, lead, html=_folded(f"All {len(rows)} effects", head, rows))


def advised(text: str) -> str:
    """A recording of the plans, "rail: a flat wall from ...", as a sentence."""
    name, _, what = text.partition(": ")
    return f"What would show it: {what} ({name})." if what else f"What would show it: {text}."


def visibility_section(verdict: Verdict) -> Section:
    """Of every effect: how much of its trace is not swallowed by errors of poses, and what would stand out."""
    rows = []
    for entry in verdict.identifiability:
        size = "does not stand out"
        if entry.detectable is not None:
            value, _, unit = quantity(entry.detectable, None, entry.unit)
            size = f"{value} {unit}".strip()
        alike = ", ".join(map(plain, entry.looks_like)) or "nothing"
        rows.append([plain(entry.effect), _percent(entry.visible_share), entry.parameter, size, alike])
    lead = (
        "A camera pose that is a little off, or a known number that is a little wrong, can swallow much of an effect's "
        "trace. The table says for each effect how much of its trace stays, how large it must be to stand out clearly "
        "(five times the noise), and which other effects leave the same trace in these recordings."
    )
    head = ["effect", "trace that stays", "parameter", "stands out from", "looks the same as"]
    return Section("What these recordings could show", lead, html=_folded(f"All {len(rows)} effects", head, rows))


def invisible_section(verdict: Verdict) -> Section:
    """What these recordings say nothing about, and which recording would."""
    would = {entry.effect: entry for entry in verdict.would_show}
    groups: dict[str, list[str]] = {}
    for name in verdict.invisible:
        groups.setdefault(would[name].text if name in would else "", []).append(name)
    said = []
    for text, names in sorted(groups.items(), key=lambda item: (not item[0], -len(item[1]))):
        sigmas = [sigma for name in names if name in would and (sigma := would[name].sigma)]
        advice = advised(text) if text else "Nothing on the menu of simple recordings shows it."
        if sigmas:
            advice += f" At its usual size it would stand out by {min(sigmas):.0f} times the noise."
        said.append(titled(", ".join(map(plain, names)), advice))
    lead = "These recordings say nothing about the following; they may be there or not."
    html = folded(f"All {len(verdict.invisible)} effects", "".join(said)) if said else ""
    return Section("What cannot be seen here", lead, html=html)


def _folded(title: str, head: list[str], rows: list[list[str]]) -> str:
    return folded(title, numbers_table(head, rows)) if rows else ""


def _percent(share: float) -> str:
    return f"{100 * share:.0f} %" if share >= 0.1 else f"{100 * share:.2g} %"


def _largest_first(metres: float, limit: UpperLimit) -> tuple[float, str]:
    return (-metres if np.isfinite(metres) else np.inf, limit.effect)


def _depth(found: Explanation, entry: UpperLimit, per_native: np.ndarray) -> float:
    """Depth [m] that an effect at its limit changes in the most affected twentieth of the tiles; NaN if not known."""
    for candidate in found.candidates:
        if candidate.name != entry.effect or not candidate.form.atoms:
            continue
        sizes = candidate.form.atoms[0].get(entry.parameter)
        size = float(np.max(np.abs(np.asarray(sizes, float)))) if sizes is not None else 0.0
        if size > 0:
            change = np.abs(candidate.columns[:, 0] * per_native)
            return float(np.percentile(change, 95)) * entry.upper / size
    return float("nan")
