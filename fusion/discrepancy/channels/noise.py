"""The noise channel: do repeated frames scatter as the model says, and which effect or number would make it so?"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.channels.channel_step import ChannelStep
from fusion.discrepancy.channels.judging import (
    EXPLAINED,
    Tried,
    confirmed,
    explains,
    improbable,
    in_succession,
    large,
    nearer,
    probability,
    replicated,
)
from fusion.discrepancy.channels.losses import UNITS
from fusion.discrepancy.channels.noise_parameters import (
    NoiseParameter,
    known_parameters,
    new_parameters,
    own_parameters,
)
from fusion.discrepancy.channels.scatter import Scatter, scatter_of
from fusion.discrepancy.channels.turning import COMMON, Whitener, as_stated, changes, turn, whitener_of
from fusion.discrepancy.channels.unnamed import unnamed, whitened
from fusion.discrepancy.decisions import SPREAD_FRAMES, SURE
from fusion.discrepancy.naming.heterogeneity import FORM
from fusion.discrepancy.observe.frame_block import FrameBlock
from fusion.discrepancy.observe.observations import Observations
from fusion.discrepancy.observe.patch import Patch
from fusion.discrepancy.unknown.unrestricted import covariates
from fusion.sensor.sensor import Sensor

Vector = NDArray[np.float64]

MOST_STEPS = 3
MUCH = float(np.log(1.5))  # of the logarithm of a variance, in the tiles that change most: less is told of none
SILENT = float(np.log(100.0))  # of the measured over the predicted variance: the model says nothing of noise


def noise_steps(observations: Observations, held: Sequence[FrameBlock] = ()) -> tuple[Sensor, tuple[ChannelStep, ...]]:
    """The model with what its noise lacks, and every step towards it.

    Args:
        held: frames that take no part in the fit.
    """
    sensor = observations.sensor
    steps: list[ChannelStep] = []
    patches = [p for p in observations.patches if len(p.block.frames) >= SPREAD_FRAMES and len(p.tiles)]
    free: frozenset[str] = frozenset()
    for _ in range(MOST_STEPS):
        found = _step(sensor, patches, free, held) if patches else None
        if found is None:
            break
        sensor, step = found
        steps.append(step)
        free |= {step.effect.name} if step.effect else frozenset()
        patches = [patch.under(sensor) for patch in patches]
    last = _of_another_form(replace(observations, sensor=sensor, patches=tuple(patches))) if patches else None
    return sensor, merged(steps if last is None else [*steps, last])


def merged(steps: Sequence[ChannelStep]) -> tuple[ChannelStep, ...]:
    """One finding for each effect: several of its numbers may have been found one after the other."""
    out: dict[str, ChannelStep] = {}
    for step in steps:
        name = step.effect.name if step.effect else ""
        first = out.get(name)
        if first is not None:
            step = replace(
                step,
                std={**first.std, **step.std},
                corrected=first.corrected,  # what has just been found is no number of the given model
                gain=first.gain + step.gain,
                share=1.0 - (1.0 - first.share) * (1.0 - step.share),
                probability=min(first.probability, step.probability),
                alike=first.alike,
            )
        out[name] = step
    return tuple(out.values())


def _step(
    sensor: Sensor, patches: Sequence[Patch], free: frozenset[str], held: Sequence[FrameBlock]
) -> tuple[Sensor, ChannelStep] | None:
    scatter = scatter_of(patches)
    known, fresh = known_parameters(sensor, scatter, free), list(new_parameters(sensor, scatter))
    whitener = Whitener()
    for again in (False, True):
        nothing = turn(scatter, whitener, known, [k.value for k in known])
        tried = _all_tried(scatter, whitener, known, fresh, free, nothing.chi2)
        tried = [one for one in tried if in_succession(one, nothing, scatter, whitener)]
        if not tried:
            return None
        best, names = max(tried, key=lambda one: one.score), len(tried)
        if not improbable(best, names):
            return None
        if not again:  # what is left by the best explanation is noise: what is left by none would hide it
            whitener = whitener_of(scatter, best.turned)
    # a stated value that is wrong is compared with itself as stated, not with the most that its precision allows
    before = as_stated(scatter, whitener, known) if best.corrected else nothing
    if not (large(best, before) and explains(best, before) and replicated(best, before, scatter, whitener)):
        return None
    if not confirmed(best, before, sensor, held, whitener):
        return None
    better, std = _applied(sensor, best)
    if not nearer(better, scatter):
        return None
    gain = before.chi2 - best.turned.chi2
    return better, ChannelStep(
        "noise",
        better.effect(best.name),
        std,
        best.corrected,
        gain,
        gain / max(before.chi2, 1e-9),
        probability(best, names),
        _alike(best, tried),
        variables=_seen_variables(best, patches),
    )


def _of_another_form(observations: Observations) -> ChannelStep | None:
    """Noise that depends on something known otherwise than any law says, with the effect that depends on the same."""
    scatter, sensor = scatter_of(observations.patches), observations.sensor
    sigma = np.hypot(scatter.excess_sigma, COMMON)
    usual = float(np.median(scatter.excess))  # as much everywhere is no law of anything
    before = float(np.sum(whitened(scatter.excess - usual, sigma) ** 2))
    law = unnamed(scatter.excess - usual, sigma, scatter.place, covariates(observations))
    if law is None or float(np.quantile(np.abs(law.fitted), 0.9)) < MUCH:
        return None
    if law.gain < EXPLAINED * (before - len(scatter)):
        return None
    own = [one for one in sensor.effects if one.own and set(law.variables) <= set(one.variables)]
    each = zip(law.variables, law.knots, law.heights, strict=True)
    name, at, heights = max(each, key=lambda one: float(np.ptp(one[2])))
    at = np.exp(at) if name == "amplitude" else np.degrees(at) if name == "incidence" else at
    ends = [
        f"{np.exp((usual + heights[k]) / 2):.2g} times as much at {at[k]:.3g}{UNITS.get(name, '')}" for k in (0, -1)
    ]
    text = f"it depends on {', '.join(law.variables)} otherwise than the model says: {', '.join(ends)} of {name}"
    share = min(law.gain / max(before, 1e-9), 1.0)
    # of what nobody has a law of, noise of a model that is only about right is the first cause
    return ChannelStep("noise", own[0] if own else None, {}, bool(own), law.gain, share, law.probability,
                       variables=law.variables, text=text, established=bool(own))  # fmt: skip


def _seen_variables(best: Tried, patches: Sequence[Patch]) -> tuple[str, ...]:
    """What the noise depends on here: not on an amplitude that nobody recorded."""
    dark = all(patch.block.view.ir is None for patch in patches)
    return tuple(name for name in best.free[0].effect.variables if not (dark and name == "amplitude"))


def _all_tried(
    scatter: Scatter,
    whitener: Whitener,
    known: list[NoiseParameter],
    fresh: list[NoiseParameter],
    free: frozenset[str],
    before: float,
) -> list[Tried]:
    if float(np.median(scatter.excess)) > SILENT:
        # every camera has noise of its own: a model without any is not finished, and its lack is no other effect
        ways = list(own_parameters(scatter))
        return [_new_tried(scatter, whitener, way, known, before) for way in ways]
    tried = []
    for name in dict.fromkeys(k.effect.name for k in known):
        if name not in free:
            loose = [replace(k, sigma=np.inf) if k.effect.name == name else k for k in known]
            turned = turn(scatter, whitener, loose, [k.value for k in known])
            own = tuple(k for k in known if k.effect.name == name)
            tried.append(Tried(name, own, turned, before - turned.chi2, True))
    return tried + [_new_tried(scatter, whitener, (param,), known, before) for param in fresh]


def _new_tried(
    scatter: Scatter, whitener: Whitener, way: tuple[NoiseParameter, ...], known: list[NoiseParameter], before: float
) -> Tried:
    """Numbers of one effect that the model lacks, at their best."""
    start = [_start(scatter, whitener, param) / np.sqrt(len(way)) for param in way]
    turned = turn(scatter, whitener, [*way, *known], [*start, *(k.value for k in known)])
    return Tried(way[0].effect.name, way, turned, before - turned.chi2, False)


def _start(scatter: Scatter, whitener: Whitener, param: NoiseParameter) -> float:
    """The best of the values that were tried, by itself."""
    costs = []
    for value in param.at[1:]:
        excess, renewal = changes((param,), (value,))
        costs.append(np.abs(whitener.white(scatter, scatter.excess - excess, scatter.renewal - renewal)).sum())
    return float(param.at[1:][int(np.argmin(costs))])


def _applied(sensor: Sensor, best: Tried) -> tuple[Sensor, dict[str, float]]:
    """The model with the fitted values of the effect that was tried, and their standard deviations."""
    keys = [param.key for param in best.free]
    values: dict[str, Any] = {}
    std: dict[str, float] = {}
    for param, value, spread in zip(best.turned.params, best.turned.values, best.turned.std, strict=True):
        if param.key in keys:
            values[param.parameter.name] = float(value)
            std[param.parameter.name] = float(np.hypot(spread, COMMON * value))  # no noise model is better than that
    effect = replace(best.free[0].effect, **values)
    kept = {key: known for key, known in sensor.std.items() if key[0] != best.name or key[1] not in std}
    return replace(sensor.having(effect), std=kept | {(best.name, name): s for name, s in std.items()}), std


def _alike(best: Tried, tried: Sequence[Tried]) -> tuple[str, ...]:
    """Names that explain the scatter as well: not clearly less, or by less than laws of a catalogue are off."""
    least = best.gain - max(SURE, FORM * best.gain)
    return tuple(dict.fromkeys(one.name for one in tried if one.name != best.name and one.gain > least))
