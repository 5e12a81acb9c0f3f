"""Laws that every sensor effect obeys, whatever its physics."""

from dataclasses import replace

import numpy as np
import pytest
from rich_view import CAMERA, rich_view, sensor_of, typical

from fusion.sensor.catalogue import KNOWN
from fusion.sensor.effect import Effect
from fusion.sensor.effects import EFFECTS
from fusion.sensor.parameter import parameters
from fusion.sensor.view import View
from fusion.sensor.weights.rating import sigma_by_incidence, sigma_of

DRAWS = 400
CORRECTED = [kind for kind in EFFECTS if kind.changes("bias") and not kind.not_corrected]


@pytest.fixture
def view(kind) -> View:
    return rich_view(kind)


def at_bounds(kind) -> list[Effect]:
    """The effect with all its parameters at their low, and at their high, bounds."""
    return [
        kind(**{p.name: getattr(p, bound) for p in parameters(kind).values() if kind.changes("bias")})
        for bound in ("low", "high")
    ]


@pytest.mark.parametrize("kind", EFFECTS, ids=lambda kind: kind.name)
class TestEveryEffect:
    def test_neutral_parameters_change_nothing(self, kind, view):
        sensor = sensor_of(kind())
        assert np.array_equal(sensor.predict(view.depth, view), view.depth, equal_nan=True)
        sampled = sensor.sample(view.depth, view, None, np.random.default_rng(0))
        assert np.array_equal(sampled, view.depth, equal_nan=True)
        assert np.nanmax(sensor.sigma(view.depth, view.incidence, CAMERA)) == 0

    def test_correct_undoes_predict_or_leaves_the_depth(self, kind, view):
        for effect in (typical(kind), *(() if kind.not_corrected else at_bounds(kind))):
            sensor = sensor_of(effect)
            measured = sensor.predict(view.depth, view)
            if effect.why_not_corrected():
                assert np.array_equal(sensor.correct(measured, view), measured, equal_nan=True)
                assert any(kind.name in text for text in sensor.left_out)
            else:
                known = np.isfinite(measured)  # an offset may push a near pixel behind the camera
                error = np.abs(sensor.correct(measured, view) - view.depth)[known]
                assert error.max() < 1e-5  # 10 micrometres: what `correct` promises

    def test_noise_that_depends_on_the_incidence_says_so(self, kind, view):
        sensor = sensor_of(typical(kind))
        later = sigma_by_incidence(sensor, replace(view, incidence=None))(view.incidence)
        assert np.array_equal(later, sigma_of(sensor, view), equal_nan=True)

    def test_samples_have_the_declared_mean_and_spread(self, kind, view):
        effect = typical(kind)
        rng = np.random.default_rng(1)
        mean = view.depth + effect.change(view.depth, view)
        draws = np.array([effect.sampled(view.depth, view, rng) - mean for _ in range(DRAWS)])
        declared = effect.noise(view.depth, view) * np.ones(view.depth.shape)
        where = np.isfinite(mean + declared) & (declared > 0) & (not effect.frozen)
        if not where.any():
            assert np.nanmax(np.abs(draws)) == 0
            return
        # pixels of one draw may share their noise, so the draws are the independent samples
        # most pixels beside an edge jump in fewer than one of 1000 frames, by far more than their spread: 400 draws
        # show that of all pixels together, and not of each
        rare = effect.name == "lateral_noise"
        scaled = draws[:, where] / (np.sqrt(np.mean(declared[where] ** 2)) if rare else declared[where])
        for power, expected in ((1, 0.0), (2, 1.0)):
            means = (scaled**power).mean(axis=1)
            # four standard errors
            assert abs(means.mean() - expected) < 4 * means.std() / np.sqrt(DRAWS)
        # and each pixel by itself; 5 instead of 4 because the worst of 3000 pixels is looked at
        if not rare:
            assert np.abs(scaled.std(axis=0) - 1).max() < 5 / np.sqrt(2 * DRAWS)

    def test_samples_are_missing_as_often_as_declared(self, kind, view):
        sensor = sensor_of(typical(kind))
        declared = sensor.dropout(view.depth, view)
        rng = np.random.default_rng(2)
        frames = 20  # times some 3000 pixels
        missing = sum(np.isnan(sensor.sample(view.depth, view, None, rng)) for _ in range(frames))
        there = np.isfinite(view.depth) & np.isfinite(sensor.predict(view.depth, view))
        expected, spread = declared[there].sum() * frames, np.sqrt((declared * (1 - declared))[there].sum() * frames)
        # four standard errors; two values more where a noisy depth falls below 0
        assert abs(missing[there].sum() - expected) <= 4 * spread + 2

    def test_every_parameter_is_described(self, kind, view):
        assert parameters(kind)
        for about in parameters(kind).values():
            assert about.unit and about.meaning and about.source
            assert about.low <= about.neutral <= about.high and about.low < about.high
            assert about.unit in KNOWN[kind.name][about.label]

    def test_missing_stays_missing_and_the_type_stays(self, kind, view):
        sensor = sensor_of(typical(kind))
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


@pytest.mark.parametrize("kind", CORRECTED, ids=lambda kind: kind.name)
def test_bias_is_gentle_enough_for_a_fixed_point(kind, view):
    assert not typical(kind).why_not_corrected()
    for effect in (typical(kind), *(effect for effect in at_bounds(kind) if not effect.why_not_corrected())):
        slope = (effect.bias(view.depth + 1e-4, view) - effect.bias(view.depth, view)) / 1e-4
        assert np.nanmax(np.abs(slope)) < 0.5
