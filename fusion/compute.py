"""The only place that starts Taichi: one back end, chosen once, silent, kernels cached."""

import contextlib
import io
import os
from functools import cache

import taichi as ti


@cache
def start(device: str | None = None) -> str:
    """Start Taichi once for this process.

    Args:
        device: "cpu", "cuda" or "vulkan"; None takes the variable FUSION_DEVICE, else "cpu".

    Returns:
        The name of the back end that runs.
    """
    name = device or os.environ.get("FUSION_DEVICE", "cpu")
    with contextlib.redirect_stdout(io.StringIO()):  # it prints the back end whatever the log level is
        ti.init(
            arch={"cpu": ti.cpu, "cuda": ti.cuda, "vulkan": ti.vulkan}[name],
            log_level=ti.ERROR,
            offline_cache=True,
            default_fp=ti.f32,
            default_ip=ti.i32,
            fast_math=False,
        )
    return name
