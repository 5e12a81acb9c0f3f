"""The only place that starts Taichi: one back end, chosen once, silent, kernels cached."""

import contextlib
import io
import os
from functools import cache
from typing import Any

import taichi as ti
from taichi.lang import kernel_impl
from taichi.lang.ast import ast_transformer_utils


@cache
def start(device: str | None = None) -> str:
    """Start Taichi once for this process.

    Args:
        device: "cpu", "cuda" or "vulkan"; None takes the variable FUSION_DEVICE, else "cpu".

    Returns:
        The name of the back end that runs.
    """
    name = device or os.environ.get("FUSION_DEVICE", "cpu")
    _read_kernels_quickly()
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


def _read_kernels_quickly() -> None:
    """Half of what a cached kernel costs on its first call is text for error messages that nobody will see.

    For each node of a kernel Taichi 1.7 draws the line of source with a marker below it, and looks the source of every
    inlined function up anew. File, line and function are enough, and sources do not change. Measured from prepare to
    raycast of one frame: 2.2 s of processor before, 1.2 s after.
    """
    if hasattr(ast_transformer_utils.ASTTransformerContext, "get_pos_info"):  # of Taichi 1.7; others do as they do
        ast_transformer_utils.ASTTransformerContext.get_pos_info = _position
    for name in ("getsourcelines", "getsourcefile"):
        if hasattr(kernel_impl, name) and not hasattr(getattr(kernel_impl, name), "cache_info"):
            setattr(kernel_impl, name, cache(getattr(kernel_impl, name)))


def _position(context: Any, node: Any) -> str:
    return f'File "{context.file}", line {node.lineno + context.lineno_offset}, in {context.func.func.__name__}:\n'
