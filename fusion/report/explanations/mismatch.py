"""Parts of the page on the whole mismatch: maps before and after, misfit per recording, leftovers against noise."""

from typing import Any

import numpy as np

from fusion.discrepancy.compared import Compared, recording_names
from fusion.report.explanations.claim_figures import NOISE, Unit, maps_figure
from fusion.report.explanations.evidence import painted, spread
from fusion.report.explanations.leftover import noise_figure, recordings_figure
from fusion.report.kit.page import Figure, Section

MAPS = 4  # recordings side by side


def said_misfit(seen: Compared) -> str:
    """The misfit before and after, without a full stop."""
    before, after = seen.misfit
    if seen.changed:
        return f"The misfit of the mean depth goes from {short(before)} to {short(after)} (1 is noise alone)"
    return f"The misfit of the mean depth is {short(after)} (1 is noise alone)"


def short(misfit: float) -> str:
    """A misfit as text: digits that matter."""
    return f"{misfit:.2f}" if misfit < 10 else f"{misfit:,.0f}"


def maps_section(seen: Compared, unit: Unit) -> Section:
    """The recordings that change most, before and after; of an unchanged model those with the most left over."""
    names = recording_names(seen.before)
    unit, sizes = (unit, np.ones_like(seen.clean[1])) if seen.changed else (NOISE, spread(seen.covariance))
    columns = []
    for rows, patch in _chosen(seen):
        column = []
        for model in (0, 1) if seen.changed else (1,):
            misfit = short(float(np.mean(seen.white[model][rows] ** 2)))
            image = painted(patch, seen.clean[model][rows] / sizes[rows]) * unit.factor
            column.append((f"{names[patch.block.place]}: misfit {misfit}", image))
        columns.append(column)
    rms = [1e3 * size for size in seen.beyond_noise]
    told = f"The error of the depth beyond noise goes from {rms[0]:.2f} to {rms[1]:.2f} mm"
    finding = told if seen.changed else said_misfit(seen)
    measure = "White: as predicted" if seen.changed else "Colour: residual over the noise that is expected there"
    text = Figure(
        finding,
        "maps",
        f"Residual maps of some recordings. {said_misfit(seen)}.",
        "Each square is the mean over a tile of pixels; likely errors of the stated poses are taken out first. "
        f"{measure}. Shown: the recordings with the largest {'change' if seen.changed else 'leftover'}. Misfit: "
        "squared error over that of the expected noise, 1 for noise alone (chi2 per degree of freedom).",
    )
    frames = (
        "frames that took no part in any fit"
        if seen.held_out
        else "the fitted frames; not every recording has frames to hold out"
    )
    labels = ["model as given", "model extended"] if seen.changed else ["the model"]
    title = "Before and after" if seen.changed else "What is left"
    return Section(title, f"Residual maps of {frames}.", (maps_figure(columns, labels, unit, text),))


def fit_section(seen: Compared) -> Section:
    """Bars per recording, and the leftovers against the normal curve."""
    text = Figure(
        said_misfit(seen),
        "recordings",
        f"Misfit of each recording. {said_misfit(seen)}.",
        "Chi2 per degree of freedom of each recording. At the dashed line it shows noise and nothing else.",
    )
    bars = recordings_figure(seen.recordings(), seen.changed, text)
    size = float(np.std(seen.white[1]))
    title = f"What is left spreads {size:.2f} times as much as noise alone"
    caption = (
        "Residuals of tiles, each divided by what is expected of it: noise, speckle, poses, uncertain parameters. "
    )
    noise = noise_figure(
        seen.white[1],
        Figure(title, "noise", title + ".", caption + "Where bars follow the line, nothing else is there."),
    )
    return Section("How well it fits", "", (bars, noise))


def _chosen(seen: Compared) -> list[tuple[slice, Any]]:
    """The look with the most to show of the recordings with the most to show, in the order of recordings."""
    white = seen.white
    weight = (white[0] - white[1]) ** 2 if seen.changed else white[1] ** 2
    best: dict[int, tuple[float, slice, Any]] = {}
    for rows, patch in seen.before.rows():
        score = float(weight[rows].mean()) if len(patch.tiles) else -1.0
        if score > best.get(patch.block.place, (-1.0,))[0]:
            best[patch.block.place] = (score, rows, patch)
    most = sorted(best.values(), key=lambda item: -item[0])[:MAPS]
    return [(rows, patch) for _, rows, patch in sorted(most, key=lambda item: item[2].block.place)]
