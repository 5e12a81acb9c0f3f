"""Many units of one camera, measured on one or several dates: how far they spread, and whether they drift.

One-way analysis of variance with random effects (ISO 5725-2, the layout of repeatability and reproducibility), depth by
depth: units are the groups, the dates of a unit its repetitions; and one slope over time common to all units, each with
a mean of its own.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from fusion.errors import SensorError
from fusion.geometry.camera import Camera
from fusion.progress import each
from fusion.sensor.sensor import Sensor
from fusion.simulation.exporting.loss import DEPTHS, stated

SURE = 0.95  # of intervals


@dataclass(frozen=True)
class Measured:
    """A model of one unit on one date."""

    unit: str  # its number or name
    date: float  # years, from any one day on; NaN where it is not known
    sensor: Sensor  # what was measured


@dataclass(frozen=True)
class Interval:
    """A value for each depth (n,) and the ends of its 95 % interval; NaN where nothing is known of it."""

    value: NDArray[np.float64]
    low: NDArray[np.float64]
    high: NDArray[np.float64]


@dataclass(frozen=True)
class ModelFigures:
    """One model: of which unit, from which date, and what it says at each depth."""

    unit: str
    date_years: float
    bias_m: NDArray[np.float64]
    sigma_m: NDArray[np.float64]


@dataclass(frozen=True)
class UnitsFigures:
    """The content of `units.json`: see `Units`."""

    depths_m: NDArray[np.float64]
    units: tuple[str, ...]
    models: tuple[ModelFigures, ...]
    between: Interval
    within: Interval
    drift: Interval


@dataclass(frozen=True)
class Units:
    """m models of u units at n depths."""

    depths: NDArray[np.float64]  # (n,) [m]
    names: tuple[str, ...]  # of the units
    unit: NDArray[np.int64]  # (m,) which each model is of
    date: NDArray[np.float64]  # (m,) [years], NaN where it is not known
    # bias, sigma: (m, n) mean error and spread of repeated frames [m], over the image before frontal walls
    bias: NDArray[np.float64]
    sigma: NDArray[np.float64]
    between: Interval  # standard deviation between units [m], what repetitions explain taken off where there are any
    within: Interval  # standard deviation between the dates of a unit [m]; NaN where none has two
    drift: Interval  # change per year [m]

    def figures(self) -> UnitsFigures:
        """What `units.json` holds."""
        rows = zip(self.unit, self.date, self.bias, self.sigma, strict=True)
        models = tuple(ModelFigures(self.names[u], float(d), b, s) for u, d, b, s in rows)
        return UnitsFigures(self.depths, self.names, models, self.between, self.within, self.drift)


def units(models: Sequence[Measured], camera: Camera) -> Units:
    """Compare models of units, each before frontal white walls seen by one camera.

    Raises:
        SensorError: fewer than two units, or models of different principles.
    """
    names = tuple(dict.fromkeys(one.unit for one in models))
    if len(names) < 2:
        raise SensorError("one unit alone has no spread", found=names, expected="models of two or more units")
    kinds = sorted({one.sensor.principle for one in models})
    if len(kinds) > 1:
        raise SensorError("these are different cameras", found=", ".join(kinds), expected="units of one camera")
    said = [stated(one.sensor, camera) for one in each(models, "models")]
    bias, sigma = (np.stack([getattr(s, name) for s in said]) for name in ("mean_bias", "rms_sigma"))
    unit = np.array([names.index(one.unit) for one in models])
    date = np.array([one.date for one in models])
    between, within = spreads(bias, unit)
    return Units(np.array(DEPTHS), names, unit, date, bias, sigma, between, within, drift(bias, unit, date))


def spreads(values: NDArray[np.float64], unit: NDArray[np.int64]) -> tuple[Interval, Interval]:
    """Standard deviations between the groups and within them of values (m, n); unit (m,) is 0, 1, ... for each row."""
    count = np.bincount(unit)
    means = np.stack([values[unit == u].mean(axis=0) for u in range(len(count))])
    squares = ((values - means[unit]) ** 2).sum(axis=0)
    free = len(unit) - len(count)
    noise = squares / free if free else np.full(values.shape[1], np.nan)
    nothing = np.zeros_like(noise)
    taken = np.where(np.isnan(noise), nothing, noise) * (1 / count).mean()  # of a mean's variance, by repetitions
    scatter = means.var(axis=0, ddof=1)
    ends = [scatter * (len(count) - 1) / stats.chi2.ppf(p, len(count) - 1) for p in ((1 + SURE) / 2, (1 - SURE) / 2)]
    between = Interval(*(np.sqrt(np.maximum(v - taken, 0.0)) for v in (scatter, *ends)))
    if not free:
        unknown = np.full(values.shape[1], np.nan)
        return between, Interval(unknown, unknown, unknown)
    low, high = (np.sqrt(squares / stats.chi2.ppf(p, free)) for p in ((1 + SURE) / 2, (1 - SURE) / 2))
    return between, Interval(np.sqrt(noise), low, high)


def drift(values: NDArray[np.float64], unit: NDArray[np.int64], date: NDArray[np.float64]) -> Interval:
    """Slope of values (m, n) over time (m,) [per year], common to all units, each with a mean of its own."""
    known = np.isfinite(date)
    values, unit, date = values[known], unit[known], date[known]
    unknown = np.full(values.shape[1], np.nan)
    groups = np.unique(unit)
    centred = np.zeros(len(date))
    rest = np.zeros_like(values)
    for u in groups:
        centred[unit == u] = date[unit == u] - date[unit == u].mean()
        rest[unit == u] = values[unit == u] - values[unit == u].mean(axis=0)
    spread, free = float((centred**2).sum()), len(date) - len(groups) - 1
    if spread == 0 or free < 1:
        return Interval(unknown, unknown, unknown)
    slope = centred @ rest / spread
    error = np.sqrt(((rest - np.outer(centred, slope)) ** 2).sum(axis=0) / free / spread)
    reach = error * stats.t.ppf((1 + SURE) / 2, free)
    return Interval(slope, slope - reach, slope + reach)
