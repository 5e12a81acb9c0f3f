"""The amplitude channel: which effect of the light, that no depth shows, do amplitude images tell of?

An effect takes part by what it declares: whatever changes the light is asked, and what changes nothing else is named.
Recordings are the replicates: tiles of one image share its target, of which nobody knows how it is painted.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc, stdtr

from fusion.discrepancy.channels.channel_step import ChannelStep
from fusion.discrepancy.channels.losses import NAMED
from fusion.discrepancy.channels.noise_parameters import with_value
from fusion.discrepancy.decisions import DETECTED, FALSE_ALARM, FEWEST, REPLICATED, SURE
from fusion.discrepancy.light.lit import LitTiles, Matrix, Vector, lit_of
from fusion.discrepancy.naming.heterogeneity import FORM
from fusion.discrepancy.observe.observations import Observations
from fusion.sensor.effect import Effect
from fusion.sensor.effects import EFFECTS
from fusion.sensor.parameter import Parameter, parameters
from fusion.sensor.sensor import Sensor

FAINT = 0.1  # of the length of a footprint, that all other causes must leave: they are known to no more (guess)
BESIDE = ("bias", "noise", "spread", "dropout")  # what tells of an effect elsewhere


@dataclass(frozen=True)
class LightForm:
    """An effect that the model lacks, and its size."""

    kind: type[Effect]
    parameter: Parameter

    @property
    def alone(self) -> bool:
        """True when nothing but the light tells of it."""
        return not any(self.kind.changes(channel) for channel in BESIDE)

    def at(self, size: float) -> Effect:
        return with_value(self.kind(), self.parameter, size)


@dataclass(frozen=True)
class LightFit:
    """One footprint (n,) per typical size, beside all that is no matter of the sensor."""

    form: LightForm
    lit: LitTiles
    # in units of what a tile may be off: excess (n,), causes (n, k), footprint (n,)
    excess: Vector
    causes: Matrix
    footprint: Vector

    @cached_property
    def free(self) -> tuple[Vector, Vector]:
        """Footprint and excess (n,) without what the causes may make of them."""
        return _beyond(self.causes, self.footprint), _beyond(self.causes, self.excess)

    @cached_property
    def power(self) -> float:
        """Square of the footprint's length; 0 where nothing of it is left."""
        power, whole = float(self.free[0] @ self.free[0]), float(self.footprint @ self.footprint)
        return power if power > FAINT**2 * whole else 0.0

    @cached_property
    def size(self) -> float:
        """The likeliest, in typical sizes."""
        return float(self.free[0] @ self.free[1]) / self.power if self.power else 0.0

    @property
    def gain(self) -> float:
        """Drop of the chi2."""
        return self.size**2 * self.power

    @cached_property
    def without(self) -> tuple[Vector, Vector]:
        """(recordings,) likeliest size without each, and how much each then lacks less chi2 by it."""
        sizes, gains = [], []
        for one in range(len(self.lit.patches)):
            rest = self.lit.place != one
            columns = np.column_stack([self.footprint, self.causes])
            found = np.linalg.lstsq(columns[rest], self.excess[rest])[0]
            print_, excess = self.free[0][~rest], self.free[1][~rest]
            sizes.append(found[0])
            gains.append(2 * found[0] * (print_ @ excess) - found[0] ** 2 * (print_ @ print_))
        return np.array(sizes), np.array(gains)

    @property
    def several(self) -> float:
        """Recordings that tell of it, in effect."""
        own = np.bincount(self.lit.place, self.free[0] ** 2)
        return float(own.sum() ** 2 / (own @ own))

    @property
    def std(self) -> float:
        """Of the size: of the fit, and by how much it moves when a recording is left out."""
        count, without = len(self.lit.patches), self.without[0]
        moved = np.sqrt((count - 1) / count * np.sum((without - without.mean()) ** 2))
        return float(np.hypot(moved, 1 / np.sqrt(self.power)))


def amplitude_steps(observations: Observations) -> tuple[Sensor, tuple[ChannelStep, ...]]:
    """The model with what its light lacks, and the finding; nothing where amplitudes tell of no effect alone."""
    sensor, fits, fields = _asked(observations)
    told = [fit for fit in fits if fit.gain]
    if not told:
        return sensor, ()
    best = max(told, key=lambda fit: fit.gain)
    value, about = best.size * best.form.parameter.typical, best.form.parameter
    if not best.form.alone or best.several < FEWEST or not about.low <= value <= about.high:
        return sensor, ()
    chance = float(stdtr(best.several - 1, -abs(best.size) / best.std)) * 2 * len(told)
    chance = min(1.0, max(chance, float(chdtrc(1, best.gain)) * len(told)))
    if chance > FALSE_ALARM or best.gain < NAMED * fields:
        return sensor, ()
    least = best.gain - max(SURE, FORM * best.gain)
    alike = tuple(fit.form.kind.name for fit in told if fit is not best and fit.gain > least)
    # what any field explains beyond it is a matter of its form: by as much its size may be off
    form = abs(best.size) * float(np.sqrt(max(fields - best.gain, 0.0) / fields))
    effect, std = best.form.at(value), float(np.hypot(best.std, form)) * about.typical
    whole = float(best.free[1] @ best.free[1])
    step = ChannelStep(
        "amplitude",
        effect,
        {about.name: std},
        False,
        best.gain,
        best.gain / whole,
        chance,
        alike,
        established=bool(best.without[1].sum() >= REPLICATED * best.gain),
    )
    better = sensor.having(effect)
    return replace(better, std={**better.std, (effect.name, about.name): std}), (step,)


def shown_by_light(observations: Observations) -> set[str]:
    """Names of effects that nothing but the amplitude tells of, and it would."""
    fits = _asked(observations)[1]
    return {fit.form.kind.name for fit in fits if fit.form.alone and fit.power and fit.std < 1 / DETECTED}


def _asked(observations: Observations) -> tuple[Sensor, Sequence[LightFit], float]:
    """The model, every effect that changes the light, and the drop of the chi2 by any field of the image."""
    sensor, forms = observations.sensor, list(_forms(observations.sensor))
    lit = lit_of(observations) if any(form.alone for form in forms) else None
    if lit is None:
        return sensor, (), 0.0
    with np.errstate(all="ignore"):
        prints = np.column_stack([np.nan_to_num(lit.change(sensor, form.at(form.parameter.typical))) for form in forms])
    white = lit.whitened(np.column_stack([lit.excess, prints, lit.fields, lit.causes]))
    count, wide = len(forms), lit.fields.shape[1]
    excess, prints, fields, causes = np.split(white, np.cumsum([1, count, wide]), axis=1)
    fits = [LightFit(form, lit, excess[:, 0], causes, prints[:, k]) for k, form in enumerate(forms)]
    beyond = _beyond(causes, excess[:, 0])
    left = _beyond(np.column_stack([causes, fields]), excess[:, 0])
    return sensor, fits, float(beyond @ beyond - left @ left)


def _forms(sensor: Sensor) -> Iterator[LightForm]:
    for kind in EFFECTS:
        if not kind.changes("light") or (kind.principles and sensor.principle not in kind.principles):
            continue
        about = next((one for one in parameters(kind).values() if one.neutral == 0), None)
        if about is not None and sensor.effect(kind.name) is None:
            yield LightForm(kind, about)


def _beyond(columns: Matrix, values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Values (n,) without what columns (n, k) can make of them."""
    return np.asarray(values - columns @ np.linalg.lstsq(columns, values)[0])
