"""Kernels that are called quickly do what they do when Taichi calls them."""

import numpy as np
import pytest
import taichi as ti

from fusion.compute import start
from fusion.launch import slowly

F32, U8_2 = ti.types.ndarray(ti.f32, 1), ti.types.ndarray(ti.u8, 2)


@pytest.fixture(scope="module")
def scale():
    start()

    @ti.kernel
    def scale(values: F32, mask: U8_2, factor: ti.f32, first: ti.i32, double: ti.template()):
        for n in range(first, values.shape[0]):
            values[n] *= factor * mask[n % mask.shape[0], 0]
            if ti.static(double):
                values[n] *= 2.0

    return scale


def test_calls_of_all_kinds_of_arguments_agree_with_slow_ones(scale):
    rng = np.random.default_rng(0)
    for n in (5, 700, 5, 3000):  # other arrays at each call
        for factor, first, double in ((2.5, 0, True), (np.float32(0.5), np.int64(3), False), (3, 1, True)):
            values, mask = rng.random(n, np.float32), rng.integers(0, 9, (4, 2)).astype(np.uint8)
            expected, twice = values.copy(), values.copy()
            slowly(scale._primal, expected, mask, factor, first, double)
            scale(values, mask, factor, first, double)
            scale(twice, mask, factor, first, double)
            assert np.array_equal(values, expected)
            assert np.array_equal(twice, expected)


def test_a_kernel_is_ready_for_each_kind_once(scale):
    for _ in range(3):
        scale(np.ones(4, np.float32), np.ones((1, 1), np.uint8), 1.0, 0, False)
        scale(np.ones(4, np.float32), np.ones((1, 1), np.uint8), 1.0, 0, True)
    ready = [found for types, found in scale._primal.ready.items() if types[2][0] is float]
    assert len({id(found) for found in ready}) == 2


def test_wrong_arguments_are_still_refused(scale):
    values, mask = np.ones(4, np.float32), np.ones((1, 1), np.uint8)
    scale(values, mask, 1.0, 0, False)
    with pytest.raises(ValueError, match="f64"):
        scale(values.astype(float), mask, 1.0, 0, False)
    with pytest.raises(ValueError, match="ontiguous"):
        scale(np.ones(8, np.float32)[::2], mask, 1.0, 0, False)
    with pytest.raises(ti.TaichiRuntimeTypeError):
        scale(values, mask, 1.0, 0.5, False)


def test_results_are_returned():
    start()

    @ti.kernel
    def add(a: ti.f32, b: ti.f32) -> ti.f32:
        return a + b

    assert [add(1.0, 2.0), add(2.0, 3.0)] == [3.0, 5.0]
