"""Taichi, for files with kernels: imported, and kernels read, at half of what both would cost.

Taichi 1.7 asks the inspect module in which line of source each of its functions is made, which looks through all
modules there are; it draws, for each node of a kernel, that line with a marker below it, for messages that nobody will
see; it looks the source of every inlined function up anew, and wraps its lines at column 9999. File, line and function
are enough, and sources do not change. Meanwhile Python's collector goes again and again through objects that all stay.
"""

import gc
import inspect
import io
import linecache
import os
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from functools import cache
from textwrap import dedent
from types import FrameType, SimpleNamespace
from typing import Any

__all__ = ["reading", "ti"]


def _told(frame: FrameType, context: int = 1) -> inspect.Traceback:
    """What inspect.getframeinfo finds for one line, without asking which module it is of."""
    file, line = frame.f_code.co_filename, frame.f_lineno
    return inspect.Traceback(file, line, frame.f_code.co_name, [linecache.getline(file, line)], 0)


@contextmanager
def reading() -> Iterator[None]:
    """While Taichi reads source."""
    slow, collected = inspect.getframeinfo, gc.isenabled()
    inspect.getframeinfo = _told  # type: ignore[assignment]
    gc.disable()
    try:
        yield
    finally:
        inspect.getframeinfo = slow
        if collected:
            gc.enable()


os.environ.setdefault("TI_ENABLE_PYBUF", "0")  # else it takes the next line for a notebook, and says so
with reading(), redirect_stdout(io.StringIO()):  # it prints there where it fails, beside what it raises
    import taichi as ti
    from taichi.lang import kernel_impl
    from taichi.lang.ast import ast_transformer_utils


def _position(context: Any, node: Any) -> str:
    return f'File "{context.file}", line {node.lineno + context.lineno_offset}, in {context.func.func.__name__}:\n'


def _filled(line: str, tabsize: int = 8, **_: int) -> str:
    """What textwrap makes of a line that is not too long."""
    return line.expandtabs(tabsize).rstrip()


def _read_quickly() -> None:
    """From now on, in this process; another Taichi than 1.7 may be built otherwise, and does as it does."""
    if hasattr(ast_transformer_utils.ASTTransformerContext, "get_pos_info"):
        ast_transformer_utils.ASTTransformerContext.get_pos_info = _position
    for name in ("getsourcelines", "getsourcefile"):
        if hasattr(kernel_impl, name):
            setattr(kernel_impl, name, cache(getattr(kernel_impl, name)))
    if hasattr(kernel_impl, "textwrap"):
        kernel_impl.textwrap = SimpleNamespace(dedent=dedent, fill=_filled)
    if hasattr(kernel_impl, "_inside_class"):
        inside_class = kernel_impl._inside_class

        def quickly(level_of_class_stackframe: int) -> bool:
            with reading():
                return bool(inside_class(level_of_class_stackframe + 1))  # this function is a frame more

        kernel_impl._inside_class = quickly


_read_quickly()
