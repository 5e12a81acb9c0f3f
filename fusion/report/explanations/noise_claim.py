"""The part of the page about a claim on the noise: repeated frames scatter otherwise than the model says."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.channels.scatter import variance
from fusion.discrepancy.explain import Explanation
from fusion.discrepancy.observe.patch import predicted
from fusion.discrepancy.verdict.claim import Claim
from fusion.report.explanations.claim_figures import AXES, Unit, mask_panel
from fusion.report.explanations.claims import bins, lead, parameters_table, questions, shown_variables
from fusion.report.explanations.evidence import mask_of
from fusion.report.kit.page import Figure, Section
from fusion.report.kit.palette import BLUE, GREY, INK, ORANGE, new_figure, styled, to_svg
from fusion.sensor.words.in_words import plain

Vector = NDArray[np.float64]
Array = NDArray[Any]


@dataclass(frozen=True)
class SpreadCurve:
    """Noise over bins of one variable, in shown units."""

    variable: str  # name as in verdicts
    at: Array  # (k,) of the bins
    measured: Array  # (k,) standard deviation of repeated frames
    # given, extended: (k,) what the model predicts without and with the claim
    given: Array
    extended: Array


def spread_figure(curves: Sequence[SpreadCurve], mask: Array, unit: Unit, text: Figure) -> Figure:
    """Measured and predicted noise over one or two variables, their ratio, and where the claim shows."""
    with styled():
        figure = new_figure(11.0, 5.0)
        grid = figure.add_gridspec(2, len(curves) + 1, height_ratios=(1.3, 1))
        for column, curve in enumerate(curves):
            top, low = (figure.add_subplot(grid[row, column]) for row in (0, 1))
            top.plot(curve.at, curve.measured, "o", color=GREY, markersize=3.5, label="recorded")
            for predicted, color, label in (
                (curve.given, ORANGE, "without it"),
                (curve.extended, BLUE, "with it"),
            ):
                top.plot(curve.at, predicted, color=color, label=label)
                ratio = curve.measured / np.maximum(predicted, 1e-300)
                low.plot(curve.at, ratio, "o", color=color, markersize=3.5)
            low.axhline(1, color=INK, linewidth=0.8)
            top.set_ylim(bottom=0)
            top.tick_params(labelbottom=False)
            low.set_xlabel(AXES.get(curve.variable, curve.variable))
            if column == 0:
                top.set_ylabel(f"noise of a pixel [{unit.text}]")
                low.set_ylabel("recorded over predicted")
                top.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=3, borderaxespad=0.1)
        mask_panel(figure, figure.add_subplot(grid[:, -1]), mask)
        return Figure(text.title, to_svg(figure, text.svg), text.alt, text.caption)


@dataclass(frozen=True)
class Noise:
    """Variances (n,) of repeated frames in native units: measured, by the model as given, by the extended one."""

    measured: Vector
    given: Vector
    extended: Vector


def noise_of(found: Explanation) -> Noise:
    """The noise of every tile, before and with all that was found."""
    rows = []
    for patch in found.before.patches:
        with np.errstate(all="ignore"):
            sigma = predicted(found.channels.sensor, patch.block)[1]
        rows.append([variance(patch, spread) for spread in (patch.block.std, patch.sigma, sigma)])
    return Noise(*(np.concatenate(parts) for parts in zip(*rows, strict=True)))


def noise_mask(found: Explanation, noise: Noise) -> NDArray[np.uint8]:
    """(h, w) where the claim changes the noise: 255 the most."""
    return mask_of(found, np.abs(np.log(np.maximum(noise.extended, 1e-300) / np.maximum(noise.given, 1e-300))))


def noise_section(
    found: Explanation, number: int, claim: Claim, noise: Noise, mask: NDArray[Any], unit: Unit
) -> Section:
    """Everything about one claim on the noise."""
    title = f"{'Also missing' if number else 'Missing'}: {plain(claim.effect)} (noise)"
    ratio = np.sqrt(noise.extended / np.maximum(noise.given, 1e-300))
    curves = [_curve(found, noise, name, unit) for name in shown_variables(found, claim)]
    curves = [curve for curve in curves if len(curve.at) > 1]
    low, high = (float(x) for x in np.quantile(ratio, (0.1, 0.9)))
    changed = f"It makes the noise up to {high:.2f} times as large"
    if low * high < 1:
        changed = f"It makes the noise as small as {low:.2f} times what the model had"
    text = Figure(
        changed,
        f"claim-{number}",
        f"Noise of repeated frames with and without {plain(claim.effect)}.",
        "Above: standard deviation of a pixel over repeated frames, as recorded and as the model predicts it. Below: "
        "recorded over predicted noise; 1 is right. Bright pixels of the picture: changed most.",
    )
    figures = (spread_figure(curves, mask, unit, text),) if curves else ()
    return Section(title, lead(claim), figures, html=parameters_table(claim) + questions(claim))


def _curve(found: Explanation, noise: Noise, variable: str, unit: Unit) -> SpreadCurve:
    values = found.before.variables[variable]
    everywhere = np.ones(len(values), bool)
    rows = [
        [values[i].mean(), *(np.sqrt(part[i].mean()) for part in (noise.measured, noise.given, noise.extended))]
        for i in bins(found, variable, values, everywhere)
    ]
    at, measured, given, extended = np.array(rows).reshape(-1, 4).T
    return SpreadCurve(variable, at, measured * unit.factor, given * unit.factor, extended * unit.factor)
