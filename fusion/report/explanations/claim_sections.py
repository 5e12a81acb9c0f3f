"""The parts of the page about the claims, and the picture of each: where in the image the data tell of it."""

from pathlib import Path

import cv2
import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from fusion.discrepancy.channels.lattice import Stored, stored_of
from fusion.discrepancy.explain import Explanation
from fusion.discrepancy.verdict.claim import Claim
from fusion.discrepancy.verdict.content import Verdict
from fusion.evaluation.quantization import Quantization, quantization_of
from fusion.files.output.publish import atomic_file
from fusion.report.explanations.claim_figures import Unit
from fusion.report.explanations.claims import claim_section, lead, parameters_table, questions
from fusion.report.explanations.edge_claim import edge_section, is_of
from fusion.report.explanations.evidence import footprints_of
from fusion.report.explanations.missing_values import missing_of, missing_section
from fusion.report.explanations.noise_claim import noise_mask, noise_of, noise_section
from fusion.report.kit.page import Figure, Section
from fusion.report.kit.palette import BLUE, GREY, new_figure, styled, to_svg
from fusion.sensor.words.in_words import plain

STEPS = 12  # shown one by one


def with_masks(folder: Path, found: Explanation, verdict: Verdict) -> Verdict:
    """The verdict with a mask picture for each claim that has one, written into the folder."""
    missing = []
    for number, claim in enumerate(verdict.missing):
        mask = _mask(found, verdict, number)
        if mask is not None:
            name = f"mask_{number}.png"
            with atomic_file(Path(folder) / name) as partial:
                partial.write_bytes(cv2.imencode(".png", mask)[1].tobytes())
            claim = replace(claim, where=replace(claim.where, mask=name))
        missing.append(claim)
    return replace(verdict, missing=tuple(missing))


def claim_sections(found: Explanation, verdict: Verdict, unit: Unit) -> list[Section]:
    """A section per established claim."""
    of_mean = {footprint.number: footprint for footprint in footprints_of(found, verdict)}
    sections = []
    for number, claim in enumerate(verdict.missing):
        if _is_lattice(found, claim):
            sections.append(lattice_section(found, number, claim))
        elif number not in of_mean and is_of("edges", found, claim):
            sections.append(edge_section(found, number, claim))
        elif number not in of_mean and (claim.channel == "bias" or is_of("amplitude", found, claim)):
            # grain, of which squares show nothing; what only the light tells
            title = f"{'Also missing' if number else 'Missing'}: {plain(claim.effect)}"
            sections.append(Section(title, lead(claim), (), html=parameters_table(claim) + questions(claim)))
        elif (mask := _mask(found, verdict, number)) is None:
            continue
        elif number in of_mean:
            sections.append(claim_section(found, of_mean[number], mask, unit))
        elif claim.channel == "noise":
            sections.append(noise_section(found, number, claim, noise_of(found), mask, unit))
        elif (missing := missing_of(found)) is not None:
            sections.append(missing_section(number, claim, missing))
    return sections


def _mask(found: Explanation, verdict: Verdict, number: int) -> NDArray[np.uint8] | None:
    """(h, w) where the data tell of a claim; None where no picture shows it."""
    claim = verdict.missing[number]
    footprint = next((one for one in footprints_of(found, verdict) if one.number == number), None)
    if _is_lattice(found, claim) or is_of("amplitude", found, claim):
        return None
    if footprint is not None:
        return footprint.mask(found)
    if claim.channel == "noise" and found.spread:
        return noise_mask(found, noise_of(found))
    if claim.channel == "dropout" and (missing := missing_of(found)) is not None:
        return missing.mask
    return None


def _is_lattice(found: Explanation, claim: Claim) -> bool:
    """True for the steps in which depths are stored: they are seen in no tile."""
    steps = (step.effect for step in found.channels.of("bias") if step.effect is not None)
    return any(effect.lattice and effect.name == claim.effect for effect in steps)


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
