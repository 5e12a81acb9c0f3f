"""Region: candidates that act only where one variable is within bounds; every choice of bounds is paid for."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.decisions import DETECTED, SECOND_CAUSE
from fusion.discrepancy.inference.tile_covariance import MeasuredTiles, TileCovariance
from fusion.discrepancy.naming.effect_part import is_field
from fusion.discrepancy.naming.evidence import inflation
from fusion.discrepancy.naming.search.bounds import tweaked
from fusion.discrepancy.naming.search.candidates import Candidate
from fusion.discrepancy.naming.search.score import Scored, scored
from fusion.discrepancy.naming.search.space import Aim, Space
from fusion.discrepancy.observe.observations import Observations
from fusion.sensor.where import Bound

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

# what regions are cut along; others follow one of them too closely
ALONG = ("depth", "u", "v", "radius", "incidence", "amplitude", "reflectance", "time", "temperature")
OF_TIME = ("time", "temperature")
BINS = 20
LEAST_SHARE = 0.08  # of the tiles, inside and outside
FAINT = 0.35  # of the size inside: outside a region the effect must be below
LOOKS = 4  # names and variables whose edges are searched finely
NEAR = 0.8  # of the best score: less is not looked at again


@dataclass(frozen=True)
class Regional:
    """The best candidate that is confined to a region."""

    # candidate, scored: it, and what it brings; the score has paid for the region
    candidate: Candidate
    scored: Scored
    tried: int  # number of regions among which it was chosen


@dataclass(frozen=True)
class _Cut:
    """One variable cut into bins: the tiles in order, where each bin starts, and the values between bins."""

    variable: str
    order: NDArray[np.intp]
    starts: NDArray[np.intp]
    edges: Vector


def best_region(
    candidates: Sequence[tuple[Candidate, Vector]],
    observations: Observations,
    covariance: TileCovariance,
    space: Space,
    target: Vector,
) -> Regional | None:
    """The region in which one of the candidates explains most of a target (n,) in a space.

    Args:
        candidates: each with the weights that it has when it acts everywhere.
    """
    if not candidates:
        return None
    n = len(target)
    metric, pull = _metric(covariance, space), covariance.pulled(space.of(target))
    cuts = list(_cuts(observations))
    tried = sum(len(cut.starts) * (len(cut.starts) + 1) // 2 - 1 for cut in cuts)
    best: dict[tuple[bool, str, str], tuple[float, Candidate, Bound]] = {}
    probes = [(candidate, _probe(candidate, weights)) for candidate, weights in candidates]
    every = np.concatenate([columns for _, columns in probes], axis=1)
    ends = np.cumsum([columns.shape[1] for _, columns in probes])
    for cut in cuts:
        seen = _binned(every, metric, cut)
        for (candidate, columns), rows in zip(probes, np.split(seen, ends[:-1]), strict=True):
            found = _interval(columns[cut.order], rows, pull[cut.order], cut)
            key = is_field(candidate), candidate.name, cut.variable
            if found is not None and (key not in best or found[0] > best[key][0]):
                best[key] = found[0], candidate, found[1]
    measured, results, values = MeasuredTiles(observations, covariance), [], region_variables(observations)
    for candidate, bound in _worth_a_look(best):
        chosen = tweaked(candidate, bound, values[bound.variable], measured, Aim(space, target))
        result = scored(chosen, space.of(chosen.white), target)
        paid = _price(chosen.where[0], n) + 2 * float(np.log(max(tried, 1))) + second_cause(chosen)
        results.append(Regional(chosen, replace(result, score=result.score - paid), tried))
    return max(results, key=lambda one: one.scored.score, default=None)


def second_cause(candidate: Candidate) -> float:
    """What a region costs beside its edges: where nothing changes that the law depends on, another cause ends it."""
    bound = candidate.where[0].variable
    own = set(OF_TIME) if bound in OF_TIME else {bound}
    return 0.0 if own & set(candidate.form.kind.variables) else SECOND_CAUSE


def _metric(covariance: TileCovariance, space: Space) -> NDArray[np.float32]:
    """(n, n) products of tiles in a space; single precision is plenty for a choice."""
    damped = covariance.pulled(space.directions) * np.sqrt(1 - space.kept**2)
    return np.asarray(covariance.inverse - damped @ damped.T, np.float32)


def _worth_a_look(
    best: dict[tuple[bool, str, str], tuple[float, Candidate, Bound]],
) -> list[tuple[Candidate, Bound]]:
    """Regions whose edges are worth a finer search: bins are coarse, so the best few, and one of a field."""
    out = []
    for field, most in ((False, LOOKS), (True, 1)):
        ranked = sorted((value for key, value in best.items() if key[0] == field), key=lambda value: -value[0])
        out += [(c, bound) for score, c, bound in ranked[:most] if score > NEAR * ranked[0][0]]
    return out


def _probe(candidate: Candidate, weights: Vector) -> Matrix:
    """Columns (n, k) for the search: one or two as they are, more of them in the proportion that fits the whole."""
    return candidate.columns if candidate.columns.shape[1] <= 2 else np.asarray(candidate.columns @ weights)[:, None]


def confined(regional: Candidate, whole: Candidate, space: Space, target: Vector) -> bool:
    """True when outside its region the effect is much smaller than inside, and what is outside tells so.

    Sizes inside and outside are fitted together: a region that leaves out next to nothing contradicts no whole.
    """
    inside = scored(regional, space.of(regional.white), target).weights
    pair = space.of(np.column_stack([regional.white @ inside, (whole.white - regional.white) @ inside]))
    sizes = np.linalg.lstsq(pair, target, rcond=None)[0]
    apart, both = target - pair @ sizes, pair.sum(axis=1)
    alike = target - both * (both @ target / max(float(both @ both), 1e-300))
    told = float(alike @ alike - apart @ apart)  # chi2 that one size for both leaves
    return bool(abs(sizes[1]) < FAINT * abs(sizes[0]) and told > DETECTED**2 * inflation(apart))


def region_variables(observations: Observations) -> dict[str, Vector]:
    """Tile means (n,) of what regions are cut along, in the units of verdicts."""
    return {name: observations.variables[name] for name in ALONG if name in observations.variables}


def _edges(name: str, values: Vector, side: int) -> Vector:
    """Where bins start: at the squares of the image, at all values of a few, or at quantiles."""
    if name in ("u", "v"):
        return np.arange(np.floor(np.min(values) / side) * side, np.max(values), side)
    known = np.unique(np.round(values, 9))
    return known if len(known) <= BINS else np.unique(np.quantile(values, np.linspace(0, 1, BINS + 1)[:-1]))


def _cuts(observations: Observations) -> Iterator[_Cut]:
    side = max(patch.tiles.side for patch in observations.patches)
    for name, values in region_variables(observations).items():
        edges = _edges(name, values, side)
        if len(edges) < 2:
            continue
        number = np.maximum(np.searchsorted(edges, values + 1e-9, side="right") - 1, 0)
        order = np.argsort(number, kind="stable")
        starts = np.searchsorted(number[order], np.arange(len(edges)))
        filled = np.diff(np.append(starts, len(values))) > 0
        yield _Cut(name, order, starts[filled], edges[filled])


def _binned(columns: Matrix, metric: NDArray[np.float32], cut: _Cut) -> NDArray[np.float32]:
    """(k, bins, n) products of each bin of columns (n, k) with all tiles, these in the order of the cut."""
    bins = np.split(cut.order, cut.starts[1:])
    return np.stack([columns[own].T.astype(np.float32) @ metric[own] for own in bins], axis=1)[..., cut.order]


def _interval(columns: Matrix, rows: NDArray[np.float32], pull: Vector, cut: _Cut) -> tuple[float, Bound] | None:
    """Gain of the best run of bins for columns (n, k), k of 1 or 2, and its bounds; `rows` are their products."""
    k, n = columns.shape[1], len(pull)
    moments = [_runs1(np.add.reduceat(columns[:, a] * pull, cut.starts)) for a in range(k)]
    powers = {
        (a, b): _runs2(np.add.reduceat(rows[a] * columns[:, b], cut.starts, axis=1))
        for a in range(k)
        for b in range(a, k)
    }
    with np.errstate(all="ignore"):
        if k == 1:
            gain = moments[0] ** 2 / powers[0, 0]
        else:
            p, q, r = powers[0, 0], powers[0, 1], powers[1, 1]
            gain = (r * moments[0] ** 2 - 2 * q * moments[0] * moments[1] + p * moments[1] ** 2) / (p * r - q * q)
    counts = _runs1(np.diff(np.append(cut.starts, n)).astype(float)) / n
    low, high = np.indices(gain.shape)
    price = ((low > 0).astype(float) + (high < len(cut.starts))) * np.log(n)
    allowed = (high > low) & (counts > LEAST_SHARE) & (counts < 1 - LEAST_SHARE) & np.isfinite(gain)
    score = np.where(allowed, gain - price, -np.inf)
    i, j = np.unravel_index(int(np.argmax(score)), score.shape)
    if not np.isfinite(score[i, j]):
        return None
    first = float(cut.edges[i]) if i > 0 else -np.inf
    last = float(cut.edges[j]) if j < len(cut.starts) else np.inf
    return float(score[i, j]), Bound(cut.variable, first, np.nextafter(last, -np.inf) if np.isfinite(last) else last)


def _runs1(values: Vector) -> Matrix:
    """[i, j] = sum of the values from i to j - 1."""
    total = np.concatenate([[0.0], np.cumsum(values)])
    return np.asarray(total[None, :] - total[:, None])


def _runs2(values: Matrix) -> Matrix:
    """[i, j] = sum of the square of values from i to j - 1 in both directions."""
    total = np.pad(values.cumsum(axis=0).cumsum(axis=1), ((1, 0), (1, 0)))
    own = np.diag(total)
    return np.asarray(own[None, :] + own[:, None] - total - total.T)


def _price(bound: Bound, n: int) -> float:
    return float((np.isfinite(bound.low) + np.isfinite(bound.high)) * np.log(n))
