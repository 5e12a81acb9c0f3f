"""The part of the page about a claim on the noise: repeated frames scatter otherwise than the model says."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.channels.scatter import variance
from fusion.discrepancy.explain import Explanation
from fusion.discrepancy.observe.observations import predicted
from fusion.discrepancy.verdict.claim import Claim
from fusion.report.explanations.claim_figures import Unit
from fusion.report.explanations.claims import bins, lead, parameters_table, questions, shown_variables
from fusion.report.explanations.evidence import mask_of, variables_here
from fusion.report.explanations.spread import SpreadCurve, spread_figure
from fusion.report.kit.page import Figure, Section
from fusion.sensor.words.in_words import plain

Vector = NDArray[np.float64]


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
    values = variables_here(found)[variable]
    everywhere = np.ones(len(values), bool)
    rows = [
        [values[i].mean(), *(np.sqrt(part[i].mean()) for part in (noise.measured, noise.given, noise.extended))]
        for i in bins(found, variable, values, everywhere)
    ]
    at, measured, given, extended = np.array(rows).reshape(-1, 4).T
    return SpreadCurve(variable, at, measured * unit.factor, given * unit.factor, extended * unit.factor)
