"""The report of an explanation: what is missing in the model, where it shows, how sure, and what cannot be seen."""

from html import escape
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from fusion.discrepancy.explain import Explanation
from fusion.discrepancy.verdict import sentence
from fusion.output import atomic_file
from fusion.report.claims import chance, claim_section, plain, quantity
from fusion.report.evidence import Compared, claims_of, compared, depth_per_native, painted, recording_names
from fusion.report.figures.explanation import DISPARITY, LENGTH, Unit, maps_figure
from fusion.report.figures.leftover import noise_figure, recordings_figure
from fusion.report.judgement import level
from fusion.report.page import Figure, Light, Number, Page, Section, write_page
from fusion.report.tables import numbers_table

MAPS = 4  # recordings side by side
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
    sections = []
    for claim in claims_of(found, verdict):
        mask = claim.mask(found)
        name = f"mask_{claim.number}.png"
        _write_mask(Path(folder) / name, mask)
        claim.entry["where"]["mask"] = name
        sections.append(claim_section(found, claim, mask, unit))
    page = Page(
        title="Simulation against recordings",
        subtitle=f"{len(recording_names(found.before))} recordings, {verdict['fit']['frames_fitted']} frames fitted, "
        f"{verdict['fit']['frames_heldout']} held out; {found.before.sensor.principle}",
        summary=_summary(verdict, seen),
        numbers=_numbers(verdict, seen),
        sections=[_maps(seen, unit), *sections, _fit(seen), _limits(found, verdict), _invisible(verdict)],
    )
    write_page(Path(folder) / "report.html", page)


def _write_mask(path: Path, mask: np.ndarray) -> None:
    with atomic_file(path) as partial:
        partial.write_bytes(cv2.imencode(".png", mask)[1].tobytes())


def _summary(verdict: dict[str, Any], seen: Compared) -> list[Light]:
    missing = verdict["missing"]
    lines = [Light("warning" if missing else "ok", "Verdict", sentence(verdict))]
    chi2 = float(np.mean(seen.white[1] ** 2))
    frames = "frames that took no part in any fit" if seen.held_out else "the fitted frames (none were held out)"
    model = "the extended model" if missing else "the model"
    reason = f"On {frames}, {model} leaves {chi2:.2f} times the noise that is expected (1 is noise alone)."
    lines.append(Light(level(chi2, CHI2), "Fit", reason))
    for entry in missing:
        text = chance(entry["evidence"]["false_alarm_probability"])
        if entry["indistinguishable_from"]:
            text += f" Its name is open: it may be {', '.join(map(plain, entry['indistinguishable_from']))} as well."
        lines.append(Light("warning" if entry["indistinguishable_from"] else "ok", plain(entry["effect"]), text))
    return lines


def _numbers(verdict: dict[str, Any], seen: Compared) -> list[Number]:
    held = ", held out" if seen.held_out else ", fitted frames"
    changed = bool(verdict["missing"])
    before, after = (float(np.mean(white**2)) for white in seen.white)
    numbers = [Number(f"Chi2 per degree of freedom{held}", f"{before:.2f}")] if changed else []
    numbers.append(
        Number(f"Chi2 {'with the extended model' if changed else 'per degree of freedom'}{held}", f"{after:.2f}")
    )
    stated = verdict["fit"]["heldout"]
    for when in ("before", "after") if changed else ("before",):
        rms = stated[f"rms_{when}_m"]
        if rms is not None:
            numbers.append(
                Number(f"Rms {when if changed else ''}, poses as stated".replace(" ,", ","), f"{rms * 1e3:.2f}", "mm")
            )
    for when, metres in zip(("before", "after") if changed else ("",), seen.metres, strict=False):
        rms = float(np.sqrt(np.mean(metres**2)))
        numbers.append(Number(f"Rms {when}, poses corrected".replace(" ,", ","), f"{rms * 1e3:.3f}", "mm"))
    return numbers


def _maps(seen: Compared, unit: Unit) -> Section:
    """The recordings that change most, before and after; of an unchanged model those with the most left over."""
    before, after = seen.clean
    changed = not np.array_equal(before, after)
    weight = (seen.white[0] - seen.white[1]) ** 2 if changed else seen.white[1] ** 2
    best: dict[int, tuple[float, slice, Any]] = {}
    for rows, patch in seen.before.rows():
        score = float(weight[rows].mean()) if len(patch.tiles) else 0.0
        if score >= best.get(patch.look.place, (-1.0,))[0]:
            best[patch.look.place] = (score, rows, patch)
    chosen = sorted(best.values(), key=lambda item: -item[0])[:MAPS]
    names = recording_names(seen.before)
    columns = []
    for _, rows, patch in sorted(chosen, key=lambda item: item[2].look.place):
        pair = (before, after) if changed else (after,)
        images = [painted(patch, values[rows]) * unit.factor for values in pair]
        columns.append((names[patch.look.place], images))
    rows_said = ["model as given", "model extended"] if changed else ["the model"]
    sizes = [float(np.sqrt(np.mean(values**2))) * unit.factor for values in (before, after)]
    title = f"Rms of the tiles {sizes[0]:.3g} {unit.text} before, {sizes[1]:.3g} {unit.text} after"
    if not changed:
        title = f"Rms of the tiles {sizes[1]:.3g} {unit.text}"
    caption = "Each square is the mean over a tile of pixels, likely errors of the stated poses taken out. White: as "
    caption += "predicted. "
    caption += "Recordings with the largest change." if changed else "Recordings with the largest leftover."
    frames = "frames that took no part in any fit" if seen.held_out else "the fitted frames"
    text = Figure(title, "maps", title + ".", caption)
    heading = "Before and after" if changed else "What is left"
    return Section(heading, f"Residual maps of {frames}.", (maps_figure(columns, rows_said, unit, text),))


def _fit(seen: Compared) -> Section:
    """Bars per recording, and the leftovers against the normal curve."""
    before, after = (float(np.mean(white**2)) for white in seen.white)
    changed = not np.array_equal(*seen.white)
    title = (
        f"Chi2 per degree of freedom {before:.2f} before, {after:.2f} after"
        if changed
        else f"Chi2 per degree of freedom {after:.2f}"
    )
    bars = recordings_figure(
        seen.recordings(), changed,
        Figure(title, "recordings", title + ".", "The mean squared residual of the tiles in units of their known "
               "uncertainty. At the dashed line a recording shows noise and nothing else."),
    )  # fmt: skip
    size = float(np.std(seen.white[1]))
    title = f"What is left spreads {size:.2f} times as much as noise alone"
    caption = "Residuals in standard deviations of everything known: noise, speckle, poses, uncertain parameters. "
    noise = noise_figure(
        seen.white[1], Figure(title, "noise", title + ".", caption + "Grey on the line: nothing else is there.")
    )
    return Section("How well it fits", "", (bars, noise))


def _limits(found: Explanation, verdict: dict[str, Any]) -> Section:
    """What was looked for and not found, the largest first, as the depth it may change at most."""
    per_native = depth_per_native(found.before)
    sized = sorted(((_depth(found, entry, per_native), entry) for entry in verdict["limits"]), key=_largest_first)
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
