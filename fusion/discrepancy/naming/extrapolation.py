"""Extrapolation: does a fit hold in the farthest and the steepest recording, which take no part in it?"""

import numpy as np

from fusion.discrepancy.naming.evidence import left_out_gain
from fusion.discrepancy.naming.partial_residual import partial_residual
from fusion.discrepancy.naming.refit import PartsFit
from fusion.discrepancy.observe.observations import Observations

FEWEST = 6  # recordings from which on some can be held back
TOLD = 10.0  # growth of a variance without the recordings held back: beyond, the others do not tell the size


def gains_beyond(fit: PartsFit) -> dict[int, float]:
    """Per part, the drop of the chi2 in the recordings held back; none of parts whose size the others do not tell."""
    places = held_back(fit.observations)
    if not places or not fit.parts:
        return {}
    rows = np.isin(fit.observations.place, places)
    own, out = fit.columns[rows], {}
    without = np.diag(np.linalg.pinv(fit.normal - own.T @ own, hermitian=True))
    growth = without / np.maximum(np.diag(np.linalg.inv(fit.normal)), 1e-300)
    for k, (part, (weights, _)) in enumerate(zip(fit.parts, fit.places, strict=True)):
        # what is known of an effect that the model holds couples all recordings
        if np.median(growth[weights]) < TOLD and fit.observations.sensor.effect(part.name) is None:
            space, target = partial_residual(fit, k)
            out[k] = left_out_gain(space.of(part.candidate.white), target, np.where(rows, 0, -1), part.size)
    return out


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
