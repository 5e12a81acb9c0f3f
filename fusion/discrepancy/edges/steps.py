"""The edge channel: which effect makes of a depth edge what was recorded there?"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc, logsumexp

from fusion.discrepancy.channels.channel_step import ChannelStep
from fusion.discrepancy.channels.noise_parameters import USUAL, with_value
from fusion.discrepancy.decisions import CONFIDENCE, FALSE_ALARM, LARGEST_SET, REPLICATED, SURE, TYPICAL
from fusion.discrepancy.edges.places import EdgeFit, EdgePlaces
from fusion.discrepancy.edges.rims import acts_at_edges, rims_of
from fusion.discrepancy.observe.observations import Observations
from fusion.discrepancy.observe.patch import Patch
from fusion.discrepancy.observe.placements import views_of
from fusion.sensor.effect import Effect
from fusion.sensor.effects import EFFECTS
from fusion.sensor.parameter import Parameter, parameters
from fusion.sensor.sensor import Sensor

Vector = NDArray[np.float64]

SIZES = np.geomspace(1 / 8, 8, 13)  # of a typical size, that are tried
MOST_STEPS = 2
MOST_SHAKEN_PX = 0.5  # from frame to frame: beyond, mean and scatter of a pixel are of no place
CONTRAST = 4.0  # of the light across an edge: paint makes that, and no distance (guess)
ONE = 0.8  # of all gain, that one placement may bring


@dataclass(frozen=True)
class EdgeForm:
    """One number of an effect that acts at edges."""

    effect: Effect  # as the model has it, or neutral
    parameter: Parameter  # whose size is searched
    usual: float  # its size before anything is seen
    wide: float  # standard deviation of the logarithm of that
    held: bool  # the model has it

    @property
    def name(self) -> str:
        return self.effect.name


@dataclass(frozen=True)
class EdgeTried:
    """One form at all sizes."""

    form: EdgeForm
    sizes: Vector  # (k,)
    fits: tuple[EdgeFit, ...]  # per size

    @property
    def best(self) -> int:
        return int(np.argmin([fit.cost for fit in self.fits]))

    @property
    def effect(self) -> Effect:
        return with_value(self.form.effect, self.form.parameter, float(self.sizes[self.best]))

    @property
    def cost(self) -> float:
        return self.fits[self.best].cost

    def std(self, inflated: float) -> float:
        """Of the size: where the chi2 has grown by one, and by how much it moves when a placement is left out."""
        costs = np.array([fit.cost for fit in self.fits])
        near = self.sizes[costs < costs.min() + inflated]
        order = np.sort(self.sizes)
        at = int(np.searchsorted(order, self.sizes[self.best]))
        grid = np.ptp(order[max(at - 1, 0) : at + 2]) / 4
        count, without = len(self._without), self.sizes[self._without]
        moved = np.sqrt((count - 1) / count * np.sum((without - without.mean()) ** 2))
        return float(max(np.ptp(near) / 2, grid, moved))

    @cached_property
    def _without(self) -> NDArray[np.intp]:
        """(placements,) number of the size that is best without each."""
        table = np.array([fit.costs for fit in self.fits])
        return np.argmin(table.sum(axis=1)[:, None] - table, axis=0)

    def evidence(self, inflated: float) -> float:
        """Logarithm of the marginal likelihood over sizes."""
        prior = -0.5 * (np.log(self.sizes / self.form.usual) / self.form.wide) ** 2
        costs = np.array([fit.cost for fit in self.fits])
        order = np.argsort(self.sizes)
        width = np.gradient(np.log(self.sizes[order])) if len(order) > 1 else np.ones(1)
        weight = np.log(width) + prior[order] - np.log(np.sqrt(2 * np.pi) * self.form.wide)
        return float(logsumexp(weight - 0.5 * costs[order] / inflated))

    def elsewhere(self) -> Vector:
        """(placements,) cost of each at the size that is best in all others."""
        return np.array([self.fits[k].costs[place] for place, k in enumerate(self._without)])


def edge_steps(observations: Observations) -> tuple[Sensor, tuple[ChannelStep, ...]]:
    """The model with what its edges lack, and every step towards it; nothing where no edge is seen."""
    sensor, places = observations.sensor, places_of(observations)
    if places is None:
        return sensor, ()
    now, steps = places.under(sensor), []
    for _ in range(MOST_STEPS):
        if places.agrees(now):
            break
        found = _step(sensor, places, now)
        if found is None:
            break
        sensor, step, now = found
        steps.append(step)
    return sensor, tuple(step if places.agrees(now) else replace(step, established=False) for step in steps)


def places_of(observations: Observations) -> EdgePlaces | None:
    """The edges of all blocks; None where none is seen."""
    views = views_of([patch.block.T_world_camera for patch in observations.patches])
    single = len({patch.block.place for patch in observations.patches}) == 1
    first: dict[int, Patch] = {}  # of a series the first frames; of one recording alone its views
    for view, patch in zip(views, observations.patches, strict=True):
        first.setdefault(view if single else patch.block.place, patch)
    every = (one for one in map(rims_of, first.values()) if one is not None)
    rims = tuple(one for one in every if np.max(one.shaken) < MOST_SHAKEN_PX)
    return EdgePlaces(rims, observations.loose.poses) if rims else None


def shown_at_edges(observations: Observations) -> set[str]:
    """Names of effects that would show at the edges here, wherever these stand."""
    sensor, places = observations.sensor, places_of(observations)
    out: set[str] = set()
    if places is None:
        return out
    for form in _forms(sensor):
        sizes = (0.0, form.usual)
        without, within = (sensor.having(with_value(form.effect, form.parameter, size)) for size in sizes)
        if form.name not in out and places.tells(without, within):
            out.add(form.name)
    return out


def edges_next(observations: Observations, step: ChannelStep) -> str:
    """What to record so that look-alikes part at edges."""
    places = places_of(observations)
    if not step.alike or places is None:
        return ""
    if not places.opposite:
        return "the same thing with two opposite edges in the picture: one alone may as well stand elsewhere"
    light = np.concatenate([np.ravel(rims.patch.view.edges.light) for rims in places.rims if rims.patch.view.edges])
    lit = step.effect is not None and "amplitude" in step.effect.variables
    if lit and not np.any(np.abs(np.log(np.maximum(light, 1e-3))) > np.log(CONTRAST)):
        return "the same edges of a black thing before a white wall, and of a white one before a black wall"
    return "the same edges from more places: nearer and farther, at other slants, level and upright"


def _step(sensor: Sensor, places: EdgePlaces, now: EdgeFit) -> tuple[Sensor, ChannelStep, EdgeFit] | None:
    tried = [_tried(sensor, places, form) for form in _forms(sensor)]
    if not tried:
        return None
    by_name: dict[str, EdgeTried] = {}
    for one in sorted(tried, key=lambda one: one.cost):
        by_name.setdefault(one.form.name, one)
    likeliest = min((one.fits[one.best] for one in tried), key=lambda fit: fit.cost)
    # hard edges move by whole pixels: softer ones have found where they stand
    now = min(now, places.under(sensor, likeliest.moved), key=lambda fit: fit.cost)
    inflated = max(1.0, likeliest.cost / places.telling(likeliest))
    nothing, chances = _posterior(tried, now, inflated)
    if nothing > 1 - CONFIDENCE:
        return None
    likely = sorted(chances, key=lambda name: -chances[name])
    best = by_name[likely[0]]
    # a name is told as long as it is in the set that is sure, or fits nearly as well at any size
    before = np.cumsum([0.0, *(chances[name] for name in likely)])
    near = (by_name[name].cost < best.cost + SURE * inflated for name in likely)
    alike = [name for name, sum_, fits in zip(likely, before, near, strict=False) if sum_ < CONFIDENCE or fits][1:]
    gain, gains = now.cost - best.cost, now.costs - best.elsewhere()
    again = len(gains) > 1 and gains.sum() > REPLICATED * gain and gains.max() < ONE * np.maximum(gains, 0).sum()
    name, std = best.form.parameter.name, best.std(inflated)
    probability = float(min(1.0, len(tried) * len(SIZES) * chdtrc(1, max(gain / inflated, 0.0))))
    step = ChannelStep(
        "edges",
        best.effect,
        {name: std},
        best.form.held,
        gain / inflated,
        max(float(gains.sum() / now.costs.sum()), 0.0),
        probability,
        tuple(alike),
        established=bool(again and len(alike) < LARGEST_SET and probability <= FALSE_ALARM),
        posterior=1.0 - nothing,
    )
    better = sensor.having(best.effect)
    return replace(better, std={**better.std, (best.form.name, name): std}), step, best.fits[best.best]


def _posterior(tried: Sequence[EdgeTried], now: EdgeFit, inflated: float) -> tuple[float, dict[str, float]]:
    """Probability that nothing is missing, and of each name alone; as likely before as that any is."""
    names = sorted({one.form.name for one in tried})
    logs = [np.log(0.5) - 0.5 * now.cost / inflated]
    for name in names:
        own = [one.evidence(inflated) for one in tried if one.form.name == name]
        logs.append(float(logsumexp(own)) - np.log(len(own) * 2 * len(names)))
    chances = np.exp(np.array(logs) - logsumexp(logs))
    return float(chances[0]), dict(zip(names, chances[1:].tolist(), strict=True))


def _forms(sensor: Sensor) -> Iterator[EdgeForm]:
    """Numbers of effects that act at edges of what stands still, of the model or not."""
    for kind in EFFECTS:
        if not acts_at_edges(kind) or (kind.principles and sensor.principle not in kind.principles):
            continue
        own = sensor.effect(kind.name)
        for about in parameters(kind).values():
            if about.neutral != 0 or about.kind not in ("number", "scalar"):
                continue
            value = 0.0 if own is None else getattr(own, about.name)
            if np.ndim(value) or (own is not None and sensor.std.get((kind.name, about.name)) == 0.0):
                continue
            if value:
                known = float(np.max(sensor.std.get((kind.name, about.name), USUAL * abs(value))))
                yield EdgeForm(own or kind(), about, abs(float(value)), max(known / abs(float(value)), 0.05), True)
            elif own is None:
                yield EdgeForm(kind(), about, about.typical, TYPICAL, False)


def _tried(sensor: Sensor, places: EdgePlaces, form: EdgeForm) -> EdgeTried:
    """A form at sizes about its usual one, closer about the best."""
    about, fits = form.parameter, {}

    def fit(sizes: Sequence[float] | Vector) -> float:
        for size in np.unique(np.clip(sizes, about.low, about.high)):
            if size not in fits and size:
                fits[float(size)] = places.under(sensor.having(with_value(form.effect, about, float(size))))
        return min(fits, key=lambda size: fits[size].cost)

    best, step = fit(form.usual * SIZES), SIZES[1] / SIZES[0]
    for _ in range(2):
        step = step**0.4
        best = fit(best * step ** np.array([-1.0, 1.0]))
    return EdgeTried(form, np.array(list(fits)), tuple(fits.values()))
