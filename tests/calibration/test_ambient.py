"""Ambient light from the noise: between the laws for a room, clouds and sun."""

import numpy as np
import pytest
from made_up_targets import TOF, grid

from fusion.calibration.noise.ambient import LightPoint, estimate_ambient, points_of
from fusion.calibration.noise.laws.light_law import effective, light_law
from fusion.geometry.camera import Camera
from fusion.sensor.presets import preset

PLACES = [(0.8, 0.0), (1.2, 0.5), (1.6, 0.2), (2.0, 0.9)]
OTHER = Camera(64, 48, 60.0, 60.0, 31.5, 23.5, principle="structured_light", sensor="other")


def points(lux: float, rng: np.random.Generator, unit: float = 0.0, law=None) -> list[LightPoint]:
    """Noise at some places in this light, of a unit that is noisier by a share, with scatter of 3 %."""
    law = law or light_law(None, TOF)
    z, tilt = np.array(PLACES).T
    sigma = np.sqrt(law.variance(z, tilt, lux)) * np.exp(unit + 0.03 * rng.standard_normal(len(z)))
    return [LightPoint(*row, 0.01 * row[2]) for row in zip(z, tilt, sigma, strict=True)]


@pytest.mark.parametrize(("name", "low", "high"), [("overcast", 1e3, 12e3), ("sunlight", 70e3, 110e3)])
def test_the_papers_own_laws_are_their_own_light(name, low, high):
    law = preset(f"kinect-v2-{name}").effect("axial_noise")
    found = estimate_ambient(points_of(grid(law, np.random.default_rng(0), (1.0, 1.4, 1.8), (0, 30, 45))), TOF)
    assert low <= found.lux <= high
    assert found.low < found.noise_low < found.lux < found.noise_high < found.high


def test_a_room_is_only_bounded_from_above():
    found = estimate_ambient(points(300.0, np.random.default_rng(1)), TOF)
    assert found.low == 0.0 and found.high < 3000 and "below" in found.sentence


def test_the_interval_covers():
    rng, hits = np.random.default_rng(4), 0
    lights = np.geomspace(2e3, 80e3, 40)
    for lux in lights:
        found = estimate_ambient(points(lux, rng, 0.05 * rng.standard_normal()), TOF)
        hits += found.noise_low <= lux <= found.noise_high
    # 90 % of 40, two deviations of a binomial; over more draws 84 to 97 % were measured
    assert 32 <= hits <= 40


def test_one_line_goes_through_all_three_laws():
    law, z, front = light_law(None, TOF), np.array([1.0]), np.zeros(1)
    dark, clouds, sun = (law.variance(z, front, lux)[0] for lux in (300.0, 6e3, 9e4))
    slope = [(clouds - dark) / (effective(6e3) - effective(300.0)), (sun - clouds) / (effective(9e4) - effective(6e3))]
    assert slope[1] == pytest.approx(slope[0], rel=0.15)  # a factor of 195 in light, 205 in variance


def test_drowned_values_are_a_sign_too():
    lost = [LightPoint(z, 0.0, float("nan"), float("nan"), valid) for z, valid in ((1.0, 0.6), (2.5, 0.0))]
    found = estimate_ambient(lost, TOF)
    assert found.low > 15e3


def test_a_sensor_without_a_law_has_no_estimate():
    assert estimate_ambient(points(6e3, np.random.default_rng(0)), OTHER) is None
    assert estimate_ambient([], TOF) is None


def test_another_sensor_is_judged_by_its_own_noise():
    sensor = preset("kinect-v1")
    law = light_law(sensor, OTHER)
    found = estimate_ambient(points(60e3, np.random.default_rng(0), law=law), OTHER, sensor)
    # nobody measured that law: the interval is a factor of two and more wide
    assert found.low < 60e3 < found.high and found.high > 3 * found.low
