"""Edges of regions: after each acceptance, moved to where they explain most beside what was found since."""

from fusion.discrepancy.inference.tile_covariance import MeasuredTiles
from fusion.discrepancy.naming.effect_part import EffectPart
from fusion.discrepancy.naming.partial_residual import partial_residual
from fusion.discrepancy.naming.refit import PartsFit, refitted
from fusion.discrepancy.naming.search.bounds import tweaked
from fusion.discrepancy.naming.search.region import region_variables
from fusion.discrepancy.naming.search.score import scored


def at_best_edges(fit: PartsFit) -> PartsFit:
    """The fit whose regions end where they explain most beside the other parts."""
    if not any(part.candidate.where for part in fit.parts):
        return fit
    values = region_variables(fit.observations)
    for k, part in enumerate(fit.parts):
        if not part.candidate.where or part.size:
            continue
        bound, aim = part.candidate.where[0], partial_residual(fit, k)
        measured = MeasuredTiles(fit.observations, fit.covariance)
        moved = tweaked(part.candidate, bound, values[bound.variable], measured, aim)
        weights = scored(moved, aim.space.of(moved.white), aim.target).weights
        better = refitted(
            [*fit.parts[:k], EffectPart(moved, weights), *fit.parts[k + 1 :]], fit.observations, fit.covariance
        )
        if better.white @ better.white < fit.white @ fit.white:
            fit = better
    return fit
