"""Taichi is imported and reads kernels quickly, and otherwise as it does."""

import gc
import inspect

import numpy as np

from fusion.compute.language import reading, ti
from fusion.compute.start import start


@ti.data_oriented
class _Counter:
    """A class with a kernel: Taichi tells it by the line of source that it is made in."""

    def __init__(self) -> None:
        self.step = 3

    @ti.kernel
    def count(self, values: ti.types.ndarray(ti.i32, 1)):
        for n in values:
            values[n] += self.step


def test_a_kernel_of_a_class_is_told_from_others():
    start()
    values = np.arange(4, dtype=np.int32)
    _Counter().count(values)
    assert values.tolist() == [3, 4, 5, 6]


def test_the_line_of_source_is_the_one_that_python_finds():
    def told() -> tuple[list[str] | None, int]:
        frame = inspect.currentframe()
        assert frame is not None
        found = inspect.getframeinfo(frame)
        return found.code_context, found.lineno

    slow = told()
    with reading():
        assert told() == slow


def test_the_collector_and_inspect_are_left_as_they_were():
    plain = inspect.getframeinfo
    for collected in (True, False):
        (gc.enable if collected else gc.disable)()
        try:
            with reading():
                assert not gc.isenabled()
            assert gc.isenabled() == collected
        finally:
            gc.enable()
    assert inspect.getframeinfo is plain
