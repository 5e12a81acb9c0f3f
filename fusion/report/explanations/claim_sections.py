"""The parts of the page about the claims, and the picture of each: where in the image the data tell of it."""

from pathlib import Path

import cv2
import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from fusion.discrepancy.explain import Explanation
from fusion.discrepancy.verdict.claim import Claim
from fusion.discrepancy.verdict.content import Verdict
from fusion.files.output.publish import atomic_file
from fusion.report.explanations.claim_figures import Unit
from fusion.report.explanations.claims import claim_section, lead, parameters_table, questions
from fusion.report.explanations.evidence import footprints_of
from fusion.report.explanations.lattice_claim import lattice_section
from fusion.report.explanations.missing_values import missing_of, missing_section
from fusion.report.explanations.noise_claim import noise_mask, noise_of, noise_section
from fusion.report.kit.page import Section
from fusion.sensor.words.in_words import plain


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
        elif claim.channel == "bias" and number not in of_mean:  # grain, of which squares show nothing
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
    if _is_lattice(found, claim):
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
