"""Many units of one camera: spread between and within units, and drift, found again where they are known."""

import numpy as np
import pytest

from fusion.errors import SensorError
from fusion.sensor.effects import EFFECTS
from fusion.sensor.sensor import Sensor
from fusion.simulation.exporting.loss import usual_camera
from fusion.simulation.exporting.units import Measured, drift, spreads, units

OFFSET = next(kind for kind in EFFECTS if kind.name == "depth_offset")


def offset(value: float, principle: str = "itof") -> Sensor:
    return Sensor(name="one", principle=principle, effects=(OFFSET(offset=value),), fitted=frozenset({"depth_offset"}))


def drawn(rng, dates: int, between: float, within: float, slope: float = 0.0, count: int = 8):
    """Values (m, 1) of units, each on some dates, with their unit and date."""
    unit = np.repeat(np.arange(count), dates)
    date = np.tile(np.arange(dates, dtype=float), count)
    values = rng.normal(0, between, count)[unit] + rng.normal(0, within, len(unit)) + slope * date
    return values[:, None], unit, date


@pytest.mark.parametrize("dates, within", [(1, 0.0), (3, 0.5)])
def test_intervals_of_the_spread_hold_the_truth_as_often_as_they_say(dates, within):
    rng, held = np.random.default_rng(3), []
    for _ in range(2000):
        values, unit, _ = drawn(rng, dates, between=2.0, within=within)
        between, inside = spreads(values, unit)
        held.append([between.low[0] <= 2.0 <= between.high[0], dates == 1 or inside.low[0] <= within <= inside.high[0]])
    shares = np.mean(held, axis=0)
    assert abs(shares[0] - 0.95) < 3 * 0.005 and shares[1] > 0.95 - 3 * 0.005  # 2000 draws


def test_dates_that_differ_are_not_counted_as_units_that_do():
    rng = np.random.default_rng(4)
    found = [spreads(*drawn(rng, 4, between=0.0, within=1.0)[:2])[0].value[0] for _ in range(200)]
    assert np.mean(found) < 0.25  # 0.5 would be the scatter of means of four


def test_a_drift_is_found_and_none_is_said_where_there_is_none():
    rng, held, none = np.random.default_rng(5), [], []
    for _ in range(2000):
        slope = drift(*drawn(rng, 3, 2.0, 0.3, slope=0.7))
        held.append(slope.low[0] <= 0.7 <= slope.high[0])
        flat = drift(*drawn(rng, 3, 2.0, 0.3))
        none.append(flat.low[0] <= 0 <= flat.high[0])
    assert min(np.mean(held), np.mean(none)) > 0.95 - 3 * 0.005  # 2000 draws


def test_no_dates_tell_no_drift():
    values, unit, date = drawn(np.random.default_rng(6), 1, 1.0, 0.0)
    assert np.isnan(drift(values, unit, date).value).all()
    assert np.isnan(drift(values, unit, np.full(len(unit), np.nan)).value).all()


def test_models_of_units():
    values = {"a": (0.001, 0.003), "b": (0.005, 0.007), "c": (0.0, 0.002)}
    models = [Measured(name, year, offset(pair[year])) for name, pair in values.items() for year in (0, 1)]
    found = units(models, usual_camera(models[0].sensor))
    slant = found.bias[0, 0] / 0.001  # an offset lies along the ray: less of it in z, over the image
    assert 0.8 < slant < 1.0
    np.testing.assert_allclose(found.drift.value, 0.002 * slant, rtol=1e-3)
    np.testing.assert_allclose(found.bias[2], 0.005 * slant, rtol=1e-3)
    # each unit drifts by as much: the dates of a unit spread by sqrt(2) mm, its mean of two by 1 mm
    np.testing.assert_allclose(found.within.value, np.sqrt(2) * 1e-3 * slant, rtol=1e-3)
    np.testing.assert_allclose(found.between.value, np.sqrt(np.var([2, 6, 1], ddof=1) - 1) * 1e-3 * slant, rtol=1e-3)
    assert found.figures().units == ("a", "b", "c")


def test_what_cannot_be_compared_is_refused():
    with pytest.raises(SensorError, match="one unit alone"):
        units([Measured("a", 0.0, offset(0.0)), Measured("a", 1.0, offset(0.0))], usual_camera(offset(0.0)))
    with pytest.raises(SensorError, match="different cameras"):
        units(
            [Measured("a", 0, offset(0.0)), Measured("b", 0, offset(0.0, "structured_light"))],
            usual_camera(offset(0.0)),
        )
