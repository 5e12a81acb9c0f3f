"""The report of an explanation: what is missing in the model, where it shows, how sure, and what cannot be seen."""

from html import escape
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from fusion.discrepancy.explain import Explanation
from fusion.discrepancy.verdict.verdict import sentence
from fusion.output import atomic_file
from fusion.report.claims import chance, claim_section, plain, quantity
from fusion.report.evidence import Compared, claims_of, compared, depth_per_native, recording_names
from fusion.report.figures.explanation import DISPARITY, LENGTH, Unit
from fusion.report.judgement import level
from fusion.report.mismatch import fit_section, maps_section, said_misfit, short
from fusion.report.noise_claim import noise_mask, noise_of, noise_section
from fusion.report.page import Light, Number, Page, Section, write_page
from fusion.report.tables import numbers_table

CHI2 = (1.3, 2.5)  # per degree of freedom: explained up to, a problem above (guesses)


def explanation_report(folder: Path, found: Explanation, verdict: dict[str, Any]) -> None:
    """Write `report.html` and a mask picture per claim; the masks' names are put into the verdict.

    Args:
        folder: exists.
        found: all that was found.
        verdict: the content of `verdict.json`; `where.mask` of each missing entry is set.
    """
    seen = compared(found)
    unit = LENGTH if found.before.patches[0].view.time_of_flight else DISPARITY
    sections = _claims(Path(folder), found, verdict, unit)
    page = Page(
        title="Simulation against recordings",
        subtitle=f"{len(recording_names(found.before))} recordings, {verdict['fit']['frames_fitted']} frames fitted, "
        f"{verdict['fit']['frames_heldout']} held out; {found.before.sensor.principle}",
        summary=_summary(verdict, seen),
        numbers=_numbers(verdict, seen),
        sections=[
            maps_section(seen, unit),
            *sections,
            _indicated(verdict),
            fit_section(seen),
            _limits(found, verdict),
            _invisible(verdict),
        ],
    )
    write_page(Path(folder) / "report.html", page)


def _claims(folder: Path, found: Explanation, verdict: dict[str, Any], unit: Unit) -> list[Section]:
    """A section and a mask picture per established claim."""
    of_mean = {claim.number: claim for claim in claims_of(found, verdict)}
    sections = []
    for number, entry in enumerate(verdict["missing"]):
        if number in of_mean:
            mask = of_mean[number].mask(found)
            section = claim_section(found, of_mean[number], mask, unit)
        elif entry["channel"] == "noise" and found.spread:
            noise = noise_of(found)
            mask = noise_mask(found, noise)
            section = noise_section(found, number, entry, noise, mask, unit)
        else:
            continue
        entry["where"]["mask"] = f"mask_{number}.png"
        _write_mask(folder / entry["where"]["mask"], mask)
        sections.append(section)
    return sections


def _write_mask(path: Path, mask: np.ndarray) -> None:
    with atomic_file(path) as partial:
        partial.write_bytes(cv2.imencode(".png", mask)[1].tobytes())


def _summary(verdict: dict[str, Any], seen: Compared) -> list[Light]:
    missing = verdict["missing"]
    lines = [Light("warning" if missing else "ok", "Verdict", sentence(verdict).replace("_", " "))]
    frames = "frames that took no part in any fit" if seen.held_out else "the fitted frames"
    after = seen.misfit[1]
    whole = "It is explained." if level(after, CHI2) == "ok" else "Something stays that nobody has named."
    lines.append(Light(level(after, CHI2), "Fit", f"{said_misfit(seen)}, on {frames}. {whole}"))
    for entry in missing:
        text = chance(entry["evidence"]["false_alarm_probability"])
        alike = entry["indistinguishable_from"]
        if alike:
            text += f" Its name is open: this data cannot tell it from {', '.join(map(plain, alike))}."
        lines.append(Light("warning" if alike else "ok", f"How sure: {plain(entry['effect'])}", text))
    return lines


def _numbers(verdict: dict[str, Any], seen: Compared) -> list[Number]:
    """Misfit, and the size of the residuals with poses as stated and as they fit best."""
    whens = ("before", "after") if seen.changed else ("",)
    held = "held-out frames" if seen.held_out else "fitted frames"
    numbers = [
        Number(f"Misfit {when}, {held}".replace(" ,", ","), short(size))
        for when, size in zip(whens, seen.misfit, strict=False)
    ]
    for when in whens:
        chi2 = verdict["fit"]["heldout"][f"chi2_per_dof_{when or 'after'}"]
        if chi2 is not None and not seen.held_out:
            numbers.append(Number(f"Misfit {when}, held-out frames".replace(" ,", ","), short(chi2)))
    for when in whens:
        rms = verdict["fit"]["heldout"][f"rms_{when or 'after'}_m"]
        if rms is not None:
            numbers.append(Number(f"Rms {when}, poses as stated".replace(" ,", ","), f"{rms * 1e3:.2f}", "mm"))
    for when, metres in zip(whens, seen.metres, strict=False):
        rms = float(np.sqrt(np.mean(metres**2)))
        numbers.append(Number(f"Rms {when}, poses fitted".replace(" ,", ","), f"{rms * 1e3:.2f}", "mm"))
    return numbers


def _indicated(verdict: dict[str, Any]) -> Section:
    """What is likely but not established."""
    rows = [
        [plain(entry["effect"]), entry["where"]["text"], chance(entry["evidence"]["false_alarm_probability"])]
        for entry in verdict["indicated"]
    ]
    lead = "Signs of these are there, but not enough to claim them."
    table = numbers_table(["effect", "what", "how sure"], rows) if rows else ""
    return Section("Likely, but not established", lead, html=table)


def _limits(found: Explanation, verdict: dict[str, Any]) -> Section:
    """What was looked for and not found, the largest first, as the depth it may change at most."""
    per_native = depth_per_native(found.before)
    # a look-alike of a claim has no limit: it may be the claim
    alike = {name for entry in verdict["missing"] for name in entry["indistinguishable_from"]}
    limits = [entry for entry in verdict["limits"] if entry["effect"] not in alike]
    sized = sorted(((_depth(found, entry, per_native), entry) for entry in limits), key=_largest_first)
    rows = []
    for metres, entry in sized:
        upper, _, unit = quantity(entry["upper"], None, entry["unit"])
        rows.append(
            [
                plain(entry["effect"]),
                entry["parameter"],
                f"{upper} {unit}".strip(),
                f"{metres * 1e3:.2g}" if np.isfinite(metres) else "",
            ]
        )
    head = ["effect", "parameter", "below (95 %)", "changes depth by less than [mm]"]
    lead = "Looked for and not found. With 95 % confidence each is smaller than this."
    return Section("What could still be there", lead, html=numbers_table(head, rows) if rows else "")


def _largest_first(item: tuple[float, dict[str, Any]]) -> tuple[float, str]:
    return (-item[0] if np.isfinite(item[0]) else np.inf, item[1]["effect"])


def _depth(found: Explanation, entry: dict[str, Any], per_native: np.ndarray) -> float:
    """Depth [m] that an effect at its limit changes in the most affected twentieth of the tiles; NaN if not known."""
    for candidate in found.candidates:
        if candidate.name != entry["effect"] or not candidate.form.atoms:
            continue
        sizes = candidate.form.atoms[0].get(entry["parameter"])
        size = float(np.max(np.abs(np.asarray(sizes, float)))) if sizes is not None else 0.0
        if size > 0:
            change = np.abs(candidate.columns[:, 0] * per_native)
            return float(np.percentile(change, 95)) * entry["upper"] / size
    return float("nan")


def _invisible(verdict: dict[str, Any]) -> Section:
    names = ", ".join(escape(plain(name)) for name in verdict["invisible"])
    lead = "These recordings say nothing about the following; they may be there or not."
    return Section("What cannot be seen here", lead, html=f"<p>{names}.</p>" if names else "")
