"""The parts of the page about the claims, and the picture of each: where in the image the data tell of it."""

from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.explain import Explanation
from fusion.files.output.publish import atomic_file
from fusion.report.explanations.claim_figures import Unit
from fusion.report.explanations.claims import claim_section, lead, parameters_table, questions
from fusion.report.explanations.evidence import claims_of
from fusion.report.explanations.lattice_claim import lattice_section
from fusion.report.explanations.missing_values import missing_of, missing_section
from fusion.report.explanations.noise_claim import noise_mask, noise_of, noise_section
from fusion.report.kit.page import Section
from fusion.sensor.words.in_words import plain


def with_masks(folder: Path, found: Explanation, verdict: dict[str, Any]) -> dict[str, Any]:
    """The verdict with a mask picture for each claim that has one, written into the folder."""
    missing = []
    for number, entry in enumerate(verdict["missing"]):
        mask = _mask(found, verdict, number)
        if mask is not None:
            name = f"mask_{number}.png"
            with atomic_file(Path(folder) / name) as partial:
                partial.write_bytes(cv2.imencode(".png", mask)[1].tobytes())
            entry = {**entry, "where": {**entry["where"], "mask": name}}
        missing.append(entry)
    return {**verdict, "missing": missing}


def claim_sections(found: Explanation, verdict: dict[str, Any], unit: Unit) -> list[Section]:
    """A section per established claim."""
    of_mean = {claim.number: claim for claim in claims_of(found, verdict)}
    sections = []
    for number, entry in enumerate(verdict["missing"]):
        if _is_lattice(found, entry):
            sections.append(lattice_section(found, number, entry))
        elif entry["channel"] == "bias" and number not in of_mean:  # grain, of which squares show nothing
            title = f"{'Also missing' if number else 'Missing'}: {plain(entry['effect'])}"
            sections.append(Section(title, lead(entry), (), html=parameters_table(entry) + questions(entry)))
        elif (mask := _mask(found, verdict, number)) is None:
            continue
        elif number in of_mean:
            sections.append(claim_section(found, of_mean[number], mask, unit))
        elif entry["channel"] == "noise":
            sections.append(noise_section(found, number, entry, noise_of(found), mask, unit))
        elif (missing := missing_of(found)) is not None:
            sections.append(missing_section(number, entry, missing))
    return sections


def _mask(found: Explanation, verdict: dict[str, Any], number: int) -> NDArray[np.uint8] | None:
    """(h, w) where the data tell of a claim; None where no picture shows it."""
    entry = verdict["missing"][number]
    claim = next((claim for claim in claims_of(found, verdict) if claim.number == number), None)
    if _is_lattice(found, entry):
        return None
    if claim is not None:
        return claim.mask(found)
    if entry["channel"] == "noise" and found.spread:
        return noise_mask(found, noise_of(found))
    if entry["channel"] == "dropout" and (missing := missing_of(found)) is not None:
        return missing.mask
    return None


def _is_lattice(found: Explanation, entry: dict[str, Any]) -> bool:
    """True for the steps in which depths are stored: they are seen in no tile."""
    steps = (step.effect for step in found.channels.of("bias") if step.effect is not None)
    return any(effect.lattice and effect.name == entry["effect"] for effect in steps)
