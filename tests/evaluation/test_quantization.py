"""Quantisation from the depths that occur at all."""

import numpy as np
import pytest

from fusion.evaluation.quantization import quantization_of


def counts(depth: np.ndarray, scale: float) -> np.ndarray:
    """How often each count occurs."""
    return np.bincount(np.rint(depth * scale).astype(int), minlength=65536)[:65536]


def triangulated(depth: np.ndarray, step: float) -> np.ndarray:
    return 1 / (np.rint(1 / depth / step) * step)


@pytest.mark.parametrize(("step", "scale"), [(0.0029, 1000), (0.0029, 10000), (0.0008, 10000)])
def test_steps_of_triangulation_grow_with_the_square(step, scale):
    z = np.random.default_rng(0).uniform(0.8, 3.5, 100_000)
    found = quantization_of([counts(triangulated(z, step), scale)], scale)
    assert found.law == "z^2"
    assert abs(found.exponent - 2) < 0.05
    assert found.value == pytest.approx(step, rel=0.01)
    # a 90 % interval, at twice its width
    assert abs(found.value - step) < found.interval[1] - found.interval[0]


@pytest.mark.parametrize("step", [0.0125, 0.018])
def test_steps_so_coarse_that_they_grow_from_one_to_the_next(step):
    """A dozen of them reach over a quarter of the distance, or over all of it."""
    z = np.random.default_rng(0).uniform(1.0, 4.0, 100_000)
    found = quantization_of([counts(triangulated(z, step), 10000)], 10000)
    assert found.law == "z^2" and found.value == pytest.approx(step, rel=1e-3)


def test_constant_steps():
    z = np.random.default_rng(0).uniform(0.8, 3.5, 100_000)
    found = quantization_of([counts(np.rint(z / 0.005) * 0.005, 1000)], 1000)
    assert found.law == "constant" and found.value == pytest.approx(0.005, rel=1e-6)


def test_a_dense_sensor_has_no_steps_of_its_own():
    z = np.random.default_rng(0).normal(1.5, 0.02, 100_000)
    assert quantization_of([counts(z, 1000)], 1000).law == "file"


def test_one_wall_gives_a_step_and_no_law():
    z = np.random.default_rng(0).normal(1.5, 0.008, 100_000)
    found = quantization_of([counts(triangulated(z, 0.0029), 10000)], 10000)
    assert found.law == "unknown"
    assert found.value == pytest.approx(0.0029 * 1.5**2, rel=0.03)


def test_chance_is_no_step():
    z = np.random.default_rng(0).uniform(1, 4, 2000)  # most levels are missing
    assert quantization_of([counts(z, 5000)], 5000) is None
    assert quantization_of([np.zeros(65536, np.int64)], 1000) is None


def test_walls_at_several_distances_tell_the_law_together():
    rng = np.random.default_rng(1)
    walls = [counts(triangulated(rng.normal(d, 0.006, 20_000), 0.0029), 10000) for d in np.arange(0.7, 2.0, 0.15)]
    found = quantization_of(walls, 10000)
    assert found.law == "z^2" and found.value == pytest.approx(0.0029, rel=0.02)
