"""A row: what was recorded, what was said of it once, and how such recordings are made."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tools.trial.spoiled.bases import Base
from tools.trial.spoiled.case import Spoiled, Told
from tools.trial.spoiled.running import Run

Rng = np.random.Generator
Makes = Callable[[int, Rng, Path], tuple[Base, Spoiled]]

NOTHING = Told("^Nothing is missing")  # where nothing is wrong, or what is has a name


@dataclass(frozen=True)
class Row:
    """Attributes:
    name: of the recordings, in words.
    was: what was said when it was seen first.
    make: the case of a variant (0, 1, ...), drawn with random numbers and written to a folder that is not there yet.
    large: images of 640 x 480, minutes each: only when asked for.
    """

    name: str
    was: str
    make: Makes
    large: bool = False


def verdict_on(run: Run) -> str:
    """ "right"; "told" (in the headline alone, not by a name); "silent" (nothing false, and not the truth); "WRONG"."""
    score = run.score
    if score.outcome in ("WRONG", "failed"):
        return "WRONG"
    if score.outcome in ("right", "set", "refused") and score.told is not False:
        return "right"
    return "told" if score.told else "silent"
