"""Refit: all named parts together, shapes included, predicted through the sensor itself and not by columns."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.inference.tile_covariance import TileCovariance
from fusion.discrepancy.naming.effect_part import EffectPart, model_of
from fusion.discrepancy.naming.search.candidates import candidate_of
from fusion.discrepancy.naming.search.space import Aim, space_beside
from fusion.discrepancy.observe.observations import Observations
from fusion.sensor.parameter import parameters
from fusion.sensor.sensor import Sensor

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

STEPS = 6
ENOUGH = 0.3  # drop of the chi2 below which nothing is gained by going on
LARGEST = 0.3  # change of the logarithm of a shape in one step
PROMISED = 4.0  # times the drop of the chi2 that a linear step foresees: as far as shapes may bring it beyond
STEP = 1e-3  # of a shape, for its derivative
RIDGE = 1e-10  # of a column's power: directions that nothing tells stay where they are


@dataclass(frozen=True)
class PartsFit:
    """Parts as fitted together."""

    observations: Observations  # under the given model; they say which tiles there are
    covariance: TileCovariance  # their units
    parts: tuple[EffectPart, ...]  # with fitted weights and shapes
    sensor: Sensor  # the given model with them
    white: Vector  # (n,) what it leaves, whitened
    columns: Matrix  # (n, p) change per weight, then per logarithm of a shape, part by part
    prior: Vector  # (p,) one over the square of the usual size of a field's weights; 0 for all that is free
    places: tuple[tuple[slice, slice], ...]  # for each part, where its weights and its shapes stand among the columns

    @property
    def normal(self) -> Matrix:
        """(p, p) information of all that was fitted."""
        power = (self.columns**2).sum(axis=0)
        return np.asarray(self.columns.T @ self.columns + np.diag(self.prior + RIDGE * np.maximum(power, 1e-300)))


def partial_residual(fit: PartsFit, k: int | None, held: bool = False) -> Aim:
    """What stays to be explained beside the parts (without part k), and the residual there (with part k's share).

    Args:
        held: shapes of the parts stay as they are; else they may give way, as far as they are linear.
    """
    rest = [i for i in range(len(fit.parts)) if i != k]
    shapes = [np.zeros((len(fit.white), 0)) if held else fit.columns[:, fit.places[i][1]] for i in rest]
    space = space_beside([fit.parts[i] for i in rest], shapes, len(fit.white))
    residual = fit.white if k is None else fit.white + fit.parts[k].footprint
    return Aim(space, np.asarray(space.of(residual)))


def refitted(
    parts: Sequence[EffectPart], observations: Observations, covariance: TileCovariance, most: float = np.inf
) -> PartsFit:
    """Least squares over all weights and shapes, step by step, each step judged by the sensor's own prediction.

    Args:
        most: cost above which the fit is of no use: it ends where nothing says that it comes so far.
    """
    fit = _fit(tuple(parts), observations, covariance)
    fit = _weighed(fit) if len(parts) > 1 else fit
    for _ in range(STEPS if parts else 0):
        weights = np.concatenate([np.append(p.weights, np.zeros(len(shapes_of(p)))) for p in fit.parts])
        slope = fit.columns.T @ fit.white - fit.prior * weights
        change = np.linalg.solve(fit.normal, slope)
        if _cost(fit) - PROMISED * float(change @ slope) > most:
            break
        better = _along(fit, change)
        if better is None:
            break
        gained = _cost(fit) - _cost(better)
        fit = _resized(better)
        if gained < ENOUGH:
            break
    return fit


def _weighed(fit: PartsFit) -> PartsFit:
    """The fit with the best weights for its shapes: a new part was weighed beside others that could still move."""
    own = np.concatenate([np.arange(len(fit.prior))[place] for place, _ in fit.places])
    weights, slope = np.zeros(len(fit.prior)), fit.columns.T @ fit.white
    weights[own] = np.concatenate([part.weights for part in fit.parts])
    change = np.zeros(len(fit.prior))
    change[own] = np.linalg.solve(fit.normal[np.ix_(own, own)], (slope - fit.prior * weights)[own])
    return _along(fit, change) or fit


def shapes_of(part: EffectPart) -> list[str]:
    """Names of the searched or released shapes of a part that are numbers above 0."""
    form = part.candidate.form
    about = parameters(form.kind)
    used = {about[name].group for atom in form.atoms for name in atom}
    free = {name for name in form.fixed if about[name].search or about[name].release}
    return [name for name, value in form.fixed.items() if name in free and value > 0 and about[name].group in used]


def _fit(parts: tuple[EffectPart, ...], observations: Observations, covariance: TileCovariance) -> PartsFit:
    sensor = model_of(observations, parts)
    white = covariance.whiten(observations.under(sensor).residual)
    blocks: list[Matrix] = [np.zeros((len(white), 0))]
    prior: list[Vector] = [np.zeros(0)]
    places, start = [], 0
    for part in parts:
        own = part.candidate.white
        shapes = _shape_columns(part, observations, covariance)
        middle, end = start + own.shape[1], start + own.shape[1] + shapes.shape[1]
        places.append((slice(start, middle), slice(middle, end)))
        start = end
        blocks += [own, shapes]
        prior.append(np.full(own.shape[1], part.size**-2 if part.size else 0.0))
        prior.append(np.zeros(shapes.shape[1]))
    return PartsFit(
        observations,
        covariance,
        parts,
        sensor,
        white,
        np.concatenate(blocks, axis=1),
        np.concatenate(prior),
        tuple(places),
    )


def _shape_columns(part: EffectPart, observations: Observations, covariance: TileCovariance) -> Matrix:
    """(n, s) change of the tiles, whitened, per logarithm of each shape."""
    out = []
    for name in shapes_of(part):
        ends = [_shaped(part, {name: sign * STEP}, observations, covariance).footprint for sign in (1, -1)]
        out.append((ends[0] - ends[1]) / (2 * STEP))
    return np.column_stack(out) if out else np.zeros((len(observations.residual), 0))


def _shaped(
    part: EffectPart, change: dict[str, float], observations: Observations, covariance: TileCovariance
) -> EffectPart:
    """A part whose shapes differ by factors exp(change), within their bounds."""
    form = part.candidate.form
    about = parameters(form.kind)
    fixed = dict(form.fixed)
    for name, step in change.items():
        fixed[name] = float(np.clip(fixed[name] * np.exp(step), about[name].low, about[name].high))
    candidate = candidate_of(observations, covariance, replace(form, fixed=fixed), part.candidate.where)
    return replace(part, candidate=candidate)


def _along(fit: PartsFit, change: Vector) -> PartsFit | None:
    """The fit moved by a change of all parameters, or by less; None where that does not help."""
    for share in (1.0, 0.4, 0.1):
        parts = []
        for part, (own, shapes) in zip(fit.parts, fit.places, strict=True):
            moved = replace(part, weights=part.weights + share * change[own])
            steps = np.clip(share * change[shapes], -LARGEST, LARGEST)
            names = shapes_of(part)
            if names:
                moved = _shaped(moved, dict(zip(names, steps.tolist(), strict=True)), fit.observations, fit.covariance)
            parts.append(moved)
        better = _fit(tuple(parts), fit.observations, fit.covariance)
        if _cost(better) <= _cost(fit):
            return better
    return None


def _resized(fit: PartsFit) -> PartsFit:
    """The usual size of a field's weights, from the weights as they are and from what is open about them."""
    if not np.any(fit.prior):
        return fit
    spread = np.diag(np.linalg.pinv(fit.normal, hermitian=True))  # a shape that changes nothing has no spread
    parts, prior = [], fit.prior.copy()
    for part, (own, _) in zip(fit.parts, fit.places, strict=True):
        if part.size:
            size = float(np.sqrt(np.mean(part.weights**2 + spread[own])))
            part = replace(part, size=size)
            prior[own] = size**-2
        parts.append(part)
    return replace(fit, parts=tuple(parts), prior=prior)


def _cost(fit: PartsFit) -> float:
    field = sum(float((part.weights**2).sum()) / part.size**2 for part in fit.parts if part.size)
    return float(fit.white @ fit.white) + field
