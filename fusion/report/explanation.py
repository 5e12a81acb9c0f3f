"""The report of an explanation: what is missing in the model, where it shows, how sure, and what cannot be seen."""

from html import escape
from pathlib import Path
from typing import Any

from fusion.discrepancy.compared import Compared, recording_names
from fusion.discrepancy.decisions import NOISE_ALONE
from fusion.discrepancy.explain import Explanation
from fusion.discrepancy.verdict.words import how_sure, name_of, rivals_said, size_of, what_it_is
from fusion.report.claim_sections import claim_sections
from fusion.report.claims import questions
from fusion.report.figures.explanation import DISPARITY, LENGTH
from fusion.report.mismatch import fit_section, maps_section, short
from fusion.report.page import Number, Page, Section, write_page
from fusion.report.tables import folded, numbers_table
from fusion.report.visibility import invisible_section, limits_section, visibility_section
from fusion.results.light import Light, level
from fusion.sensor.in_words import plain

NOTHING = (
    "No effect passes the tests. That is no proof that there is none; the tables below say how large each could still "
    "be, and which ones these recordings cannot show."
)
LOOSE = {  # what follows no law, by its name in the verdict
    "scatter": "Neighbouring places differ by {} for no reason that is known here: second bounces, a bent target, "
    "poses. All that is said holds beyond that.",
    "drift": "Every recording has a smooth error of its own of about {} over the image, for no reason that is known "
    "here. What is said holds beyond that.",
}
CHI2 = (NOISE_ALONE, 2.5)  # misfit of the whole: explained up to, a problem above (guesses)


def explanation_report(folder: Path, found: Explanation, verdict: dict[str, Any]) -> None:
    """Write `report.html`.

    Args:
        folder: exists.
        found: all that was found.
        verdict: the content of `verdict.json`, as it is written.
    """
    seen = found.compared
    unit = LENGTH if found.before.patches[0].view.time_of_flight else DISPARITY
    page = Page(
        title="Simulation against recordings",
        subtitle=f"{len(recording_names(found.before))} recordings, {verdict['fit']['frames_fitted']} frames fitted, "
        f"{verdict['fit']['frames_heldout']} held out; {plain(found.before.sensor.principle)}",
        summary=_summary(verdict, seen),
        numbers=_numbers(verdict, seen),
        sections=[
            maps_section(seen, unit),
            *claim_sections(found, verdict, unit),
            _indicated(verdict),
            fit_section(seen),
            _extrapolation(verdict),
            limits_section(found, verdict),
            visibility_section(verdict),
            invisible_section(verdict),
        ],
    )
    write_page(Path(folder) / "report.html", page)


def _summary(verdict: dict[str, Any], seen: Compared) -> list[Light]:
    missing, likely = verdict["missing"], verdict["indicated"]
    after = level(seen.misfit[1], CHI2)
    open_ = "warning" if (missing or likely) and after == "ok" else after
    lines = [Light(open_, "Verdict", verdict["headline"])]
    for entry in (*missing, *likely):
        established = any(entry is claim for claim in missing)
        lines.append(Light("warning", _title(entry), _told(entry, established), _next(entry)))
    for key, text in LOOSE.items():
        found = verdict["fit"][key]
        if found["value"]:
            lines.append(Light("warning", key.capitalize(), text.format(f"{found['value']:.2g} {found['unit']}")))
    if "reference" in verdict:
        lines.append(Light("warning", "Reference", plain(verdict["reference"]["text"])))
    if not missing and not likely:
        lines.append(Light("ok", "How sure", NOTHING))
    return lines


def _title(entry: dict[str, Any]) -> str:
    name = name_of(entry).removeprefix("an ")
    return name[:1].upper() + name[1:]


def _next(entry: dict[str, Any]) -> str:
    return f"Record next: {plain(entry['record_next']).rstrip('.')}." if entry["record_next"] else ""


def _told(entry: dict[str, Any], established: bool) -> str:
    """What it is, how large, how sure, what else it could be."""
    happens = what_it_is(entry)
    parts = [happens, size_of(entry), how_sure(entry, established)]
    alike = ", ".join(map(plain, rivals_said(entry)))
    parts += [f"Its name is open: in these recordings it looks the same as {alike}"] if alike else []
    return " ".join(f"{part[:1].upper()}{part[1:]}." for part in parts if part)


def _numbers(verdict: dict[str, Any], seen: Compared) -> list[Number]:
    """What is wrong with the depth before and after, in millimetres; the misfit is a number for those who fit."""
    whens = ("before", "after") if seen.changed else ("",)
    numbers = []
    for when, rms in zip(whens, seen.beyond_noise, strict=False):
        numbers.append(Number(f"Depth error beyond noise {when}".strip(), f"{rms * 1e3:.2f}", "mm rms"))
    numbers.append(Number("Unexplained", f"{verdict['unexplained']['rms_m'] * 1e3:.2f}", "mm rms"))
    for when in whens:
        stated = verdict["fit"]["heldout"][f"rms_{when or 'after'}_m"]
        if stated is not None:
            name = " ".join(filter(None, ("Depth error", when, "with poses as stated")))
            numbers.append(Number(name, f"{stated * 1e3:.2f}", "mm rms"))
    return numbers


def _indicated(verdict: dict[str, Any]) -> Section:
    """What is likely but not established."""
    said = [
        f"<h3>{escape(_title(entry))}</h3><p>{escape(_told(entry, False))}</p>{questions(entry)}"
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
    return Section("Does it hold outside?", lead, html=folded("The numbers", numbers_table(head, rows)) if rows else "")
