"""The edge channel: which effect makes of a depth edge what was recorded there?"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc, logsumexp

from fusion.discrepancy.channels.channel_step import ChannelStep
from fusion.discrepancy.channels.noise_parameters import USUAL, with_value
from fusion.discrepancy.decisions import CONFIDENCE, NOISE_ALONE, REPLICATED
from fusion.discrepancy.inference.edge_places import EdgeFit, EdgePlaces
from fusion.discrepancy.observe.observations import Observations
from fusion.discrepancy.observe.rims import rims_of
from fusion.sensor.effect import Effect
from fusion.sensor.effects import EFFECTS
from fusion.sensor.parameter import Parameter, parameters
from fusion.sensor.sensor import Sensor

Vector = NDArray[np.float64]

SIZES = np.geomspace(1 / 8, 8, 13)  # of a typical size, that are tried
TYPICAL = np.log(3.0)  # an effect that is there has its typical size to this factor (one standard deviation)
MOST_STEPS = 2
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
    def std(self) -> float:
        """Of the size, where the chi2 has grown by one."""
        costs = np.array([fit.cost for fit in self.fits])
        near = self.sizes[costs < costs.min() + 1.0]
        order = np.sort(self.sizes)
        at = int(np.searchsorted(order, self.sizes[self.best]))
        beside = order[max(at - 1, 0) : at + 2]
        return float(max(np.ptp(near), np.ptp(beside) / 2) / 2)

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
        table = np.array([fit.costs for fit in self.fits])
        others = table.sum(axis=1)[:, None] - table
        return np.array([table[int(np.argmin(others[:, g])), g] for g in range(table.shape[1])])


def edge_steps(observations: Observations) -> tuple[Sensor, tuple[ChannelStep, ...]]:
    """The model with what its edges lack, and every step towards it; nothing where no edge is seen."""
    sensor = observations.sensor
    rims = tuple(one for one in map(rims_of, observations.patches) if one is not None)
    if not rims:
        return sensor, ()
    places = EdgePlaces(rims, observations.loose.pose)
    now, steps = places.under(sensor), []
    for _ in range(MOST_STEPS):
        if now.cost <= NOISE_ALONE * places.telling:
            break
        found = _step(sensor, places, now)
        if found is None:
            break
        sensor, step, now = found
        steps.append(step)
    agrees = now.cost <= NOISE_ALONE * places.telling
    return sensor, tuple(step if agrees else replace(step, established=False) for step in steps)


def _step(sensor: Sensor, places: EdgePlaces, now: EdgeFit) -> tuple[Sensor, ChannelStep, EdgeFit] | None:
    tried = [_tried(sensor, places, form) for form in _forms(sensor)]
    if not tried:
        return None
    best = min(tried, key=lambda one: one.fits[one.best].cost)
    fit = best.fits[best.best]
    inflated = max(1.0, fit.cost / places.telling)
    names = sorted({one.form.name for one in tried})
    logs = {None: np.log(0.5) - 0.5 * now.cost / inflated}
    for name in names:
        own = [one.evidence(inflated) for one in tried if one.form.name == name]
        logs[name] = float(logsumexp(own)) - np.log(len(own) * 2 * len(names))
    whole = float(logsumexp(list(logs.values())))
    chance = {name: float(np.exp(log - whole)) for name, log in logs.items()}
    if chance[None] > 1 - CONFIDENCE:
        return None
    likely = sorted(names, key=lambda name: -chance[name])
    told = [likely[: k + 1] for k in range(len(likely))]
    said = next((some for some in told if sum(chance[name] for name in some) >= CONFIDENCE), likely)
    best = min((one for one in tried if one.form.name == said[0]), key=lambda one: one.fits[one.best].cost)
    fit = best.fits[best.best]
    gain = (now.cost - fit.cost) / inflated
    gains = now.costs - best.elsewhere()
    again = len(gains) > 1 and gains.sum() > REPLICATED * (now.cost - fit.cost)
    again = again and gains.max() < ONE * np.maximum(gains, 0).sum()
    step = ChannelStep(
        "edges",
        best.effect,
        {best.form.parameter.name: best.std},
        best.form.held,
        gain,
        (now.cost - fit.cost) / now.cost,
        float(min(1.0, len(tried) * len(SIZES) * chdtrc(1, max(gain, 0.0)))),
        tuple(said[1:]),
        established=bool(again and sum(chance[name] for name in said) >= CONFIDENCE),
    )
    better = sensor.having(best.effect)
    key = (best.effect.name, best.form.parameter.name)
    return replace(better, std={**better.std, key: best.std}), step, fit


def _forms(sensor: Sensor) -> Iterator[EdgeForm]:
    """Numbers of effects that act at edges of what stands still, of the model or not."""
    for kind in EFFECTS:
        if "edge" not in kind.variables or "velocity" in kind.variables:
            continue
        if not (kind.changes("bias") or kind.changes("noise")):
            continue
        if kind.principles and sensor.principle not in kind.principles:
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
