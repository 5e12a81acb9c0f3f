"""Extrapolation: does a fit hold in the farthest and the steepest recording, which take no part in it?"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.naming.evidence import left_out_gain
from fusion.discrepancy.naming.partial_residual import partial_residual
from fusion.discrepancy.naming.refit import PartsFit
from fusion.discrepancy.observe.observations import Observations

Vector = NDArray[np.float64]

FEWEST = 6  # recordings from which on some can be held back
TOLD = 10.0  # growth of a variance without the recordings held back: beyond, the others do not tell the size


@dataclass(frozen=True)
class Extrapolation:
    """Recordings held back, and how they are predicted by all others."""

    places: tuple[int, ...] = ()  # of the recordings; empty where there are too few to hold any back
    before: float = float("nan")  # chi2 per tile of the given model there
    after: float = float("nan")  # the same of the parts as fitted to all other recordings
    # per part, the drop of the chi2 there; None where the others do not tell the part's size
    gains: tuple[float | None, ...] = ()


def held_back(observations: Observations) -> tuple[int, ...]:
    """The farthest and the steepest recording: chosen by the scene, before any residual is looked at."""
    depth: dict[int, list[float]] = {}
    tilt: dict[int, list[float]] = {}
    for patch in observations.patches:
        if len(patch.tiles):
            place = patch.block.place
            depth.setdefault(place, []).append(float(np.median(patch.tiles.mean(patch.depth))))
            angle = 0.0 if patch.view.incidence is None else float(np.median(patch.tiles.mean(patch.view.incidence)))
            tilt.setdefault(place, []).append(angle)
    if len(depth) < FEWEST:
        return ()
    farthest = max(depth, key=lambda place: float(np.mean(depth[place])))
    steepest = max(tilt, key=lambda place: float(np.mean(tilt[place])))
    return tuple(sorted({farthest, steepest}))


def extrapolated(fit: PartsFit) -> Extrapolation:
    """How the fit to all other recordings predicts those held back."""
    places = held_back(fit.observations)
    if not places or not fit.parts:
        return Extrapolation(places)
    rows = np.isin(fit.observations.place, places)
    white = fit.covariance.whiten(fit.observations.residual)[rows]
    J, rest = fit.columns[rows], fit.white[rows]
    normal = fit.normal
    without = np.linalg.pinv(normal - J.T @ J, hermitian=True)
    after = rest + J @ (without @ (J.T @ rest))
    growth = np.diag(without) / np.maximum(np.diag(np.linalg.inv(normal)), 1e-300)
    gains: list[float | None] = []
    for k, (own, _) in enumerate(fit.places):
        # what is known of an effect that the model holds couples all recordings
        held = fit.observations.sensor.effect(fit.parts[k].name) is not None
        told = bool(np.median(growth[own]) < TOLD) and not held
        gains.append(_gain(fit, k, rows) if told else None)
    return Extrapolation(places, float(white @ white / len(white)), float(after @ after / len(after)), tuple(gains))


def _gain(fit: PartsFit, k: int, rows: NDArray[np.bool_]) -> float:
    space, target = partial_residual(fit, k)
    part = fit.parts[k]
    group = np.where(rows, 0, -1)
    return left_out_gain(space.of(part.candidate.white), target, group, part.size)
