"""Taichi, and the parts of it that fusion has of its own, to read kernels at half of the usual cost.

Taichi 1.7 asks the inspect module in which line of source each of its functions is made, which looks through all
modules there are; it draws, for each node of a kernel, that line with a marker below it, for messages that nobody will
see; it looks the source of every inlined function up anew, and wraps its lines at column 9999. File, line and function
are enough, and sources do not change. The module that does so is loaded a second time, for fusion alone: whoever else
uses Taichi in this process finds it as it was made.
"""

import gc
import inspect
import io
import linecache
import os
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from functools import cache
from importlib import import_module
from importlib.util import find_spec, module_from_spec
from textwrap import dedent
from threading import RLock
from types import FrameType, ModuleType, SimpleNamespace
from typing import Any

from fusion.compute.process import own_process

__all__ = ["PROCESSORS", "kernel_impl", "misc", "reading", "ti", "turn"]

# Taichi reads one kernel at a time: which one is kept for the whole process, and Python changes threads meanwhile
turn = RLock()


def _told(frame: FrameType, context: int = 1) -> inspect.Traceback:
    """What inspect.getframeinfo finds for one line, without asking which module it is of."""
    file, line = frame.f_code.co_filename, frame.f_lineno
    return inspect.Traceback(file, line, frame.f_code.co_name, [linecache.getline(file, line)], 0)


@contextmanager
def reading() -> Iterator[None]:
    """While Taichi reads source: in a process of our own without the collector, which goes through all that stays."""
    if not own_process():
        yield
        return
    slow, collected = inspect.getframeinfo, gc.isenabled()
    inspect.getframeinfo = _told  # type: ignore[assignment]
    gc.disable()
    try:
        yield
    finally:
        inspect.getframeinfo = slow
        if collected:
            gc.enable()


@contextmanager
def _said(**variables: str) -> Iterator[None]:
    """Environment variables for a while, where nobody has set them."""
    ours = {name: value for name, value in variables.items() if name not in os.environ}
    os.environ.update(ours)
    try:
        yield
    finally:
        for name in ours:
            os.environ.pop(name, None)


@contextmanager
def _unheard() -> Iterator[None]:
    """Where the import of Taichi fails it prints to standard output, beside what it raises."""
    if own_process():
        with redirect_stdout(io.StringIO()):
            yield
    else:
        yield


# else it greets, and takes the line after the import for a notebook's, and says so
with _said(ENABLE_TAICHI_HEADER_PRINT="0", TI_ENABLE_PYBUF="0"), reading(), _unheard():
    import taichi as ti


def _ours(name: str) -> ModuleType:
    """A module loaded once more, known to nobody else; in a process of our own the one that there is, as Taichi's
    functions, which kernels call too, are read by that one."""
    if own_process():
        return import_module(name)
    spec = find_spec(name)
    assert spec is not None and spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def _position(context: Any, node: Any) -> str:
    return f'File "{context.file}", line {node.lineno + context.lineno_offset}, in {context.func.func.__name__}:\n'


def _filled(line: str, tabsize: int = 8, **_: int) -> str:
    """What textwrap makes of a line that is not too long."""
    return line.expandtabs(tabsize).rstrip()


def _nothing(*_: object, **__: object) -> None:
    """In place of what is not wanted."""


PROCESSORS = (ti.x64, ti.arm64)  # not a card, with memory of its own

kernel_impl = _ours("taichi.lang.kernel_impl")  # how kernels and functions are read
kernel_impl.ASTTransformerContext = type(  # type: ignore[attr-defined]
    "Context", (kernel_impl.ASTTransformerContext,), {"get_pos_info": _position}
)
kernel_impl.getsourcelines = cache(inspect.getsourcelines)  # type: ignore[attr-defined]
kernel_impl.getsourcefile = cache(inspect.getsourcefile)  # type: ignore[attr-defined]
kernel_impl.textwrap = SimpleNamespace(dedent=dedent, fill=_filled)  # type: ignore[attr-defined]
kernel_impl._inside_class = lambda level_of_class_stackframe: False  # type: ignore[attr-defined]  # ours never are

misc = _ours("taichi.lang.misc")  # how Taichi is started
misc.print = _nothing  # type: ignore[attr-defined]  # it prints the back end whatever the log level is
# it tells its makers about this machine once a day
misc._version_check = SimpleNamespace(start_version_check_thread=_nothing)  # type: ignore[attr-defined]
