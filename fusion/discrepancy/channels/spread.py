"""The spread channel: is the noise of repeated frames what the model says, and which effect would make it so?"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from fusion.discrepancy.observations import Observations, Patch
from fusion.sensor.effect import Effect
from fusion.sensor.effects import EFFECTS
from fusion.sensor.effects.readout.axial_noise import AxialNoise
from fusion.sensor.effects.readout.depth_quantization import DepthQuantization
from fusion.sensor.parameter import Parameter, parameters
from fusion.sensor.sensor import Sensor

Vector = NDArray[np.float64]

LEAST_FRAMES = 4  # a variance from fewer says little
FLOOR = 0.03  # of a variance: what the model of the noise leaves open, from recordings in which nothing is missing
SIZES = np.geomspace(0.03, 10.0, 11)  # of a typical size, that are tried
FALSE_ALARM = 1e-12  # the noise model is a model: what is improbable by chance alone is common by its faults
LEAST_CHANGE = 0.15  # of a variance, in the tiles that change most: below, it is a matter of the noise model
ALIKE = 0.95


@dataclass(frozen=True)
class SpreadStep:
    """An effect that explains the noise.

    Attributes:
        effect: with fitted size.
        parameter: which of its parameters was fitted.
        std: of that parameter.
        gain: drop of the chi2 of the spread channel.
        share: of that chi2.
        probability: that noise alone does this, over all names and sizes.
        alike: names that this data cannot tell from it.
    """

    effect: Effect
    parameter: Parameter
    std: float
    gain: float
    share: float
    probability: float
    alike: tuple[str, ...]


def spread_step(observations: Observations) -> SpreadStep | None:
    """The effect that best explains the noise beyond the model, when it passes the tests; else None."""
    patches = [p for p in observations.patches if len(p.look.frames) >= LEAST_FRAMES]
    if not patches:
        return None
    excess, weight = _excess(patches)
    known = _known(observations.sensor, patches)
    place = np.concatenate([np.full(len(p.tiles), p.look.place) for p in patches])
    white = _without(excess * weight, known, weight)
    inflated = max(1.0, float((np.median(np.abs(white)) / 0.6745) ** 2))
    scored: list[tuple[float, Effect, Parameter, float, Vector]] = []
    for effect, about in _forms(observations.sensor):
        grown = _growth(effect, patches)
        for factor in SIZES:
            # noise adds in squares, so the variance grows with the square of the size
            change = _without(np.log(np.maximum(1 + factor**2 * grown, 1e-6)) * weight, known, weight)
            tried = float(factor * about.typical)
            gain = float(white @ white - ((white - change) ** 2).sum())
            if about.low <= tried <= about.high:
                scored.append((gain, replace(effect, **{about.name: tried}), about, tried, change))
    if not scored:
        return None
    best, effect, about, size, change = max(scored, key=lambda entry: entry[0])
    probability = float(min(1.0, len(scored) * chi2.sf(max(best, 0.0) / inflated, 1)))
    within = np.array([_gain(white[place == g], change[place == g]) for g in np.unique(place)])
    strong = bool(np.quantile(np.abs(change / weight), 0.9) > LEAST_CHANGE)
    # no single recording may bring it all, where several could
    alone = len(within) > 2 and float(np.max(within)) > 0.8 * float(np.sum(within))
    if probability > FALSE_ALARM or not strong or alone:
        return None
    alike = {
        other.name
        for _, other, _, _, footprint in scored
        if other.name != effect.name and footprint @ change > ALIKE * np.linalg.norm(footprint) * np.linalg.norm(change)
    }
    # the spread of a logarithm of a variance is linear in the square of a size
    std = 0.5 * size * float(np.sqrt(inflated / max(float(change @ change), 1e-300)))
    return SpreadStep(effect, about, std, best, best / float(white @ white), probability, tuple(sorted(alike)))


def _excess(patches: Sequence[Patch]) -> tuple[Vector, Vector]:
    """Logarithm (n,) of the measured over the predicted variance of each tile, and one over its standard deviation."""
    values, weights = [], []
    for patch in patches:
        freedom = len(patch.look.frames) - 1
        measured = patch.tiles.mean(np.nan_to_num(patch.look.std * patch.native) ** 2)
        predicted = patch.tiles.mean((patch.sigma * patch.native) ** 2)
        values.append(np.log(np.maximum(measured, 1e-12) / np.maximum(predicted, 1e-12)))
        weights.append(
            1.0 / np.sqrt(2.0 * _window(patch) / (freedom * patch.tiles.pixels) + (FLOOR + _undithered(patch)) ** 2)
        )
    return np.concatenate(values), np.concatenate(weights)


def _undithered(patch: Patch) -> float:
    """How far a variance may wander (share of it) with the place between two steps of the rounding."""
    rounding = next((e for e in patch.sensor.effects if isinstance(e, DepthQuantization)), None)
    if rounding is None:
        return 0.0
    slope = float(np.nanmedian(np.abs(patch.native)))
    step = float(np.mean(rounding.step)) * slope
    if not patch.view.time_of_flight:
        step = max(step, float(np.mean(rounding.step_px)))
    total = float(np.sqrt(patch.tiles.mean((patch.sigma * patch.native) ** 2).mean()))
    before = np.sqrt(max(total**2 - step**2 / 12, 0.0))
    # the first harmonic of the rounding's own error, which fades as the noise grows over a step
    return 4.0 * float(np.exp(-2 * np.pi**2 * (before / step) ** 2)) if step > 0 else 0.0


def _window(patch: Patch) -> float:
    """Pixels that share their noise, in effect."""
    axial = next((e for e in patch.sensor.effects if isinstance(e, AxialNoise)), None)
    if axial is None or patch.view.time_of_flight or not np.any(axial.sigma_px):
        return 1.0
    side = max(1.0, float(np.mean(axial.correlation_px)))
    # sum of the squared correlations 1 - d / side over both directions
    lags = np.arange(1, int(np.ceil(side)))
    return float((1 + 2 * ((1 - lags / side) ** 2).sum()) ** 2)


def _growth(effect: Effect, patches: Sequence[Patch]) -> Vector:
    """By how much (n,) an effect makes the variance of each tile grow, as a share of it."""
    out = []
    for patch in patches:
        with np.errstate(all="ignore"):
            sigma = effect.spread(patch.sigma, patch.depth, patch.view)
        new, old = (patch.tiles.mean((s * patch.native) ** 2) for s in (sigma, patch.sigma))
        out.append(new / np.maximum(old, 1e-300) - 1.0)
    return np.concatenate(out)


def _forms(sensor: Sensor) -> Iterator[tuple[Effect, Parameter]]:
    """Effects at their typical size that change the noise and that the model does not hold."""
    for kind in EFFECTS:
        changes = (kind.changes("noise") or kind.changes("spread")) and not kind.frozen
        if not changes or sensor.effect(kind.name) or (kind.principles and sensor.principle not in kind.principles):
            continue
        sizes = [p for p in parameters(kind).values() if p.neutral == 0 and p.kind in ("number", "scalar", "list")]
        for about in sizes[:1]:
            yield kind(**{about.name: about.typical}), about


def _known(sensor: Sensor, patches: Sequence[Patch]) -> Vector:
    """(n, k) change of the logarithm of the variance per standard deviation of each known noise parameter."""
    columns = []
    for effect in sensor.effects:
        for name, about in parameters(effect).items():
            std, value = float(np.max(sensor.std.get((effect.name, name), 0.0))), getattr(effect, name)
            if std > 0 and not np.ndim(value) and effect.changes("noise") and not effect.frozen:
                other = replace(effect, **{name: float(np.clip(value + std, about.low, about.high))})
                columns.append(_difference(effect, other, patches))
    n = sum(len(p.tiles) for p in patches)
    return np.column_stack(columns) if columns else np.zeros((n, 0))


def _difference(own: Effect, other: Effect, patches: Sequence[Patch]) -> Vector:
    """Change (n,) of the logarithm of the variance when one effect of the model is another."""
    out = []
    for patch in patches:
        with np.errstate(all="ignore"):
            squares = other.noise(patch.depth, patch.view) ** 2 - own.noise(patch.depth, patch.view) ** 2
        old = patch.tiles.mean((patch.sigma * patch.native) ** 2)
        out.append(patch.tiles.mean(squares * patch.native**2) / np.maximum(old, 1e-300))
    return np.concatenate(out)


def _without(values: Vector, known: Vector, weight: Vector) -> Vector:
    """Whitened values (n,) less what known parameters explain within their standard deviations (ridge)."""
    if not known.shape[1]:
        return values
    A = known * weight[:, None]
    return np.asarray(values - A @ np.linalg.solve(A.T @ A + np.eye(A.shape[1]), A.T @ values))


def _gain(white: Vector, change: Vector) -> float:
    return max(float(white @ white - ((white - change) ** 2).sum()), 0.0)
