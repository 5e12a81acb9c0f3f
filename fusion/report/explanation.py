"""The report of an explanation: what is missing in the model, where it shows, how sure, and what cannot be seen."""

from html import escape
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from fusion.discrepancy.explain import Explanation
from fusion.discrepancy.verdict.verdict import rivals_said, sentence
from fusion.output import atomic_file
from fusion.report.claims import chance, claim_section, plain
from fusion.report.evidence import Compared, claims_of, compared, recording_names
from fusion.report.figures.explanation import DISPARITY, LENGTH, Unit
from fusion.report.lattice_claim import lattice_section
from fusion.report.mismatch import fit_section, maps_section, said_misfit, short
from fusion.report.missing_values import missing_of, missing_section
from fusion.report.noise_claim import noise_mask, noise_of, noise_section
from fusion.report.page import Number, Page, Section, write_page
from fusion.report.tables import numbers_table
from fusion.report.visibility import invisible_section, limits_section, visibility_section
from fusion.results.light import Light, level

# the three levels of a claim, in words
ESTABLISHED = "Established: chance is ruled out, and recordings that took no part in the fit show it too."
LIKELY = "Likely, not established: signs are there, but chance or one odd recording could still make them."
NOTHING = (
    "Nothing: no effect passes the tests. That is no proof that there is none; the tables below say how large each "
    "could still be, and which ones these recordings cannot show."
)
LOOSE = {  # what follows no law, by its name in the verdict
    "scatter": "Neighbouring places differ by {} for no reason that is known here: second bounces, a bent target, "
    "poses. All that is said holds beyond that.",
    "drift": "Every recording has a smooth error of its own of about {} over the image, for no reason that is known "
    "here. What is said holds beyond that.",
}
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
            _extrapolation(verdict),
            limits_section(found, verdict),
            visibility_section(verdict),
            invisible_section(verdict),
        ],
    )
    write_page(Path(folder) / "report.html", page)


def _claims(folder: Path, found: Explanation, verdict: dict[str, Any], unit: Unit) -> list[Section]:
    """A section and a mask picture per established claim."""
    of_mean = {claim.number: claim for claim in claims_of(found, verdict)}
    stepped = {step.effect.name for step in found.channels.of("bias") if step.effect}
    sections = []
    for number, entry in enumerate(verdict["missing"]):
        if entry["effect"] in stepped:
            sections.append(lattice_section(found, number, entry))
            continue
        if number in of_mean:
            mask = of_mean[number].mask(found)
            section = claim_section(found, of_mean[number], mask, unit)
        elif entry["channel"] == "noise" and found.spread:
            noise = noise_of(found)
            mask = noise_mask(found, noise)
            section = noise_section(found, number, entry, noise, mask, unit)
        elif entry["channel"] == "dropout" and (missing := missing_of(found)) is not None:
            mask = missing.mask
            section = missing_section(number, entry, missing)
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
    lines = [
        Light("warning" if missing or verdict["indicated"] else "ok", "Verdict", sentence(verdict).replace("_", " "))
    ]
    frames = "frames that took no part in any fit" if seen.held_out else "the fitted frames"
    after = seen.misfit[1]
    whole = "It is explained." if level(after, CHI2) == "ok" else "Something stays that nobody has named."
    lines.append(Light(level(after, CHI2), "Fit", f"{said_misfit(seen)}, on {frames}. {whole}"))
    for key, text in LOOSE.items():
        found = verdict["fit"][key]
        if found["value"]:
            lines.append(Light("warning", key.capitalize(), text.format(f"{found['value']:.2g} {found['unit']}")))
    if "reference" in verdict:
        lines.append(Light("warning", "Reference", verdict["reference"]["text"].replace("_", " ")))
    for entry in missing:
        text = f"{ESTABLISHED} {chance(entry['evidence']['false_alarm_probability'])}"
        alike = rivals_said(entry)
        if alike:
            text += f" Its name is open: this data cannot tell it from {', '.join(map(plain, alike))}."
        lines.append(Light("warning" if alike else "ok", f"How sure: {plain(entry['effect'])}", text))
    for entry in verdict["indicated"]:
        text = f"{LIKELY} {chance(entry['evidence']['false_alarm_probability'])}"
        lines.append(Light("warning", f"How sure: {plain(entry['effect'])}", text))
    if not missing and not verdict["indicated"]:
        lines.append(Light("ok", "How sure", NOTHING))
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
    said = [
        f"<h3>{escape(plain(entry['effect']))}</h3><p>{escape(entry['where']['text'])}. "
        f"{escape(chance(entry['evidence']['false_alarm_probability']))}</p>"
        for entry in verdict["indicated"]
    ]
    lead = "Signs of these are there, but not enough to claim them: they are not in the extended model."
    return Section("Likely, but not established", lead, html="".join(said))


def _extrapolation(verdict: dict[str, Any]) -> Section:
    """Recordings beyond all others, predicted from those."""
    names = {"depth": "farthest", "incidence": "steepest", "time": "latest"}
    rows = []
    for entry in verdict["fit"]["extrapolation"]:
        before, after = entry["chi2_per_dof_before"], entry["chi2_per_dof_after"]
        rows.append([f"the {names[entry['variable']]} recordings", short(before), short(after)])
    lead = (
        "The sizes of the claims were fitted once more without the recordings that lie beyond the others, and these "
        "were predicted: misfit of the model as given, and of the extended one."
    )
    head = ["predicted", "misfit before", "misfit after"]
    return Section("Does it hold outside?", lead, html=numbers_table(head, rows) if rows else "")
