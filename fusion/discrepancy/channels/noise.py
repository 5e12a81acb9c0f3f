"""The noise channel: do repeated frames scatter as the model says, and which effect or number would make it so?"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.channels.channel_step import ChannelStep
from fusion.discrepancy.channels.judging import (
    Tried,
    confirmed,
    contradicted,
    explains,
    improbable,
    large,
    probability,
    replicated,
)
from fusion.discrepancy.channels.knobs import Knob, known_knobs, new_knobs, own_knobs
from fusion.discrepancy.channels.scatter import Scatter, scatter_of
from fusion.discrepancy.channels.turning import COMMON, Ruler, TunedKnobs, as_stated, changes, ruler_of, turn
from fusion.discrepancy.decisions import ALIKE, SPREAD_FRAMES
from fusion.discrepancy.observe.look import FrameBlock
from fusion.discrepancy.observe.observations import Observations, Patch, predicted
from fusion.sensor.sensor import Sensor

Vector = NDArray[np.float64]

MOST_STEPS = 3
SILENT = float(np.log(100.0))  # of the measured over the predicted variance: the model says nothing of noise
COMPARABLE = 0.8  # of the gain: a name that explains less is no look-alike


def noise_steps(observations: Observations, held: Sequence[FrameBlock] = ()) -> tuple[Sensor, tuple[ChannelStep, ...]]:
    """The model with what its noise lacks, and every step towards it.

    Args:
        held: frames that take no part in the fit.
    """
    sensor = observations.sensor
    steps: list[ChannelStep] = []
    patches = [p for p in observations.patches if len(p.look.frames) >= SPREAD_FRAMES and len(p.tiles)]
    free: frozenset[str] = frozenset()
    for _ in range(MOST_STEPS):
        found = _step(sensor, patches, free, held) if patches else None
        if found is None:
            break
        sensor, step = found
        steps.append(step)
        free |= {step.effect.name} if step.effect else frozenset()
        patches = [replace(p, sensor=sensor, sigma=predicted(sensor, p.look)[1]) for p in patches]
    return sensor, merged(steps)


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
                corrected=first.corrected or step.corrected,
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
    known, fresh = known_knobs(sensor, scatter, free), list(new_knobs(sensor, scatter))
    ruler = Ruler()
    for again in (False, True):
        nothing = turn(scatter, ruler, known, [k.value for k in known])
        tried = [
            t for t in _all_tried(scatter, ruler, known, fresh, free, nothing.chi2) if not contradicted(t, scatter)
        ]
        if not tried:
            return None
        best, names = max(tried, key=lambda one: one.score), len(tried)
        if not improbable(best, names):
            return None
        if not again:  # what is left by the best explanation is noise: what is left by none would hide it
            ruler = ruler_of(scatter, best.turned)
    # a stated value that is wrong is compared with itself as stated, not with the most that its precision allows
    before = as_stated(scatter, ruler, known) if best.corrected else nothing
    if not (large(best, before) and explains(best, before) and replicated(best, before, scatter, ruler)):
        return None
    if not confirmed(best, before, sensor, held, ruler):
        return None
    better, std = _applied(sensor, best)
    gain = before.chi2 - best.turned.chi2
    return better, ChannelStep(
        "noise",
        better.effect(best.name),
        std,
        best.corrected,
        gain,
        gain / max(before.chi2, 1e-9),
        probability(best, names),
        _alike(best, tried, nothing, scatter, ruler),
        variables=_seen_variables(best, patches),
    )


def _seen_variables(best: Tried, patches: Sequence[Patch]) -> tuple[str, ...]:
    """What the noise depends on here: not on an amplitude that nobody recorded."""
    dark = all(patch.look.view.ir is None for patch in patches)
    return tuple(name for name in best.free[0].effect.variables if not (dark and name == "amplitude"))


def _all_tried(
    scatter: Scatter, ruler: Ruler, known: list[Knob], fresh: list[Knob], free: frozenset[str], before: float
) -> list[Tried]:
    if float(np.median(scatter.excess)) > SILENT:
        # every camera has noise of its own: a model without any is not finished, and its lack is no other effect
        ways = list(own_knobs(scatter))
        return [_new_tried(scatter, ruler, way, known, before) for way in ways]
    tried = []
    for name in dict.fromkeys(k.effect.name for k in known):
        if name not in free:
            loose = [replace(k, sigma=np.inf) if k.effect.name == name else k for k in known]
            turned = turn(scatter, ruler, loose, [k.value for k in known])
            own = tuple(k for k in known if k.effect.name == name)
            tried.append(Tried(name, own, turned, before - turned.chi2, True))
    return tried + [_new_tried(scatter, ruler, (knob,), known, before) for knob in fresh]


def _new_tried(scatter: Scatter, ruler: Ruler, way: tuple[Knob, ...], known: list[Knob], before: float) -> Tried:
    """Numbers of one effect that the model lacks, at their best."""
    start = [_start(scatter, ruler, knob) / np.sqrt(len(way)) for knob in way]
    turned = turn(scatter, ruler, [*way, *known], [*start, *(k.value for k in known)])
    return Tried(way[0].effect.name, way, turned, before - turned.chi2, False)


def _start(scatter: Scatter, ruler: Ruler, knob: Knob) -> float:
    """The best of the values that were tried, by itself."""
    costs = []
    for value in knob.at[1:]:
        excess, renewal = changes((knob,), (value,))
        costs.append(np.abs(ruler.white(scatter, scatter.excess - excess, scatter.renewal - renewal)).sum())
    return float(knob.at[1:][int(np.argmin(costs))])


def _applied(sensor: Sensor, best: Tried) -> tuple[Sensor, dict[str, float]]:
    """The model with the fitted values of the effect that was tried, and their standard deviations."""
    keys = [knob.key for knob in best.free]
    values: dict[str, Any] = {}
    std: dict[str, float] = {}
    for knob, value, spread in zip(best.turned.knobs, best.turned.values, best.turned.std, strict=True):
        if knob.key in keys:
            values[knob.parameter.name] = float(value)
            std[knob.parameter.name] = float(np.hypot(spread, COMMON * value))  # no noise model is better than that
    effect = replace(best.free[0].effect, **values)
    kept = {key: known for key, known in sensor.std.items() if key[0] != best.name or key[1] not in std}
    return replace(sensor.having(effect), std=kept | {(best.name, name): s for name, s in std.items()}), std


def _alike(best: Tried, tried: Sequence[Tried], nothing: TunedKnobs, scatter: Scatter, ruler: Ruler) -> tuple[str, ...]:
    """Names whose own best fit changes the tiles in the same way."""
    own = _footprint(best, nothing, scatter, ruler)
    out: dict[str, None] = {}
    for one in tried:
        if one.name != best.name and one.gain > COMPARABLE * best.gain:
            other = _footprint(one, nothing, scatter, ruler)
            if own @ other > ALIKE * np.linalg.norm(own) * max(float(np.linalg.norm(other)), 1e-300):
                out[one.name] = None
    return tuple(out)


def _footprint(one: Tried, nothing: TunedKnobs, scatter: Scatter, ruler: Ruler) -> Vector:
    """(2 n,) what an explanation changes beyond what known values may, whitened."""
    zero = np.zeros(len(scatter))
    excess, renewal = one.turned.excess() - nothing.excess(), one.turned.renewal() - nothing.renewal()
    return ruler.white(scatter, excess + zero, renewal + zero)
