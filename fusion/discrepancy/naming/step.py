"""Step: the one effect that pays most for its columns now, with all that tells whether to believe it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar
from scipy.stats import chi2

from fusion.discrepancy.gauge import Gauge
from fusion.discrepancy.naming.candidates import Candidate, map_of
from fusion.discrepancy.observations import Observations
from fusion.sensor.effect import Effect
from fusion.sensor.parameter import parameters

Vector = NDArray[np.float64]

FALSE_ALARM = 1e-4  # of one step, over all names together
REPLICATED = 0.4  # of the gain that must show in recordings that took no part in the fit
ALIKE = 0.95  # cosine of two footprints above which this data cannot tell them apart


@dataclass(frozen=True)
class Step:
    """One effect, or one more wave of it, that was added.

    Attributes:
        candidate: the form that was best.
        effect: with fitted parameters.
        gain: drop of the chi2.
        held_out: drop of the chi2 in recordings left out in turn.
        probability: that noise alone does this, over all names.
        alike: names that this data cannot tell from it.
        std: of its size, as a share of it.
        weights, weights_std: (k,) of the atoms.
        white_before: (n,) what it had to explain, in units of the gauge.
    """

    candidate: Candidate
    effect: Effect
    gain: float
    held_out: float
    probability: float
    alike: tuple[str, ...]
    std: float
    weights: Vector
    weights_std: Vector
    white_before: Vector

    @property
    def established(self) -> bool:
        """True when chance is ruled out and recordings that took no part in the fit show it too."""
        return self.probability <= FALSE_ALARM and self.held_out >= REPLICATED * self.gain

    @property
    def footprint(self) -> Vector:
        """(n,) what it changes, in units of the gauge."""
        return np.asarray(self.candidate.white @ self.weights)


def best_step(candidates: Sequence[Candidate], observations: Observations, gauge: Gauge, white: Vector) -> Step | None:
    """The candidate that pays most for its columns, established or not; None when there is none at all."""
    scores = [_score(c, white) for c in candidates]
    if not scores:
        return None
    best = int(np.argmax(scores))
    chosen = _tuned(candidates[best], observations, gauge, white)
    weights = np.asarray(np.linalg.lstsq(chosen.white, white, rcond=None)[0], float)
    fitted = chosen.white @ weights
    gain, k = float(fitted @ white), chosen.basis.shape[1]
    inflated = max(1.0, _robust_variance(white - fitted))
    names = len({c.name for c in candidates})
    probability = float(min(1.0, names * chi2.sf(gain / inflated, k)))
    held_out = _held_out(chosen, observations, white)
    effect = map_of(observations, chosen.form, weights) if chosen.form.map else chosen.form.combined(list(weights))
    alike = _alike(chosen, fitted, candidates, white)
    std = float(np.sqrt(inflated / max(gain, 1e-9)))
    spread = np.asarray(np.sqrt(inflated * np.diag(np.linalg.pinv(chosen.white.T @ chosen.white))), float)
    return Step(chosen, effect, gain, held_out, probability, alike, std, weights, spread, white)


def _score(candidate: Candidate, white: Vector) -> float:
    basis = candidate.basis
    return float(((basis.T @ white) ** 2).sum()) - basis.shape[1] * float(np.log(len(white)))


def _tuned(candidate: Candidate, observations: Observations, gauge: Gauge, white: Vector) -> Candidate:
    """The candidate with its searched shape parameters between the values of the search."""
    about = parameters(candidate.form.kind)
    for name, value in candidate.form.fixed.items():
        values = sorted(about[name].search)
        if value not in values:
            continue
        place = values.index(value)
        low, high = values[max(place - 1, 0)], values[min(place + 1, len(values) - 1)]
        if not low < high or value <= 0:
            continue

        def loss(x: float, name: str = name, start: Candidate = candidate) -> float:
            return -_score(_with(start, name, x, observations, gauge), white)

        found = minimize_scalar(
            loss, bounds=(low, high), method="bounded", options={"xatol": 1e-4 * value, "maxiter": 12}
        )
        if -found.fun > _score(candidate, white):
            candidate = _with(candidate, name, float(found.x), observations, gauge)
    return candidate


def _with(candidate: Candidate, name: str, value: float, observations: Observations, gauge: Gauge) -> Candidate:
    form = replace(candidate.form, fixed={**candidate.form.fixed, name: value})
    columns = observations.columns(form.instances())
    return Candidate(form, columns, gauge.whiten(columns))


def _held_out(candidate: Candidate, observations: Observations, white: Vector) -> float:
    """Drop of the chi2 in each recording, with weights fitted to the others."""
    place, total = observations.place, 0.0
    A = candidate.white
    normal, moment = A.T @ A, A.T @ white
    ridge = 1e-9 * np.trace(normal) / len(normal) * np.eye(len(normal))
    for g in np.unique(place):
        rows = place == g
        weights = np.linalg.solve(normal - A[rows].T @ A[rows] + ridge, moment - A[rows].T @ white[rows])
        total += float(white[rows] @ white[rows] - ((white[rows] - A[rows] @ weights) ** 2).sum())
    return total


def _alike(chosen: Candidate, fitted: Vector, candidates: Sequence[Candidate], white: Vector) -> tuple[str, ...]:
    """Names whose own fit to the same residual points the same way."""
    out: dict[str, None] = {}
    length = np.linalg.norm(fitted)
    for other in candidates:
        if other.name == chosen.name or other.basis.shape[1] > chosen.basis.shape[1] + 6:
            continue
        own = other.basis @ (other.basis.T @ white)
        if own @ fitted > ALIKE * length * max(float(np.linalg.norm(own)), 1e-12):
            out[other.name] = None
    return tuple(out)


def _robust_variance(white: Vector) -> float:
    return float((np.median(np.abs(white)) / 0.6745) ** 2)
