"""The report of an explanation: what is missing in the model, where it shows, how sure, and what cannot be seen."""

from pathlib import Path

from fusion.discrepancy.compared import Compared, recording_names
from fusion.discrepancy.decisions import NOISE_ALONE
from fusion.discrepancy.explain import Explanation
from fusion.discrepancy.verdict.claim import Claim
from fusion.discrepancy.verdict.content import Verdict
from fusion.discrepancy.verdict.words import how_sure, name_of, rivals_said, size_of, what_it_is
from fusion.report.explanations.claim_figures import DISPARITY, LENGTH
from fusion.report.explanations.claim_sections import claim_sections
from fusion.report.explanations.claims import questions
from fusion.report.explanations.mismatch import fit_section, maps_section, short
from fusion.report.explanations.visibility import invisible_section, limits_section, visibility_section
from fusion.report.kit.page import Number, Page, Section, write_page
from fusion.report.kit.tables import folded, numbers_table, titled
from fusion.results.light import Light, level
from fusion.sensor.words.in_words import plain
from fusion.sensor.words.quantity import shown

NO_LIMITS = "How large any effect could be is not known before the model and the poses fit these recordings."
NOTHING = (
    "No effect passes the tests. That is no proof that there is none; the tables below say how large each could still "
    "be, and which ones these recordings cannot show."
)
# what follows no law
SCATTER = (
    "Neighbouring places differ by {} for no reason that is known here: second bounces, a bent target, "
    "poses. All that is said holds beyond that."
)
DRIFT = (
    "Every recording has a smooth error of its own of about {} over the image, for no reason that is known "
    "here. What is said holds beyond that."
)
CHI2 = (NOISE_ALONE, 2.5)  # misfit of the whole: explained up to, a problem above (guesses)


def explanation_report(folder: Path, found: Explanation, verdict: Verdict) -> None:
    """Write `report.html`."""
    seen = found.compared
    unit = LENGTH if found.before.patches[0].view.time_of_flight else DISPARITY
    page = Page(
        title="Simulation against recordings",
        subtitle=f"{len(recording_names(found.before))} recordings, {verdict.fit.frames_fitted} frames fitted, "
        f"{verdict.fit.frames_heldout} held out; {plain(found.before.sensor.principle)}",
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


def _summary(verdict: Verdict, seen: Compared) -> list[Light]:
    missing, likely = verdict.missing, verdict.indicated
    after = level(seen.misfit[1], CHI2)
    open_ = "warning" if (likely or not verdict.nothing_missing) and after == "ok" else after
    lines = [Light(open_, "Verdict", verdict.headline)]
    judged = [*((claim, True) for claim in missing), *((claim, False) for claim in likely)]
    lines += [Light("warning", _title(claim), _told(claim, sure), _next(claim)) for claim, sure in judged]
    for name, loose, text in (("Scatter", verdict.fit.scatter, SCATTER), ("Drift", verdict.fit.drift, DRIFT)):
        if loose.value:
            lines.append(Light("warning", name, text.format(shown(float(f"{loose.value:.2g}"), None, loose.unit))))
    if verdict.reference is not None:
        lines.append(Light("warning", "Reference", plain(verdict.reference.text)))
    if not missing and not likely:
        lines.append(Light("ok", "How sure", NOTHING) if verdict.limits else Light("warning", "How sure", NO_LIMITS))
    return lines


def _title(claim: Claim) -> str:
    name = name_of(claim).removeprefix("an ")
    return name[:1].upper() + name[1:]


def _next(claim: Claim) -> str:
    return f"Record next: {plain(claim.record_next).rstrip('.')}." if claim.record_next else ""


def _told(claim: Claim, established: bool) -> str:
    """What it is, how large, how sure, what else it could be."""
    happens = what_it_is(claim)
    parts = [happens, size_of(claim), how_sure(claim, established)]
    alike = ", ".join(map(plain, rivals_said(claim)))
    parts += [f"Its name is open: in these recordings it looks the same as {alike}"] if alike else []
    return " ".join(f"{part[:1].upper()}{part[1:]}." for part in parts if part)


def _numbers(verdict: Verdict, seen: Compared) -> list[Number]:
    """What is wrong with the depth before and after, in millimetres; the misfit is a number for those who fit."""
    before, after = verdict.fit.heldout.rms_before_m, verdict.fit.heldout.rms_after_m
    whens = {"before": before, "after": after} if seen.changed else {"": after}
    numbers = []
    for when, rms in zip(whens, seen.beyond_noise, strict=False):
        numbers.append(Number(f"Depth error beyond noise {when}".strip(), f"{rms * 1e3:.2f}", "mm rms"))
    numbers.append(Number("Unexplained", f"{verdict.unexplained.rms_m * 1e3:.2f}", "mm rms"))
    for when, stated in whens.items():
        if stated is not None:
            name = " ".join(filter(None, ("Depth error", when, "with poses as stated")))
            numbers.append(Number(name, f"{stated * 1e3:.2f}", "mm rms"))
    return numbers


def _indicated(verdict: Verdict) -> Section:
    """What is likely but not established."""
    said = [titled(_title(claim), _told(claim, False)) + questions(claim) for claim in verdict.indicated]
    lead = "Signs of these are there, but not enough to claim them: they are not in the extended model."
    return Section("Likely, but not established", lead, html="".join(said))


def _extrapolation(verdict: Verdict) -> Section:
    """Recordings beyond all others, predicted from those."""
    names = {"depth": "farthest", "incidence": "steepest", "time": "latest"}
    rows = []
    for end in verdict.fit.extrapolation:
        before, after = short(end.chi2_per_dof_before), short(end.chi2_per_dof_after)
        rows.append([f"the {names[end.variable]} recordings", before, after])
    lead = (
        "The sizes of the claims were fitted once more without the recordings that lie beyond the others, and these "
        "were predicted: misfit of the model as given, and of the extended one."
    )
    head = ["predicted", "misfit before", "misfit after"]
    return Section("Does it hold outside?", lead, html=folded("The numbers", numbers_table(head, rows)) if rows else "")
