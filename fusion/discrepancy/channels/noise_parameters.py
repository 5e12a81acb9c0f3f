"""Noise parameters: the numbers the scatter of repeated frames depends on, of effects in the model or not."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.channels.scatter import Scatter, filtered, predicted_variance
from fusion.discrepancy.channels.succession import memory_of
from fusion.discrepancy.inference.shaking import SHAKES
from fusion.discrepancy.observe.patch import Patch
from fusion.recording.ahead import side_by_side
from fusion.sensor.effect import Effect
from fusion.sensor.effects import EFFECTS
from fusion.sensor.parameter import Parameter, parameters
from fusion.sensor.sensor import Sensor

Vector = NDArray[np.float64]

SIZES = np.geomspace(0.03, 30.0, 7)  # of a typical size, that are tried
MEMORIES = (0.05, 0.15, 0.3, 0.45, 0.6, 0.75, 0.9)
USUAL = 0.3  # share of itself by which a value may be off whose standard deviation nobody stated: guess


@dataclass(frozen=True)
class NoiseParameter:
    """One number, and what the tiles (n,) make of it."""

    effect: Effect  # whose it is, as it is before the parameters is turned
    parameter: Parameter  # which
    value: float  # before it is turned
    sigma: float  # how well it is known; infinite for an effect that the model lacks
    at: Vector  # (k,) values at which the changes are known, rising
    growth: NDArray[np.float64]  # (k, n) by which share the variance grows there
    factor: NDArray[np.float64]  # (k, n) change there of the logarithm of the variance, by a filter in time
    renewal: NDArray[np.float64]  # (k, n) change there of the logarithm of the share that is new in every frame

    @property
    def key(self) -> tuple[str, str]:
        return self.effect.name, self.parameter.name

    @property
    def form(self) -> tuple[Effect, str]:
        """The same, with the shape that goes with it."""
        return self.effect, self.parameter.name

    @property
    def new(self) -> bool:
        return not np.isfinite(self.sigma)

    def turned(self, value: float) -> tuple[Vector, Vector, Vector]:
        """Growth, factor and renewal (n,) at a value."""
        place = int(np.clip(np.searchsorted(self.at, value) - 1, 0, len(self.at) - 2))
        low, high = self.at[place], self.at[place + 1]
        share = (value - low) / (high - low)  # beyond the ends the last stretch goes on
        factor, renewal = ((1 - share) * part[place] + share * part[place + 1] for part in (self.factor, self.renewal))
        if np.isfinite(self.sigma) or self.value:
            step = value - self.value
            return step * self._bend[0] + step**2 * self._bend[1], factor, renewal
        # a variance grows with the square of a size, so its root is nearly straight in between
        roots = np.sign(self.growth) * np.sqrt(np.abs(self.growth))
        root = (1 - share) * roots[place] + share * roots[place + 1]
        return np.sign(root) * root**2, factor, renewal

    @cached_property
    def _bend(self) -> NDArray[np.float64]:
        """(2, n) of the growth, as a multiple of the step away from the value and of its square: exact for a size."""
        step = self.at - self.value
        near = np.abs(step) <= 1.01 * max(abs(self.value), np.min(np.abs(step[step != 0])))
        columns = np.column_stack([step, step**2])[near]
        return np.asarray(np.linalg.lstsq(columns, self.growth[near], rcond=None)[0])

    def only(self, rows: NDArray[np.bool_]) -> "NoiseParameter":
        """For these tiles alone."""
        return replace(self, growth=self.growth[:, rows], factor=self.factor[:, rows], renewal=self.renewal[:, rows])


def known_parameters(sensor: Sensor, scatter: Scatter, free: frozenset[str]) -> list[NoiseParameter]:
    """Noise parameters that the model holds; those of the effects named in `free` are known no better than by guess."""
    params = []
    for effect in sensor.effects:
        if effect.frozen or not (effect.changes("noise") or effect.changes("spread")):
            continue
        for name, about in parameters(effect).items():
            value = getattr(effect, name)
            if np.ndim(value) or about.kind not in ("number", "scalar"):
                continue
            stated = float(np.max(sensor.std.get((effect.name, name), USUAL * abs(value - about.neutral))))
            sigma = max(abs(float(value)), stated) if effect.name in free and stated > 0 else stated
            if sigma > 0:
                params.append(_known(effect, about, float(value), sigma, scatter))
    return [param for param in params if np.any(param.growth) or np.any(param.factor)]


def new_parameters(
    sensor: Sensor, scatter: Scatter, wanted: frozenset[tuple[str, str]] | None = None
) -> Iterator[NoiseParameter]:
    """Sizes of effects that change the noise and that the model lacks, and terms that its own ones do without.

    Args:
        wanted: names of effect and parameter that are asked for; None: all.
    """
    for kind in EFFECTS:
        # what all pixels of a frame share is told by the course of frames, and not by their scatter
        changes = (kind.changes("noise") or kind.changes("spread")) and not kind.frozen and kind is not SHAKES
        if not changes or (kind.principles and sensor.principle not in kind.principles):
            continue
        own = sensor.effect(kind.name)
        for about in parameters(kind).values():
            if about.neutral != 0 or about.kind not in ("number", "scalar", "list"):
                continue
            if own is not None and (np.any(getattr(own, about.name)) or (kind.name, about.name) in sensor.std):
                continue
            if wanted is not None and (kind.name, about.name) not in wanted:
                continue
            for shaped in _shaped(own or kind(), about):
                param = _new(shaped, about, scatter)
                if np.any(param.growth) or np.any(param.factor):
                    yield param


def own_parameters(scatter: Scatter) -> Iterator[tuple[NoiseParameter, ...]]:
    """The ways in which a sensor of this kind can have noise of its own, each as the numbers that go together."""
    views = [patch.view for patch in scatter.patches]
    flight = views[0].time_of_flight
    lit = flight and all(view.ir is not None for view in views)
    # of noise that follows the light the terms add up as variances, and are found together
    groups = ("amplitude", "depth") if lit else ("depth",) if flight else ("disparity",)
    for kind, wanted in product((kind for kind in EFFECTS if kind.own), groups):
        about = [p for p in parameters(kind).values() if p.group == wanted]
        # what stands for the light is no size
        given: dict[str, Any] = {p.name: p.typical for p in about if p.unit == "count"}
        params = [_new(kind(**given), p, scatter) for p in about if p.name not in given]
        params = [param for param in params if np.any(param.growth)]
        yield from [tuple(params)] if wanted == "amplitude" else [(param,) for param in params]


def _shaped(effect: Effect, about: Parameter) -> Iterator[Effect]:
    """The effect with every value of the shapes that go with a size and are searched; as it is where there are none."""
    shapes = [p for p in parameters(effect).values() if p.search and p.group == about.group and p.name != about.name]
    for values in product(*(shape.search for shape in shapes)):
        changed: dict[str, Any] = {shape.name: value for shape, value in zip(shapes, values, strict=True)}
        yield replace(effect, **changed) if changed else effect


def _new(effect: Effect, about: Parameter, scatter: Scatter) -> NoiseParameter:
    filtering = memory_of(with_value(effect, about, about.typical)) > 0
    values = np.array(MEMORIES) if filtering else about.typical * SIZES
    values = np.concatenate([[0.0], values[(values > about.low) & (values <= about.high)]])
    effects = [with_value(effect, about, value) for value in values]
    return NoiseParameter(effect, about, 0.0, np.inf, values, *_changes(effects, effect, scatter))


def _known(effect: Effect, about: Parameter, value: float, sigma: float, scatter: Scatter) -> NoiseParameter:
    steps = np.array([-0.9, -0.5, -0.25, 0.0, 0.3, 1.0, 3.0]) * max(abs(value), sigma)
    values = np.unique(np.clip(value + steps, about.low, about.high))
    effects = [with_value(effect, about, v) for v in values]
    return NoiseParameter(effect, about, value, sigma, values, *_changes(effects, effect, scatter))


def with_value(effect: Effect, about: Parameter, value: float) -> Effect:
    """The effect with another value of one parameter."""
    changed: dict[str, Any] = {about.name: float(value)}
    return replace(effect, **changed)


def _changes(effects: list[Effect], own: Effect, scatter: Scatter) -> tuple[Vector, Vector, Vector]:
    """(k, n) each: growth, factor and renewal of the tiles when `own` becomes each of the effects."""
    if memory_of(own) or any(memory_of(effect) for effect in effects):
        parts = [_filtered(effects, own, patch) for patch in scatter.patches]
        factor, renewal = (np.concatenate(part, axis=1) for part in zip(*parts, strict=True))
        return np.zeros(factor.shape), factor, renewal
    growth = np.concatenate(side_by_side(lambda patch: _grown(effects, own, patch), scatter.patches), axis=1)
    return growth, np.zeros(growth.shape), np.zeros(growth.shape)


def _filtered(effects: list[Effect], own: Effect, patch: Patch) -> tuple[Vector, Vector]:
    before = filtered(patch, memory_of(own))
    after = [filtered(patch, memory_of(effect)) for effect in effects]
    factor, renewal = (np.stack([one[k] for one in after]) - before[k] for k in (0, 1))
    return factor, renewal * (len(patch.block.frames) > 2)


def _grown(effects: list[Effect], own: Effect, patch: Patch) -> Vector:
    """(k, n) change of the variance of each tile as a share of it."""
    with np.errstate(all="ignore"):
        whole, before = predicted_variance(patch, patch.sigma), own.noise(patch.depth, patch.view) ** 2
        rest = patch.sigma**2 - before
        spreads = (np.sqrt(np.maximum(rest + effect.noise(patch.depth, patch.view) ** 2, 0.0)) for effect in effects)
        return np.stack([predicted_variance(patch, spread) / whole - 1.0 for spread in spreads])
