"""The part of the page about the steps in which depths are stored: which values occur, and how the step grows."""

import numpy as np

from fusion.discrepancy.channels.lattice import Stored, stored_of
from fusion.discrepancy.explain import Explanation
from fusion.discrepancy.verdict.claim import Claim
from fusion.evaluation.quantization import Quantization, quantization_of
from fusion.report.explanations.claims import lead, parameters_table, questions
from fusion.report.kit.page import Figure, Section
from fusion.report.kit.palette import BLUE, GREY, new_figure, styled, to_svg
from fusion.sensor.words.in_words import plain

STEPS = 12  # shown one by one


def lattice_section(found: Explanation, number: int, claim: Claim) -> Section:
    """Everything about a claim on the steps."""
    stored = stored_of(found.before)
    law = quantization_of(stored.counts, stored.per_metre)
    title = f"{'Also missing' if number else 'Missing'}: {plain(claim.effect)} (steps)"
    figures = () if law is None else (_figure(stored, law, f"claim-{number}"),)
    return Section(title, lead(claim), figures, html=parameters_table(claim) + questions(claim))


def _figure(stored: Stored, law: Quantization, name: str) -> Figure:
    z, often = _around(stored, law)
    with styled():
        figure = new_figure(11.0, 3.6)
        comb, steps = figure.subplots(1, 2)
        comb.vlines(z, 0, often, color=BLUE, linewidth=1.6)
        comb.set_ylim(bottom=0)
        comb.set_xlabel("stored depth [m]")
        comb.set_ylabel("pixels with this value")
        at = np.linspace(0, 1.05 * float(np.max(law.depth)), 60)
        steps.plot(law.depth, 1000 * law.step, "o", color=GREY, markersize=3.5, label="seen")
        steps.plot(at, 1000 * law.at(at), color=BLUE, label="law found")
        steps.set_xlabel("depth [m]")
        steps.set_ylabel("from one value to the next [mm]")
        steps.set_ylim(bottom=0)
        steps.legend()
        return Figure(
            "Only some depths occur at all",
            to_svg(figure, name),
            "Histogram of the stored depths over a short range, and the step between them over the depth.",
            "Left: how many pixels have each value that the file can hold, over a short range of depth: a sensor "
            "without steps would fill the gaps. Right: the distance between neighbouring values.",
        )


def _around(stored: Stored, law: Quantization) -> tuple[np.ndarray, np.ndarray]:
    """Depths [m] near the most frequent one, and how often each of the file's values occurs there."""
    counts = max(stored.counts, key=lambda one: int(one.sum()))
    middle = int(np.median(np.repeat(np.arange(len(counts)), counts)))
    reach = max(round(STEPS / 2 * float(law.at(np.array(middle / stored.per_metre))) * stored.per_metre), 10)
    values = np.arange(max(middle - reach, 1), min(middle + reach, len(counts)))
    return values / stored.per_metre, counts[values]
