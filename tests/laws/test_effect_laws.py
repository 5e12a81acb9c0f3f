"""Laws that every sensor effect obeys, whatever its physics."""

import numpy as np
import pytest

from fusion.geometry.camera import Camera
from fusion.sensor.catalogue import KNOWN
from fusion.sensor.effect import Effect
from fusion.sensor.effects import EFFECTS
from fusion.sensor.parameter import parameters
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import View

CAMERA = Camera(64, 48, 570.0, 570.0, 31.5, 23.5, principle="structured_light")
DRAWS = 400

# one clearly visible value per parameter, where the bound itself would leave no depth to measure
TYPICAL = {
    "axial_noise": {"c0": 0.002, "c1": 0.001, "c2": 0.001, "angle": 1e-4, "angle_exponent": 1.5, "sigma_px": 0.05},
    "lateral_noise": {"sigma_px": 0.6, "sigma": 0.0005},
    "depth_quantization": {"step": 0.001, "step_px": 0.125},
}


def typical(kind: type[Effect]) -> Effect:
    values = TYPICAL.get(kind.name) or {p.name: 0.1 * p.high for p in parameters(kind).values()}
    return kind(**values)


@pytest.fixture
def view() -> View:
    """A tilted wall from 0.8 to 3.5 m with a step and a hole."""
    depth = np.linspace(0.8, 3.5, 64)[None, :] + np.zeros((48, 1))
    depth[20:30, 20:30] -= 0.3
    depth[:4, :4] = np.nan
    incidence = np.linspace(0.0, 1.3, 48)[:, None] + np.zeros((1, 64))
    return View(CAMERA, depth, incidence, ir=np.full((48, 64), 400, np.uint16))


@pytest.mark.parametrize("kind", EFFECTS, ids=lambda kind: kind.name)
class TestEveryEffect:
    def test_neutral_parameters_change_nothing(self, kind, view):
        sensor = Sensor(effects=(kind(),))
        assert np.array_equal(sensor.predict(view.depth, view), view.depth, equal_nan=True)
        sampled = sensor.sample(view.depth, view, None, np.random.default_rng(0))
        assert np.array_equal(sampled, view.depth, equal_nan=True)
        assert np.nanmax(sensor.sigma(view.depth, view.incidence, CAMERA)) == 0

    def test_correct_undoes_predict_or_leaves_the_depth(self, kind, view):
        for sign in (-1, 1):
            values = {p.name: p.high if sign > 0 else p.low for p in parameters(kind).values() if kind.changes("bias")}
            sensor = Sensor(effects=(typical(kind) if kind.not_undone else kind(**values),))
            measured = sensor.predict(view.depth, view)
            if kind.not_undone:
                assert np.array_equal(sensor.correct(measured, view), measured, equal_nan=True)
                assert any(kind.name in text for text in sensor.left_out)
            else:
                known = np.isfinite(measured)  # an offset may push a near pixel behind the camera
                error = np.abs(sensor.correct(measured, view) - view.depth)[known]
                assert error.max() < 1e-5  # 10 micrometres: what `correct` promises

    def test_bias_is_gentle_enough_for_a_fixed_point(self, kind, view):
        if kind.not_undone or not kind.changes("bias"):
            return
        for bound in ("low", "high"):
            effect = kind(**{p.name: getattr(p, bound) for p in parameters(kind).values()})
            slope = (effect.bias(view.depth + 1e-4, view) - effect.bias(view.depth, view)) / 1e-4
            assert np.nanmax(np.abs(slope)) < 0.5

    def test_samples_have_the_declared_mean_and_spread(self, kind, view):
        effect = typical(kind)
        rng = np.random.default_rng(1)
        draws = np.array([effect.draw(view.depth, view, rng) * np.ones(view.depth.shape) for _ in range(DRAWS)])
        declared = effect.noise(view.depth, view) * np.ones(view.depth.shape)
        where = np.isfinite(declared) & (declared > 0) & (not effect.frozen)
        if not where.any():
            assert np.nanmax(np.abs(draws)) == 0
            return
        # all pixels together: each draw in units of its own spread is one of some 10^5 samples
        scaled = draws[:, where] / declared[where]
        n = scaled.size
        assert abs(scaled.mean()) < 4 / np.sqrt(n)
        # four standard errors of a mean square, whose own spread is measured: a jump is not normal
        assert abs((scaled**2).mean() - 1) < 4 * (scaled**2).std() / np.sqrt(n)
        # and each pixel by itself; 5 instead of 4 because the worst of 3000 pixels is looked at
        if effect.name != "lateral_noise":
            assert np.abs(scaled.std(axis=0) - 1).max() < 5 / np.sqrt(2 * DRAWS)

    def test_every_parameter_is_described(self, kind, view):
        assert parameters(kind)
        for about in parameters(kind).values():
            assert about.unit and about.meaning and about.source
            assert about.low <= about.neutral <= about.high and about.low < about.high
            assert KNOWN[kind.name][about.name] == (about.unit,)

    def test_missing_stays_missing_and_the_type_stays(self, kind, view):
        sensor = Sensor(effects=(typical(kind),))
        depth = view.depth.astype(np.float32)
        for result in (
            sensor.predict(depth, view),
            sensor.correct(depth, view),
            sensor.sample(depth, view, None, np.random.default_rng(0)),
            sensor.sigma(depth, None, CAMERA),
        ):
            assert result.dtype == np.float32 and result.shape == depth.shape
            assert np.isnan(result[:4, :4]).all() and np.isfinite(result).mean() > 0.9
            assert np.isnan(sensor.sigma(np.full((48, 64), np.nan), None, CAMERA)).all()

    def test_has_a_name_and_a_text(self, kind, view):
        assert kind.name and kind.__doc__ and not kind.__doc__.startswith(kind.__name__ + "(")
