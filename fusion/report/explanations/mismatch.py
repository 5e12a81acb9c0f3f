"""Parts of the page on the whole mismatch: maps before and after, misfit per recording, leftovers against noise."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.compared import Compared, recording_names
from fusion.report.explanations.claim_figures import NOISE, Unit, maps_figure
from fusion.report.explanations.evidence import painted, spread
from fusion.report.kit.page import Figure, Section
from fusion.report.kit.palette import BLUE, GREY, INK, ORANGE, new_figure, styled, to_svg

MAPS = 4  # recordings side by side
Array = NDArray[np.floating]
WIDEST = 5.0  # standard deviations shown


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


def recordings_figure(recordings: Sequence[tuple[str, float, float]], changed: bool, text: Figure) -> Figure:
    """Chi2 per degree of freedom of each recording (name, before, after) as bars, with 1 = noise alone marked."""
    names, before, after = zip(*recordings, strict=True)
    place = np.arange(len(names))
    with styled():
        figure = new_figure(11.0, 3.2)
        ax = figure.subplots()
        width = 0.4 if changed else 0.7
        if changed:
            ax.bar(place - 0.2, before, width, color=ORANGE, label="model as given")
        ax.bar(place + (0.2 if changed else 0), after, width, color=BLUE, label="model extended" if changed else "")
        ax.axhline(1, color=INK, linewidth=1, linestyle=(0, (4, 3)), label="noise alone")
        if max(before) > 20:
            ax.set_yscale("log")
            ax.yaxis.set_major_formatter(lambda value, _: f"{value:g}")  # powers of ten would be formulas
            ax.yaxis.set_minor_formatter(lambda value, _: "")
        ax.set_xticks(place, names, rotation=0 if len(names) <= 12 else 60)
        ax.grid(axis="x", visible=False)
        ax.set_ylabel("chi2 per degree of freedom")
        ax.legend(loc="upper left", bbox_to_anchor=(1, 1))
        return Figure(text.title, to_svg(figure, text.svg), text.alt, text.caption)


def noise_figure(white: Array, text: Figure) -> Figure:
    """Histogram of residuals (n,) in standard deviations against the normal curve."""
    edges = np.linspace(-WIDEST, WIDEST, 51)
    counts = np.histogram(np.clip(white, -WIDEST, WIDEST), edges)[0]
    with styled():
        figure = new_figure(11.0, 3.2)
        ax = figure.subplots()
        ax.bar(edges[:-1], counts, np.diff(edges), align="edge", color=GREY, alpha=0.7, label="recorded")
        x = np.linspace(-WIDEST, WIDEST, 201)
        normal = np.exp(-0.5 * x**2) * len(white) * (edges[1] - edges[0]) / np.sqrt(2 * np.pi)
        ax.plot(x, normal, color=BLUE, label="noise alone")
        ax.set_xlabel("residual of a tile in standard deviations of what is known")
        ax.set_ylabel("tiles")
        ax.legend(loc="upper right")
        return Figure(text.title, to_svg(figure, text.svg), text.alt, text.caption)
