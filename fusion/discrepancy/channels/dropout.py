"""The dropout channel: are values missing where the model says so, and which effect would lose them?"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc

from fusion.discrepancy.channels.channel_step import ChannelStep
from fusion.discrepancy.channels.losses import likeliest_limit, loss_step
from fusion.discrepancy.channels.noise_parameters import USUAL, with_value
from fusion.discrepancy.channels.validity import LEAST_LOST, Validity, validity_of, validity_of_rims
from fusion.discrepancy.decisions import ALIKE, FAR, LOST_BY_CHANCE, REPLICATED, SURE
from fusion.discrepancy.observe.observations import Observations
from fusion.sensor.effect import Effect
from fusion.sensor.effects import EFFECTS
from fusion.sensor.parameter import Parameter, parameters
from fusion.sensor.sensor import Sensor

Vector = NDArray[np.float64]
# an effect, what of it is searched, and what of the model it stands for
LostForm = tuple[Effect, Parameter, Effect | None]

LEAST_FRAMES = 3
SIZES = np.geomspace(0.02, 50.0, 33)  # of a typical size, that are tried
FINE = np.linspace(-1.0, 1.0, 13)  # between two of them, then between two of these
NEAR = 5.0  # times what pixels see of a shadow, within which the scene is asked for it
END_PX = 0.4  # by which the number of pixels of a row is off that an interval holds: each end by up to half a pixel
DRAWS = 200  # of weights of the recordings, by which a spread is told to 5 %
BEYOND = 3.0  # standard deviations by which a stated value must be off
EXPLAINED = 0.7  # of what is too much: less, and the name is not the right one
MOST_STEPS = 2


@dataclass(frozen=True)
class Lost:
    """One effect at its best size."""

    effect: Effect  # it
    parameter: Parameter  # what was searched
    std: float  # of it
    corrected: bool  # the model holds it, at another value
    costs: Vector  # (recordings,) chi2 in each
    held_out: Vector  # (recordings,) chi2 in each at the size that is best in the others
    share: Vector  # (n,) of missing values then


def dropout_steps(observations: Observations) -> tuple[Sensor, tuple[ChannelStep, ...]]:
    """The model with what its validity lacks, and every step towards it."""
    sensor = observations.sensor
    patches = [p for p in observations.patches if len(p.block.frames) >= LEAST_FRAMES]
    steps: list[ChannelStep] = []
    seen, forms = validity_of_rims(sensor, patches), list(_forms_of_edges(sensor))
    found = None if seen is None or not forms else _step(sensor, seen, forms)
    if found is not None:
        sensor, step = found
        steps.append(step)
    for _ in range(MOST_STEPS):
        seen = validity_of(sensor, patches)
        found = None if seen is None else _step(sensor, seen, list(_forms(sensor, recorded_light(seen))))
        if seen is None or found is None:
            break
        sensor, step = _or_limit(seen, sensor, *found)
        steps.append(step)
    else:
        seen = None
    last = None if seen is None or _uncertain(sensor, seen) else loss_step(sensor, seen)
    return sensor, tuple(steps) if last is None else (*steps, last)


def recorded_light(seen: Validity) -> bool:
    """True when every block has its amplitude recorded: without it no model knows where too little light comes back."""
    return all(patch.block.view.ir is not None for patch in seen.patches)


def _step(sensor: Sensor, seen: Validity, forms: Sequence[LostForm]) -> tuple[Sensor, ChannelStep] | None:
    now = seen.share()
    before = _costs(seen, now)
    if float(before.sum()) < len(now):
        return None
    tried = [_searched(seen, *form) for form in forms]
    if not tried:
        return None
    best = min(tried, key=lambda one: float(one.costs.sum()))
    gain = float(before.sum() - best.costs.sum())
    probability = float(min(1.0, len(tried) * len(SIZES) * chdtrc(1, max(gain, 0.0))))
    excess = float(before.sum()) - len(now)
    change = best.share - now
    if probability > LOST_BY_CHANCE or float(np.max(np.abs(change))) < LEAST_LOST or gain < EXPLAINED * excess:
        return None
    if len(before) > 2 and float((before - best.held_out).sum()) < REPLICATED * gain:
        return None
    name = best.parameter.name
    if best.corrected and not _beyond(sensor, best):
        return None
    others = [one for one in tried if one.effect.name != best.effect.name and _like(one.share - now, change)]
    alike = sorted({one.effect.name for one in others if before.sum() - one.costs.sum() > ALIKE * gain})
    better = sensor.having(best.effect)
    better = replace(better, std={**better.std, (best.effect.name, name): best.std})
    share = gain / max(float(before.sum()), 1e-9)
    return better, ChannelStep(
        "dropout", best.effect, {name: best.std}, best.corrected, gain, share, probability, tuple(alike)
    )


def _or_limit(seen: Validity, sensor: Sensor, better: Sensor, step: ChannelStep) -> tuple[Sensor, ChannelStep]:
    """What was named; a limit of the working range in its place, where that is clearly the likelier of the two.

    Light falls with distance: where little comes back, or too much, there is far, or near.
    """
    limit = likeliest_limit(seen, lambda share: _costs(seen, share))
    before = float(_costs(seen, seen.share()).sum())
    gain = before - float(limit.costs.sum())
    if gain - step.gain < SURE:
        return better, step
    found = replace(limit.step, gain=gain, share=gain / max(before, 1e-9), probability=step.probability)
    return found.added_to(sensor), found


def _uncertain(sensor: Sensor, seen: Validity) -> bool:
    """True when a number that the model holds explains what is too much: it may be off by that."""
    before = float(_costs(seen, seen.share()).sum())
    excess = before - len(seen.missing)
    if excess <= 0:
        return True
    own = (form for form in _forms(sensor, recorded_light(seen)) if form[2] is not None)
    return any(before - float(_searched(seen, *form).costs.sum()) > EXPLAINED * excess for form in own)


def _forms(sensor: Sensor, light: bool) -> Iterator[LostForm]:
    """Effects, what of them is searched, and what of the model they stand for.

    An effect that changes the noise too is found by it: no light takes values away without adding noise.
    """
    for kind in EFFECTS:
        if not kind.changes("dropout") or kind.changes("noise") or ("amplitude" in kind.variables and not light):
            continue
        if kind.principles and sensor.principle not in kind.principles:
            continue
        own = sensor.effect(kind.name)
        for about in parameters(kind).values():
            if about.neutral == 0 and about.kind in ("number", "scalar"):
                exact = own is not None and sensor.std.get((kind.name, about.name)) == 0.0
                if not exact and (own is None or np.ndim(getattr(own, about.name)) == 0):
                    yield own or kind(), about, own
                break


def _forms_of_edges(sensor: Sensor) -> Iterator[LostForm]:
    """Effects beside depth edges that the model lacks, to either side."""
    for kind in EFFECTS:
        if not kind.changes("dropout") or "edge" not in kind.variables or sensor.effect(kind.name) is not None:
            continue
        if not kind.principles or sensor.principle in kind.principles:
            about = next(iter(parameters(kind).values()))
            yield from ((kind(), replace(about, typical=side * about.typical), None) for side in (1.0, -1.0))


def _searched(seen: Validity, effect: Effect, about: Parameter, own: Effect | None) -> Lost:
    """The size that explains the missing values best."""
    stated = float(getattr(effect, about.name)) if own is not None else 0.0
    usual = abs(stated) if stated else about.typical
    exact = own is None and seen.exact(effect)

    shares: dict[float, Vector] = {}
    rows: dict[float, Vector] = {}

    def cost(sizes: Vector, exact: bool) -> float:
        for size in np.clip(sizes, about.low, about.high).tolist():
            if size not in rows:
                shares[size] = seen.share(with_value(effect, about, size), own, exact)
                rows[size] = _costs(seen, shares[size], exact)
        return min(rows, key=lambda size: float(rows[size].sum()))

    step, best = SIZES[1] / SIZES[0], cost(usual * SIZES, False)
    if exact:
        rows.clear()  # where a shadow is narrow, pixels see another one than there is
        best = cost(best * SIZES[(SIZES > 1 / NEAR) & (SIZES < NEAR)], True)
    for _ in range(2):
        best = cost(best * step**FINE, exact)
        step = step ** (FINE[1] - FINE[0])
    tried, table = np.array(list(rows)), np.array(list(rows.values()))
    without = np.argmin(table.sum(axis=1)[:, None] - table, axis=0)
    held = np.array([_costs(seen, shares[tried[k]])[g] for g, k in enumerate(without)])
    whole, some = table.sum(axis=1), (shares[best] > LEAST_LOST) | (seen.missing > LEAST_LOST)
    near = tried[whole < whole.min() + max(1.0, float(whole.min()) / max(1, int(some.sum())))]
    # tiles of one edge are off together: by how much it moves where other recordings count more (Rubin, 1981)
    count = table.shape[1]
    weights = np.random.default_rng(0).exponential(size=(count, DRAWS))
    apart = np.sqrt((count + 1) / max(count - 1, 1)) * np.std(tried[np.argmin(table @ weights, axis=0)])
    if exact:
        about_it = tried[np.abs(np.log(tried / best)) <= np.log(SIZES[1] / SIZES[0])]
        apart = max(
            apart, _posed(seen, *(shares[size] for size in (about_it.min(), about_it.max()))) * np.ptp(about_it)
        )
    std = float(max(np.max(np.abs(near - best)), abs(best) * (step - 1.0), apart))
    costs = _costs(seen, shares[best])
    return Lost(with_value(effect, about, best), about, std, own is not None, costs, held, shares[best])


def _posed(seen: Validity, one: Vector, other: Vector) -> float:
    """Standard deviation of a size, of the way from one share (n,) to another, where all that is seen of a recording
    stands beside where its pose says, and what is missing ends there."""
    change, off = other - one, 0.0
    for place in np.unique(seen.place):
        patch = next(p for p in seen.patches if p.block.place == place)
        stage, focal = patch.block.stage, patch.view.camera.fx
        moved_px = focal * np.hypot(stage.sigma_rad, stage.sigma_m / float(np.nanmedian(patch.depth)))
        off += (moved_px / seen.patches[0].tiles.side * float(np.abs(change[seen.place == place]).sum())) ** 2
    return float(np.sqrt(off) / max(float(change @ change), 1e-9))


def _costs(seen: Validity, share: Vector, ending: bool = False) -> Vector:
    """(recordings,) chi2 of the tiles of each, tamed.

    Args:
        ending: what is missing ends along lines: the pixels of a line go together.
    """
    sigma = np.hypot(seen.sigma(share), END_PX / seen.patches[0].tiles.side if ending else 0.0)
    size = np.abs(seen.missing - share) / sigma
    tamed = np.where(size > FAR, 2 * FAR * size - FAR**2, size**2)
    return np.array([tamed[seen.place == g].sum() for g in np.unique(seen.place)])


def _beyond(sensor: Sensor, best: Lost) -> bool:
    """True when a value that the model states is further off than both it and the fit are uncertain."""
    key = (best.effect.name, best.parameter.name)
    own = sensor.effect(best.effect.name)
    stated = float(getattr(own, best.parameter.name))
    known = float(np.max(sensor.std.get(key, USUAL * abs(stated))))
    off = abs(float(getattr(best.effect, best.parameter.name)) - stated)
    return off > BEYOND * float(np.hypot(known, best.std))


def _like(one: Vector, other: Vector) -> bool:
    return float(one @ other) > ALIKE * float(np.linalg.norm(one)) * float(np.linalg.norm(other))
