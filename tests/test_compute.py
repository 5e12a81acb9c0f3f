"""Taichi starts once; a mistake in a kernel still says where it is, though its positions are written short."""

import numpy as np
import pytest
import taichi as ti

from fusion.compute import start


def test_a_second_start_changes_nothing():
    assert start() == start()


def test_a_mistake_in_a_kernel_names_file_line_and_function():
    start()

    @ti.kernel
    def wrong(values: ti.types.ndarray(ti.f32, 1)):
        for i in values:
            values[i] = not_there  # noqa: F821

    with pytest.raises(ti.TaichiNameError, match=r"test_compute\.py\", line \d+, in wrong:"):
        wrong(np.zeros(3, np.float32))
