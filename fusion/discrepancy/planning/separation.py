"""Separation: by how many standard deviations a further recording would part two explanations of the same data."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.naming.search.candidates import Candidate
from fusion.discrepancy.planning.menu import Choice
from fusion.discrepancy.planning.planned import Planned
from fusion.sensor.effect import Effect

Vector = NDArray[np.float64]

CLEAR = 6.0  # standard deviations from which on a recording parts them
PARTED = 0.9  # cosine below which two footprints are told apart, with room to the 0.95 from which they are alike


@dataclass(frozen=True)
class Claimed:
    """An effect as it was found, and its footprint (n,) in the data at hand, in units of the covariance."""

    effect: Effect
    footprint: Vector


@dataclass(frozen=True)
class Parting:
    """How far two explanations stand apart, a further recording included."""

    sigma: float  # standard deviations that the recording adds
    cosine: float  # between the claim's footprint and the nearest that the rival can make of it, in all data together

    @property
    def clear(self) -> bool:
        return self.sigma >= CLEAR and self.cosine < PARTED


@dataclass(frozen=True)
class Proposal:
    """A recording to make, and by how many standard deviations it is expected to part the names, or to show one."""

    choice: Choice
    sigma: float


def parting(claimed: Claimed, rivals: Iterable[Candidate], plan: Planned) -> Parting:
    """The nearest that any rival form can come to a claim, whatever its size, in old and planned data together.

    min over rivals and their sizes of |footprint of the claim - footprint of the rival|, in standard deviations.
    """
    old = claimed.footprint
    target = np.concatenate([old, plan.covariance.whiten(_column(plan, claimed.effect))])
    length = max(float(np.linalg.norm(target)), 1e-300)
    nearest = Parting(length, 0.0)
    for rival in rivals:
        columns = plan.columns(rival.form.instances())
        left = _left(np.concatenate([rival.white, plan.covariance.whiten(columns)]), target)
        added = np.sqrt(max(left**2 - _left(rival.white, old) ** 2, 0.0))
        cosine = float(np.sqrt(max(1.0 - (left / length) ** 2, 0.0)))
        if cosine > nearest.cosine:
            nearest = Parting(float(added), cosine)
    return nearest


def _left(columns: Vector, target: Vector) -> float:
    """Length of what columns cannot follow."""
    sizes = np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
    follow = (columns / sizes) @ np.linalg.lstsq(columns / sizes, target, rcond=1e-9)[0]
    return float(np.linalg.norm(target - follow))


def visible_in(plan: Planned, effect: Effect) -> float:
    """Length of an effect's footprint in a planned recording, in standard deviations."""
    return float(np.linalg.norm(plan.covariance.whiten(_column(plan, effect))))


def best(partings: Sequence[tuple[Choice, Parting]]) -> Proposal | None:
    """Of the recordings that part clearly a switch, then the quickest; else the one that parts best, if any does."""
    clear = [(choice, parting) for choice, parting in partings if parting.clear]
    if clear:
        choice, parting = min(clear, key=lambda item: (not item[0].switch, item[0].minutes, -item[1].sigma))
        return Proposal(choice, parting.sigma)
    some = [(choice, parting) for choice, parting in partings if parting.sigma >= CLEAR / 2]
    if not some:
        return None
    choice, parting = min(some, key=lambda item: item[1].cosine)
    return Proposal(choice, parting.sigma)


def _column(plan: Planned, effect: Effect) -> Vector:
    return plan.columns([effect])[:, 0]
