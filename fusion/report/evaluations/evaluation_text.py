"""Sentences of the evaluation's report."""

from collections.abc import Sequence

import numpy as np

from fusion.evaluation.quantization import Quantization
from fusion.evaluation.still.statistics import Still


def headline(what: str, still: Sequence[Still]) -> str:
    """The noise of the depth from the image's centre to where it is worst."""
    known = [s.depth.std[np.isfinite(s.depth.std)] for s in still]
    all_known = np.concatenate(known) if known else np.zeros(0)
    if not all_known.size:
        return f"Mean {what} of every pixel"
    low, high = np.percentile(all_known, [10, 90]) * 1e3
    return f"Noise of the {what}: {low:.1f} to {high:.1f} mm for the middle 80 % of the pixels"


def step_sentence(found: Quantization) -> str:
    """Which law of the quantisation holds, and how sure that is."""
    low, high = (1e3 * x for x in found.interval)
    if found.law == "file":
        return f"No steps of the sensor's own are seen above one count of the file ({found.unit * 1e3:.3g} mm)"
    if found.law == "z^2":
        law = f"grow with the square of the distance: {found.value * 1e3:.3f} mm z^2 (90 %: {low:.3f} to {high:.3f})"
        return f"The steps {law}, exponent {found.exponent:.2f} +- {found.exponent_std:.2f}: triangulation"
    if found.law == "constant":
        return f"The steps are constant: {found.value * 1e3:.3f} mm (90 %: {low:.3f} to {high:.3f})"
    return f"Steps of {low:.2f} to {high:.2f} mm; the law cannot be told from this range of distances"
