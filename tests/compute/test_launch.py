"""Kernels that are called quickly do what they do when Taichi calls them."""

import weakref
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
import taichi as ti

from fusion.compute.language import kernel
from fusion.compute.start import start

F32, U8_2 = ti.types.ndarray(ti.f32, 1), ti.types.ndarray(ti.u8, 2)


@pytest.fixture(scope="module")
def scale():
    start()

    @kernel
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
            scale.plain(expected, mask, factor, first, double)
            scale(values, mask, factor, first, double)
            scale(twice, mask, factor, first, double)
            assert np.array_equal(values, expected)
            assert np.array_equal(twice, expected)


@pytest.mark.skipif(start() != "cpu", reason="on a card kernels are called as Taichi calls them")
def test_a_kernel_is_ready_for_each_kind_once(scale):
    for _ in range(3):
        scale(np.ones(4, np.float32), np.ones((1, 1), np.uint8), 1.0, 0, False)
        scale(np.ones(4, np.float32), np.ones((1, 1), np.uint8), 1.0, 0, True)
    ready = [found for types, found in scale.ready.items() if types[2][0] is float]
    assert len({id(found) for found in ready}) == 2


def test_what_changed_since_the_last_call_is_handed_over_anew(scale):
    mask, values = np.full((1, 1), 3, np.uint8), np.ones(4, np.float32)
    scale(values, mask, 1.0, 0, False)
    scale(values, mask, 2.0, 1, False)  # other numbers
    assert values.tolist() == [3, 18, 18, 18]
    two = np.ones(4, np.float32)
    scale(two, mask, 2.0, 1, False)  # another array
    assert values.tolist() == [3, 18, 18, 18]
    assert two.tolist() == [1, 6, 6, 6]


def test_nothing_of_a_call_is_kept_alive(scale):
    values, mask = np.ones(4, np.float32), np.ones((1, 1), np.uint8)
    scale(values, mask, 1.0, 0, False)
    alive = weakref.ref(values)
    del values
    assert alive() is None
    for n in range(20):  # new arrays come to lie where others were
        values = np.full(4, float(n), np.float32)
        scale(values, mask, 2.0, 0, False)
        assert values.tolist() == [2.0 * n] * 4


def test_threads_do_not_mix_their_arguments(scale):
    def work(n: int) -> bool:
        mask, good = np.full((1, 1), n + 1, np.uint8), True
        for k in range(200):
            values = np.full(8, float(k), np.float32)
            scale(values, mask, 1.0, 0, False)
            good = good and bool((values == (n + 1) * k).all())
        return good

    with ThreadPoolExecutor(4) as pool:
        assert all(pool.map(work, range(4)))


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

    @kernel
    def add(a: ti.f32, b: ti.f32) -> ti.f32:
        return a + b

    assert [add(1.0, 2.0), add(2.0, 3.0)] == [3.0, 5.0]
