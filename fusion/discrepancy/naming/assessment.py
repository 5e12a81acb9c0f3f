"""Judged: the parts of a fit with intervals, replication, extrapolation and look-alikes."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.decisions import ALIKE, SURE
from fusion.discrepancy.inference.identifiability import ROOMY
from fusion.discrepancy.inference.tile_covariance import MeasuredTiles, pose_columns
from fusion.discrepancy.naming.effect_part import EffectPart
from fusion.discrepancy.naming.evidence import by_chance, inflation
from fusion.discrepancy.naming.heterogeneity import FORM, form_of
from fusion.discrepancy.naming.intervals import spreads_of
from fusion.discrepancy.naming.plain_pairs import like_two
from fusion.discrepancy.naming.refit import PartsFit, partial_residual, shapes_of
from fusion.discrepancy.naming.search.candidates import Candidate
from fusion.discrepancy.naming.search.score import scored
from fusion.discrepancy.naming.search.space import Aim, Space
from fusion.discrepancy.naming.search.step import NextPart, held_out_gain
from fusion.sensor.effect import Effect
from fusion.sensor.where import Bound, inside

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]


@dataclass(frozen=True)
class Step:
    """One effect, or one more wave of it, that was added."""

    candidate: Candidate  # the form
    effect: Effect  # with fitted parameters
    gain: float  # drop of the chi2, all others refitted
    held_out: float  # drop of the chi2 in recordings left out in turn
    probability: float  # that noise alone does this, over all names and regions
    alike: tuple[str, ...]  # names that this data cannot tell from it
    std: float  # of its size, as a share of it; of several waves of one effect together
    # weights, weights_std: (k,) of the atoms
    weights: Vector
    weights_std: Vector
    shapes_std: dict[str, float] = field(default_factory=dict)  # of the searched shapes, by name
    price: float = 0.0  # what its freedom costs, in units of the gain
    together: tuple[str, ...] = ()  # two names that this data cannot tell from it when both are there
    zero_of: tuple[str, ...] = ()  # those of `alike` that are there, and do the same where their zero lies elsewhere

    @property
    def footprint(self) -> Vector:
        """(n,) what it changes, in units of the covariance."""
        return np.asarray(self.candidate.white @ self.weights)


def judged(fit: PartsFit, candidates: Sequence[Candidate]) -> list[Step]:
    """Every part of a fit, the most telling first."""
    spreads = spreads_of(fit)
    steps = [_step(fit, k, candidates, spreads) for k in range(len(fit.parts))]
    return sorted(steps, key=lambda step: -step.held_out)


def judged_next(fit: PartsFit, found: NextPart, candidates: Sequence[Candidate]) -> Step:
    """A further part that is not added, as it would be judged beside the parts as they are."""
    part = found.part
    space, target = partial_residual(fit, None)
    seen = space.of(part.candidate.white)
    power = np.diag(np.linalg.pinv(seen.T @ seen + (np.eye(seen.shape[1]) * part.size**-2 if part.size else 0.0)))
    spread = np.sqrt(np.maximum(power, 0.0) * inflation(fit.white))
    length = max(float(np.linalg.norm(seen @ part.weights)), 1e-12)
    return Step(
        part.candidate,
        part.effect(fit.observations),
        found.gain,
        found.held_out,
        found.probability,
        _alike(fit, part, candidates, Aim(space, target), FORM),
        1.0 / length,
        part.weights,
        spread,
    )


def _step(fit: PartsFit, k: int, candidates: Sequence[Candidate], spreads: Vector) -> Step:
    part = fit.parts[k]
    space, target = partial_residual(fit, k)
    seen = space.of(part.candidate.white)
    own = scored(part.candidate, seen, target)
    fitted = seen @ part.weights
    names = len({c.name for c in candidates})
    zeros = tuple(_of_other_zeros(fit, part, Aim(space, fitted)))
    probability = by_chance(own, fitted, target, names)
    weights, shapes = fit.places[k]
    about = {
        name: float(part.candidate.form.fixed[name] * spread)
        for name, spread in zip(shapes_of(part), spreads[shapes], strict=True)
    }
    return Step(
        part.candidate,
        part.effect(fit.observations),
        own.gain,
        held_out_gain(part, MeasuredTiles(fit.observations, fit.covariance), seen, target, own.gain),
        probability,
        (*_alike(fit, part, candidates, Aim(space, target), form_of(fit, k)), *zeros),
        _std(fit, k, seen, spreads),
        part.weights,
        spreads[weights],
        about,
        own.gain - own.score if np.isfinite(own.score) else 0.0,
        _together(fit, part, candidates, space),
        zeros,
    )


def _std(fit: PartsFit, k: int, seen: Matrix, spreads: Vector) -> float:
    """Standard deviation of the size of part k, as a share of it.

    Waves of one effect may stand for each other, so that none of them has a size of its own: they have one together,
    that of what they change.

    Args:
        seen: (n, k) its columns beside the other parts.
    """
    part = fit.parts[k]
    waves = [i for i, other in enumerate(fit.parts) if other.name == part.name and not other.size]
    if len(waves) > 1 and k in waves:
        own = np.concatenate([np.arange(len(spreads))[place] for i in waves for place in fit.places[i]])
        cov = np.linalg.inv(fit.normal)
        scale = spreads[own] / np.sqrt(np.diag(cov)[own])
        changed = np.sum([fit.parts[i].footprint for i in waves], axis=0)
        along = fit.columns[:, own].T @ changed * scale
        return float(np.sqrt(along @ cov[np.ix_(own, own)] @ along) / max(float(changed @ changed), 1e-12))
    length = max(float(np.linalg.norm(seen @ part.weights)), 1e-12)
    if len(part.weights) > 2:
        return 1.0 / length
    return float(np.linalg.norm(spreads[fit.places[k][0]] * np.linalg.norm(seen, axis=0))) / length


def _alike(fit: PartsFit, part: EffectPart, candidates: Sequence[Candidate], aim: Aim, form: float) -> tuple[str, ...]:
    """Names that explain the recordings as well as a part does, beside the other parts.

    As well: no recording tells clearly which it is, or what the rival lacks is less than laws of a catalogue are off,
    of all and of what poses must make good. One that would have to be larger than it can be is no rival.

    Args:
        form: share of a part's gain that may be a matter of its form.
    """
    out: dict[str, None] = {}
    space, target = aim
    seen = space.of(part.candidate.white)
    fitted = seen @ part.weights
    power, own = float(fitted @ fitted), scored(part.candidate, seen, target).gain
    clear = SURE * inflation(target - fitted)
    share = _share(fit, part.candidate.where)
    most = part.candidate.columns.shape[1] + ROOMY
    taken = {other.name for other in (*fit.parts, part)}
    whole = _whole(fit, part, space)
    for other in candidates:
        if other.name in taken or other.name in out or other.columns.shape[1] > most:
            continue
        white = fit.covariance.whiten(other.columns * share[:, None]) if part.candidate.where else other.white
        rival = space.of(white)
        found = scored(other, rival, fitted)
        near = power - found.gain <= form * power
        as_well = scored(other, rival, target).gain > own - clear
        as_well = as_well or (near and _as_to_poses(fit, fitted, rival @ found.weights, form))
        can_be = np.isfinite(found.score) and not EffectPart(other, found.weights).at_bound(fit.observations)
        if as_well and can_be and _alike_everywhere(whole, other, space):
            out[other.name] = None
    return tuple(out)


def _of_other_zeros(fit: PartsFit, part: EffectPart, aim: Aim) -> Iterator[str]:
    """Names of other parts whose laws do what this one does where their zero lies elsewhere.

    Args:
        aim: what the part changes beside the others (n,), and the space of that.
    """
    length = float(np.linalg.norm(aim.target))
    for other in fit.parts:
        effect = other.effect(fit.observations)
        moved = [effect.other_zero(patch.view) for patch in fit.observations.patches]
        if other.name == part.name or moved[0] is None or any(one is None for one in moved):
            continue
        most = aim.space.of(fit.covariance.whiten(fit.observations.columns([moved[0]])))[:, 0]
        along = abs(float(most @ aim.target))
        if ALIKE * length * float(np.linalg.norm(most)) < along <= float(most @ most):
            yield other.name


def _as_to_poses(fit: PartsFit, fitted: Vector, rival: Vector, form: float) -> bool:
    """True where a rival asks of the poses, which were measured, what the part does, but for a share `form` of it."""
    poses = np.column_stack(pose_columns(fit.observations)).T
    asked, more = (float(np.sum((poses @ fit.covariance.pulled(one)) ** 2)) for one in (fitted, fitted - rival))
    return more <= max(SURE, form * asked)


def _together(fit: PartsFit, part: EffectPart, candidates: Sequence[Candidate], space: Space) -> tuple[str, ...]:
    """Two plain laws that are one look-alike of a part with a searched shape."""
    if not part.candidate.form.fixed or part.candidate.where or part.size:
        return ()
    taken = {other.name for other in (*fit.parts, part)}
    return tuple(c.name for c in like_two(fit, part, [c for c in candidates if c.name not in taken], space))


def _whole(fit: PartsFit, part: EffectPart, space: Space) -> Vector | None:
    """What the law of a part that is confined to a region would change everywhere; None for others and for maps."""
    form = part.candidate.form
    if not part.candidate.where or form.map:
        return None
    return space.of(fit.covariance.whiten(fit.observations.columns(form.instances()) @ part.weights))


def _alike_everywhere(whole: Vector | None, other: Candidate, space: Space) -> bool:
    """Within a region nearly everything is nearly constant: a look-alike is one of the law, not of the region."""
    if whole is None:
        return True
    found = scored(other, space.of(other.white), whole)
    return found.gain > (ALIKE * float(np.linalg.norm(whole))) ** 2


def _share(fit: PartsFit, where: tuple[Bound, ...]) -> Vector:
    """(n,) share of each tile that lies within bounds."""
    return np.concatenate(
        [
            patch.tiles.mean(np.broadcast_to(inside(where, patch.depth, patch.view), patch.depth.shape).astype(float))
            for patch in fit.observations.patches
        ]
    )
