"""Terms of an unknown law: one simple function, or its product with another; the search for the best of them."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from fusion.discrepancy.gauge import Gauge
from fusion.discrepancy.observations import Observations
from fusion.discrepancy.unknown.families import Shape, shapes_of

Vector = NDArray[np.float64]

BEST = 2  # shapes per variable and kind that are tried with others
IN_ALL = 14
FINAL = 24  # forms that are tried on recordings left out
EXACT = 6  # of these, that are computed pixel by pixel
ALIKE = 0.8  # of the gain: a finer wave that has it may be the better one once its period is right
NEARBY = (0.96, 0.98, 1.0, 1.02, 1.04)  # times the period that means of tiles give
SHORTEST = 0.75  # tiles: a tile's mean keeps a fifth of a wave of that length
FAINT = 1e-6
MORE = 0.08  # of the gain: what a further variable must bring, as a further term must


@dataclass(frozen=True)
class Term:
    """A product of simple functions of different variables, or one of them times a free line or parabola of another.

    Attributes:
        shapes: one or two.
        curve: the variable whose free polynomial multiplies them, or "".
        degree: of that polynomial.
        middle, half: of that variable's values.
    """

    shapes: tuple[Shape, ...]
    curve: str = ""
    degree: int = 1
    middle: float = 0.0
    half: float = 1.0

    @property
    def variables(self) -> tuple[str, ...]:
        names = [shape.variable for shape in self.shapes] + ([self.curve] if self.curve else [])
        return tuple(dict.fromkeys(names))

    def columns(self, at: Mapping[str, NDArray[np.floating]]) -> Vector:
        """(..., k) values where the variables have values at[name] (...), which broadcast."""
        out = self.shapes[0].columns(at[self.shapes[0].variable])
        for shape in self.shapes[1:]:
            out = _products(out, shape.columns(at[shape.variable]))
        if self.curve:
            x = (np.asarray(at[self.curve], float) - self.middle) / self.half
            out = _products(out, np.stack([x**power for power in range(self.degree + 1)], axis=-1))
        return out

    def text(self) -> str:
        parts = [shape.text() for shape in self.shapes]
        curve = ("a line", "a parabola")[self.degree - 1] + f" in {self.curve}"
        return " * ".join([*parts, curve] if self.curve else parts)


def best_term(
    white: Vector, at: Mapping[str, Vector], data: tuple[Observations, Gauge], exact: Callable[[Term], Vector]
) -> tuple[Term, Vector] | None:
    """The term that predicts recordings best from the others, and its whitened columns (n, k); None when none does.

    Args:
        white: (n,) what is to be explained.
        at: variables (n,).
        data: whose tiles, and how far they may be off.
        exact: columns (n, k) of a term from its values at the pixels, not from those at the means of tiles.
    """
    gauge, place = data[1], data[0].place
    singles = _scored([Term((shape,)) for name, x in at.items() for shape in shapes_of(name, x)], white, at, gauge)
    if not singles:
        return None
    kept = [_tuned(item, white, at, gauge) for item in _leading(singles)]
    tried = kept + _scored(list(_with_others(kept, at)), white, at, gauge)
    tried = sorted(tried, key=lambda item: -item[0])[:FINAL]
    # what differs from recording to recording follows any of their differences: only new recordings tell
    tried = sorted(tried, key=lambda item: -gain_elsewhere(item[2], white, place))
    plain = [item for item in tried[EXACT:] if len(item[1].variables) == 1]
    terms = [term for _, term, _ in (*tried[:EXACT], *plain[:1])]

    def at_pixels(term: Term) -> tuple[float, Term, Vector]:
        columns = gauge.whiten(_sized(exact(term)))
        return gain_elsewhere(columns, white, place), term, columns

    final = [at_pixels(term) for term in terms]
    final += _finer(terms[0], data[0].patches[0].tiles.side, at_pixels, max(gain for gain, _, _ in final))
    gains = [gain for gain, _, _ in final]
    best = final[_plainest([term for _, term, _ in final], gains)]
    return best[1:] if _score(best[2], white) > 0 and best[0] > 0 else None


def _finer(
    term: Term, side: int, at_pixels: Callable[[Term], tuple[float, Term, Vector]], gain: float
) -> list[tuple[float, Term, Vector]]:
    """Waves shorter than two tiles, which look alike in their means; only their pixels tell them apart.

    Those that do nearly as well as the wave of this term are taken with their period between those that were tried.
    """
    found, first = [], term.shapes[0]
    for finer in _aliases(term, side):
        if at_pixels(finer)[0] < ALIKE * gain:
            continue
        period = finer.shapes[0].number
        other = [replace(term, shapes=(first.tuned(period * part), *term.shapes[1:])) for part in NEARBY]
        found.append(max((at_pixels(one) for one in other), key=lambda item: item[0]))
    return found


def _aliases(term: Term, side: int) -> Iterator[Term]:
    """The same with a wave that is shorter than two tiles."""
    first = term.shapes[0]
    if first.kind == "wave" and first.variable in ("u", "v"):
        for waves in (1 / side - 1 / first.number, 1 / side + 1 / first.number):
            if waves * SHORTEST * side < 1:
                yield replace(term, shapes=(first.tuned(1 / waves), *term.shapes[1:]))


def _plainest(terms: Sequence[Term], gains: Sequence[float]) -> int:
    """The best of those with the fewest variables: a further one that brings little is no part of the law."""
    enough = [k for k, gain in enumerate(gains) if gain >= (1 - MORE) * max(gains)]
    return min(enough or range(len(gains)), key=lambda k: (len(terms[k].variables), -gains[k]))


def gain_elsewhere(columns: Vector, white: Vector, place: NDArray[np.intp], ridge: float = 1e-4) -> float:
    """Drop of the chi2 in each recording, with weights fitted to the others; of a single one, in four parts of it."""
    groups = place if len(np.unique(place)) > 1 else np.arange(len(place)) * 4 // max(len(place), 1)
    normal, moment, total = columns.T @ columns, columns.T @ white, 0.0
    damped = ridge * max(float(np.trace(normal)), FAINT) / max(len(normal), 1) * np.eye(len(normal))
    for g in np.unique(groups):
        own, w = columns[groups == g], white[groups == g]
        weights = np.linalg.solve(normal - own.T @ own + damped, moment - own.T @ w)
        total += float(w @ w - ((w - own @ weights) ** 2).sum())
    return total


def _leading(scored: Sequence[tuple[float, Term, Vector]]) -> list[tuple[float, Term, Vector]]:
    """The best, not too many of one kind."""
    kept: list[tuple[float, Term, Vector]] = []
    for item in sorted(scored, key=lambda item: -item[0]):
        own = item[1].shapes[0]
        same = [o for _, other, _ in kept if (o := other.shapes[0]).variable == own.variable and o.kind == own.kind]
        if len(same) < BEST:
            kept.append(item)
    return kept[:IN_ALL]


def _with_others(kept: Sequence[tuple[float, Term, Vector]], at: Mapping[str, Vector]) -> Iterator[Term]:
    """Products of the leading shapes with powers of the depth and the amplitude, and with lines."""
    for _, term, _ in kept:
        own = term.variables[0]
        for name, powers in (("depth", (1.0, 2.0, -1.0)), ("amplitude", (-1.0, -0.5))):
            if name in at and own not in (name, "range", "disparity")[: 3 if name == "depth" else 1]:
                known = [s for s in shapes_of(name, at[name]) if s.kind == "power" and s.number in powers]
                yield from (Term((*term.shapes, shape)) for shape in known)
        for name in ("u", "v", "depth", "time"):
            if name in at and name != own:
                low, high = float(np.min(at[name])), float(np.max(at[name]))
                for degree in (1, 2):
                    yield Term(term.shapes, name, degree, (low + high) / 2, (high - low) / 2)


def _scored(
    terms: Sequence[Term], white: Vector, at: Mapping[str, Vector], gauge: Gauge
) -> list[tuple[float, Term, Vector]]:
    """Score, term and whitened columns of each; whitened in one go."""
    if not terms:
        return []
    blocks = [_sized(term.columns(at)) for term in terms]
    ends = np.cumsum([block.shape[1] for block in blocks])
    parts = np.split(gauge.whiten(np.concatenate(blocks, axis=1)), ends[:-1], axis=1)
    return [(_score(part, white), term, part) for term, part in zip(terms, parts, strict=True)]


def _score(columns: Vector, white: Vector) -> float:
    left, values, _ = np.linalg.svd(columns, full_matrices=False)
    basis = left[:, values > FAINT * np.max(values, initial=1e-300)]
    return float(((basis.T @ white) ** 2).sum()) - basis.shape[1] * float(np.log(len(white)))


def _tuned(
    item: tuple[float, Term, Vector], white: Vector, at: Mapping[str, Vector], gauge: Gauge
) -> tuple[float, Term, Vector]:
    """With its period or time constant between those that were tried."""
    score, term, columns = item
    first = term.shapes[0]
    if not first.tunable:
        return item

    def other(number: float) -> Term:
        return replace(term, shapes=(first.tuned(number), *term.shapes[1:]))

    def loss(number: float) -> float:
        return -_scored([other(number)], white, at, gauge)[0][0]

    near = 0.12 if first.kind != "decay" else 0.6
    bounds = (first.number * (1 - near), first.number * (1 + near))
    found = minimize_scalar(loss, bounds=bounds, method="bounded", options={"maxiter": 9, "xatol": 2e-3 * bounds[0]})
    return _scored([other(float(found.x))], white, at, gauge)[0] if -found.fun > score else (score, term, columns)


def _sized(columns: Vector) -> Vector:
    return columns / np.maximum(np.abs(columns).max(axis=0), 1e-12)


def _products(a: Vector, b: Vector) -> Vector:
    a, b = a[..., :, None], b[..., None, :]
    out = a * b
    return np.asarray(out.reshape(*out.shape[:-2], -1))
