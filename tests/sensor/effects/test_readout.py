"""Effects of the readout: lengths along the ray, drifts, lost light, filters, tables."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import RegularGridInterpolator
from scipy.special import ndtr

from fusion.errors import SensorError
from fusion.geometry.camera import Camera
from fusion.sensor.effects.readout import READOUT
from fusion.sensor.effects.readout.amplitude_dropout import AmplitudeDropout
from fusion.sensor.effects.readout.axial_noise import AxialNoise
from fusion.sensor.effects.readout.depth_offset import DepthOffset
from fusion.sensor.effects.readout.depth_quantization import CALM, rounded
from fusion.sensor.effects.readout.depth_scale import DepthScale
from fusion.sensor.effects.readout.fixed_pattern import FixedPattern
from fusion.sensor.effects.readout.saturation import Saturation
from fusion.sensor.effects.readout.tabulated import VARIABLES, Tabulated
from fusion.sensor.effects.readout.temperature_drift import TemperatureDrift
from fusion.sensor.effects.readout.temporal_filtering import TemporalFiltering
from fusion.sensor.moment import Moment
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import View

STRIPES = Camera(64, 48, 50.0, 50.0, 31.5, 23.5, principle="structured_light")
TOF = replace(STRIPES, principle="itof")
FB = 43.5
RNG = np.random.default_rng(3)
DEPTH = RNG.uniform(0.6, 4.0, STRIPES.shape)


def view(camera: Camera, **moment) -> View:
    return View(camera, DEPTH, baseline=FB / camera.fx, moment=Moment(**moment))


def test_light_meets_them_in_this_order():
    assert [kind.name for kind in READOUT] == [
        "lateral_noise",
        "fixed_pattern",
        "temperature_drift",
        "depth_scale",
        "depth_offset",
        "tabulated",
        "saturation",
        "amplitude_dropout",
        "axial_noise",
        "temporal_filtering",
        "depth_quantization",
    ]


@pytest.mark.parametrize(
    "effect",
    [
        DepthOffset(0.02),
        FixedPattern(map=np.full(STRIPES.shape, 0.02)),
        TemperatureDrift(coefficient=0.002),
        TemperatureDrift(amplitude=0.02, time_constant=1.0),
        Tabulated(values=0.02),
    ],
    ids=lambda effect: effect.name,
)
def test_a_length_is_added_along_the_ray_by_time_of_flight_only(effect):
    for camera in (STRIPES, TOF):
        at = view(camera, temperature=35.0, time=1e4)
        stretch = at.stretch if camera is TOF else 1.0
        change = (DEPTH + effect.bias(DEPTH, at)) * stretch - DEPTH * stretch
        assert np.allclose(change, 0.02, atol=1e-7)  # the rays are float32


def test_a_scale_is_the_same_along_the_ray_and_along_the_axis():
    for camera in (STRIPES, TOF):
        assert np.allclose(DepthScale(0.01).bias(DEPTH, view(camera)), 0.01 * DEPTH)


def test_a_fixed_pattern_belongs_to_the_unit():
    effect = FixedPattern(rms=0.004)
    first, again, other = (effect.bias(DEPTH, view(STRIPES, unit=unit)) for unit in (1, 1, 2))
    assert np.array_equal(first, again)
    assert np.sqrt((first**2).mean()) == pytest.approx(0.004, rel=1e-4)
    # 3072 independent pixels: four standard errors
    assert abs(np.corrcoef(first.ravel(), other.ravel())[0, 1]) < 4 / np.sqrt(first.size)
    assert not np.any(effect.bias(DEPTH, view(STRIPES)))
    assert effect.noise(DEPTH, view(STRIPES)) == pytest.approx(0.004)
    sensor = Sensor(effects=(effect,))
    rng = np.random.default_rng(0)
    frames = [sensor.sample(DEPTH, view(STRIPES, unit=1), None, rng) for _ in range(2)]
    assert np.array_equal(*frames)  # frozen: not drawn a second time


def test_warm_up_approaches_its_amplitude():
    effect = TemperatureDrift(amplitude=0.01, time_constant=600.0)
    reached = [float(np.mean(effect.bias(DEPTH, view(STRIPES, time=t)))) for t in (0.0, 600.0, 1e5)]
    assert np.allclose(reached, [0.0, 0.01 * (1 - np.exp(-1)), 0.01])


def test_a_drift_in_pixels_shifts_every_disparity():
    effect = TemperatureDrift(coefficient_px=0.02, reference_temperature=20.0, amplitude_px=0.1, time_constant=100.0)
    at = view(STRIPES, temperature=30.0, time=100.0)
    shift = FB / (DEPTH + effect.bias(DEPTH, at)) - FB / DEPTH
    assert np.allclose(shift, 0.2 + 0.1 * (1 - np.exp(-1)))


def test_an_unknown_temperature_changes_nothing():
    assert not np.any(TemperatureDrift(coefficient=0.01, coefficient_px=0.01).bias(DEPTH, view(STRIPES)))


def test_saturation_cuts_the_light_and_loses_the_value():
    light = RNG.uniform(0, 2000, STRIPES.shape)
    effect = Saturation(1000.0)
    cut = effect.light(light, DEPTH, view(STRIPES))
    assert np.array_equal(cut, np.minimum(light, 1000.0))
    for seen in (light, cut):  # as a sum of light, or as it comes out of the sensor
        missing = effect.dropout(DEPTH, replace(view(STRIPES), ir=seen))
        assert np.array_equal(missing == 1, light >= 1000.0) and set(np.unique(missing)) == {0, 1}
    assert not np.any(effect.dropout(DEPTH, view(STRIPES)))
    counts = light.astype(np.uint16)
    assert np.array_equal(Saturation(73170.7).light(light, DEPTH, view(STRIPES)), light)
    assert not np.any(Saturation(73170.7).dropout(DEPTH, replace(view(STRIPES), ir=counts)))


def test_saturation_drops_what_the_sensor_itself_computes_as_too_bright():
    reflectance = np.where(np.arange(64) < 32, 0.05, 1.0) + np.zeros(STRIPES.shape)
    wall = View(STRIPES, np.full(STRIPES.shape, 1.0), np.zeros(STRIPES.shape), reflectance=reflectance)
    sensor = Sensor(effects=(Saturation(300.0),))
    measured = sensor.sample(wall.depth, wall, None, np.random.default_rng(0))
    assert np.isfinite(measured[:, :32]).all() and np.isnan(measured[:, 32:][np.abs(wall.stretch[:, 32:]) < 1.2]).all()


@pytest.mark.parametrize("width", [5.0, 0.0])
def test_half_is_missing_at_the_threshold(width):
    effect = AmplitudeDropout(ir_threshold=100.0, width=width)
    step = width or 2.0
    ir = np.broadcast_to(100 + step * np.linspace(-8, 8, 64), STRIPES.shape)
    missing = effect.dropout(DEPTH, replace(view(STRIPES), ir=ir))
    assert np.allclose(missing, 1 / (1 + np.exp((ir - 100) / step)))
    counted = Sensor(effects=(effect,)).sample(DEPTH, replace(view(STRIPES), ir=ir), None, np.random.default_rng(0))
    share = np.isnan(counted).mean(axis=0)
    assert np.abs(share - missing[0]).max() < 4 * 0.5 / np.sqrt(48)  # four standard errors


def test_pixels_of_unknown_amplitude_are_not_dropped():
    unknown = np.full(STRIPES.shape, np.nan)
    for effect in (AmplitudeDropout(100.0, 5.0), Saturation(100.0)):
        assert not np.any(effect.dropout(DEPTH, replace(view(STRIPES), ir=unknown)))
        assert not np.any(effect.dropout(DEPTH, view(STRIPES)))
    assert not np.any(AmplitudeDropout(0.0, 5.0).dropout(DEPTH, replace(view(STRIPES), ir=0 * DEPTH)))


class TestFilterInTime:
    MEMORY = 0.6

    def series(self, speed: float, noise: float, frames: int = 400) -> np.ndarray:
        """Frames (n, h, w) of a wall that moves away by `speed` [m per frame]."""
        sensor = Sensor(effects=(AxialNoise(c0=noise), TemporalFiltering(self.MEMORY)))
        rng, previous, seen = np.random.default_rng(1), None, []
        for k in range(frames):
            truth = np.full(STRIPES.shape, 1.0 + speed * k)
            at = replace(view(STRIPES, previous=previous), depth=truth)
            previous = sensor.sample(truth, at, None, rng)
            seen.append(previous - truth)
        return np.array(seen)[40:]  # 0.6^40: as if it had always run

    def test_spread_and_likeness_of_frames(self):
        error = self.series(0.0, 0.002)
        sensor = Sensor(effects=(AxialNoise(c0=0.002), TemporalFiltering(self.MEMORY)))
        declared = sensor.sigma(np.full(STRIPES.shape, 1.0), None, STRIPES)
        # a million values, of which a quarter is independent: four standard errors are 0.6 %
        assert error.std() == pytest.approx(declared[0, 0], rel=0.006)
        assert declared[0, 0] == pytest.approx(0.002 * 0.5)  # sqrt(0.4 / 1.6)
        alike = np.mean(error[1:] * error[:-1]) / np.mean(error**2)
        assert alike == pytest.approx(self.MEMORY, abs=0.01)

    def test_a_moving_wall_lags(self):
        error = self.series(0.001, 0.0, 60)
        assert np.allclose(error, -0.001 * 0.6 / 0.4, atol=1e-9)

    def test_a_pixel_without_a_value_before_is_taken_as_it_is(self):
        before = np.where(np.arange(64) < 10, np.nan, DEPTH + 0.1)
        change = TemporalFiltering(0.6).bias(DEPTH, view(STRIPES, previous=before))
        assert np.all(change[:, :10] == 0) and np.allclose(change[:, 10:], 0.06)
        assert not np.any(TemporalFiltering(0.6).bias(DEPTH, view(STRIPES)))


class TestTable:
    GRID = ((0.0, 10.0, 25.0, 40.0), (0.5, 1.0, 2.5, 3.5, 4.0))
    VALUES = np.random.default_rng(0).normal(0, 0.01, (4, 5))

    def test_between_its_entries_it_is_linear_and_beyond_them_held(self):
        effect = Tabulated(("radius", "depth"), self.GRID, self.VALUES)
        at = view(STRIPES)
        reference = RegularGridInterpolator(self.GRID, self.VALUES)
        inside = np.stack([np.clip(at.radius, 0, 40), np.clip(DEPTH, 0.5, 4.0)], axis=-1)
        assert np.allclose(effect.bias(DEPTH, at), reference(inside), atol=1e-9)

    def test_one_and_three_variables(self):
        at = view(STRIPES, time=50.0)
        one = Tabulated(("u",), ((0.0, 63.0),), [0.0, 0.063])
        assert np.allclose(one.bias(DEPTH, at), 0.001 * np.arange(64)[None, :])
        values = self.VALUES[None] * np.array([0.0, 1.0])[:, None, None]
        three = Tabulated(("time", "radius", "depth"), ((0.0, 100.0), *self.GRID), values)
        two = Tabulated(("radius", "depth"), self.GRID, self.VALUES)
        assert np.allclose(three.bias(DEPTH, at), 0.5 * two.bias(DEPTH, at), atol=1e-9)

    def test_in_pixels_it_shifts_the_disparity(self):
        effect = Tabulated(("disparity",), ((0.0, 100.0),), values_px=[0.0, 1.0])
        d = FB / DEPTH
        assert np.allclose(FB / (DEPTH + effect.bias(DEPTH, view(STRIPES))), 1.01 * d)

    def test_every_variable_can_be_asked_for_and_an_unknown_one_changes_nothing(self):
        for name in VARIABLES:
            effect = Tabulated((name,), ((-1e9, 1e9),), (0.1, 0.1))
            change = effect.bias(DEPTH, view(STRIPES))
            known = name not in ("incidence", "amplitude", "reflectance", "edge", "temperature")
            assert np.all(np.isfinite(change)) and np.any(change) == known
        some = np.where(np.arange(64) < 10, np.nan, 0.3) + np.zeros(STRIPES.shape)
        effect = Tabulated(("incidence", "depth"), ((0.0, 1.0), (0.0, 1.0)), [[0.1, 0.1], [0.1, 0.1]])
        change = effect.bias(DEPTH, replace(view(STRIPES), incidence=some))
        assert np.all(change[:, :10] == 0) and np.allclose(change[:, 10:], 0.1)

    def test_a_gentle_table_is_undone_and_a_steep_one_left(self):
        for rise, undone in ((0.1, True), (0.8, False)):
            effect = Tabulated(("depth",), ((0.0, 1.0, 2.0, 5.0),), (0.0, rise, 0.0, 0.0))
            sensor = Sensor(effects=(effect,))
            measured = sensor.predict(DEPTH, view(STRIPES))
            back = sensor.correct(measured, view(STRIPES))
            assert bool(sensor.left_out) != undone
            assert np.abs(back - DEPTH).max() < 1e-5 if undone else np.array_equal(back, measured)

    @pytest.mark.parametrize(
        ("variables", "grid", "values"),
        [
            (("colour",), ((0, 1),), (0, 1)),
            (("depth",), ((0, 1), (0, 1)), (0, 1)),
            (("depth",), ((1, 0),), (0, 1)),
            (("depth",), ((0, 0),), (0, 1)),
            (("depth",), ((0, 1),), (0, 1, 2)),
            (("depth",), (), ()),
            (("u",) * 7, ((0, 1),) * 7, np.zeros((2,) * 7)),
        ],
    )
    def test_what_does_not_fit_is_refused(self, variables, grid, values):
        with pytest.raises(SensorError):
            Tabulated(variables, grid, values)


@pytest.mark.parametrize("sigma", [0.02, 0.1, CALM - 1e-9, CALM, 0.5, 0.9, 1.0, 1.5])
def test_rounding_of_normal_noise_is_exact(sigma):
    x, k = np.linspace(-1.0, 1.0, 41)[:, None], np.arange(-20, 21)
    shares = ndtr((k + 0.5 - x) / sigma) - ndtr((k - 0.5 - x) / sigma)
    mean = (shares * k).sum(axis=1)
    spread = np.sqrt((shares * (k - mean[:, None]) ** 2).sum(axis=1))
    found = rounded(x[:, 0], np.full(len(x), sigma))
    assert found[0] == pytest.approx(mean, abs=1e-13)  # rounding of the sums
    assert found[1] == pytest.approx(spread, abs=1e-7)  # its root, where next to nothing is left
