"""Taichi starts once; a mistake in a kernel still says where it is, though its positions are written short."""

import os
import subprocess
import sys

import numpy as np
import pytest
import taichi as ti

from fusion.compute.language import kernel
from fusion.compute.start import FEW, start


def test_a_second_start_changes_nothing():
    assert start() == start()


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="Linux only")
def test_on_a_small_machine_each_core_has_its_own_thread():
    cores = sorted(os.sched_getaffinity(0))
    if "TI_CPU_MAX_NUM_THREADS" in os.environ or not len(cores) == os.cpu_count() <= FEW:
        pytest.skip("threads are left where they are")
    program = """
import os
from pathlib import Path
from fusion.compute.process import tune_process

tune_process()
from fusion.compute.start import start

start()
allowed = [os.sched_getaffinity(int(thread.name)) for thread in Path("/proc/self/task").iterdir()]
print(*sorted(min(some) for some in allowed if len(some) == 1))
"""
    environment = {**os.environ, "FUSION_DEVICE": "cpu"}
    done = subprocess.run([sys.executable, "-c", program], env=environment, capture_output=True, text=True, check=True)
    assert len(cores) == 1 or [int(core) for core in done.stdout.split()] == cores


def test_a_mistake_in_a_kernel_names_file_line_and_function():
    start()

    @kernel
    def wrong(values: ti.types.ndarray(ti.f32, 1)):
        for i in values:
            values[i] = not_there  # noqa: F821

    with pytest.raises(ti.TaichiNameError, match=r"test_start\.py\", line \d+, in wrong:"):
        wrong(np.zeros(3, np.float32))


@pytest.mark.parametrize(("device", "said"), [("abacus", "unknown device"), ("vulkan", "no such device here")])
def test_a_device_that_is_not_there_is_said(device, said):
    program = "from fusion.compute.start import start; start()"
    environment = {**os.environ, "FUSION_DEVICE": device}
    done = subprocess.run([sys.executable, "-c", program], env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0 or said in done.stderr or "this device computes wrong" in done.stderr
    assert done.returncode != 0 or device == "vulkan"  # a machine that has it


def test_what_numpy_loads_when_it_is_asked_for_is_loaded_then():
    program = """
import sys
from fusion.compute.process import tune_process

tune_process()
import scipy.ndimage

assert "unittest" not in sys.modules
import numpy.testing

numpy.testing.assert_allclose([1.0], [1.0])
assert "unittest" in sys.modules
"""
    subprocess.run([sys.executable, "-c", program], check=True)
