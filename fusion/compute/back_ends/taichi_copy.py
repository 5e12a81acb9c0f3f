"""Taichi, and the parts of it that fusion has of its own, to read kernels at half of the usual cost.

Taichi 1.7 asks the inspect module in which line of source each of its functions is made, which looks through all
modules there are; it draws, for each node of a kernel, that line with a marker below it, for messages that nobody will
see; it looks the source of every inlined function up anew, and wraps its lines at column 9999. File, line and function
are enough, and sources do not change. The module that does so is loaded a second time, for fusion alone: whoever else
uses Taichi in this process finds it as it was made. Of a Taichi that this was not made for none of it is changed.
"""

import gc
import inspect
import linecache
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from textwrap import dedent
from types import FrameType, SimpleNamespace
from typing import Any

from fusion.compute.modules import loaded_again, said, unheard
from fusion.compute.process import own_process

__all__ = ["KNOWN", "compiled", "func", "init", "kernel_impl", "reading", "ti"]

NAME = "taichi"
KEPT = ("TI_OFFLINE_CACHE_FILE_PATH", "kernels")  # compiled kernels: its variable, our folder


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


# else it greets, and takes the line after the import for a notebook's, and says so
with said(ENABLE_TAICHI_HEADER_PRINT="0", TI_ENABLE_PYBUF="0"), reading(), unheard():
    import taichi as ti

KNOWN = ti.__version__[:2] == (1, 7)  # what is changed below, and how kernels are called quickly, was made for it


def _position(context: Any, node: Any) -> str:
    return f'File "{context.file}", line {node.lineno + context.lineno_offset}, in {context.func.func.__name__}:\n'


def _filled(line: str, tabsize: int = 8, **_: int) -> str:
    """What textwrap makes of a line that is not too long."""
    return line.expandtabs(tabsize).rstrip()


def _nothing(*_: object, **__: object) -> None:
    """In place of what is not wanted."""


kernel_impl = loaded_again("taichi.lang.kernel_impl")  # how kernels and functions are read
if KNOWN:
    kernel_impl.ASTTransformerContext = type(  # type: ignore[attr-defined]
        "Context", (kernel_impl.ASTTransformerContext,), {"get_pos_info": _position}
    )
    kernel_impl.getsourcelines = cache(inspect.getsourcelines)  # type: ignore[attr-defined]
    kernel_impl.getsourcefile = cache(inspect.getsourcefile)  # type: ignore[attr-defined]
    kernel_impl.textwrap = SimpleNamespace(dedent=dedent, fill=_filled)  # type: ignore[attr-defined]
    kernel_impl._inside_class = lambda level_of_class_stackframe: False  # type: ignore[attr-defined]  # ours never are

misc = loaded_again("taichi.lang.misc")  # how Taichi is started
misc.print = _nothing  # type: ignore[attr-defined]  # it prints the back end whatever the log level is
# it tells its makers about this machine once a day
misc._version_check = SimpleNamespace(start_version_check_thread=_nothing)  # type: ignore[attr-defined]

func, init = kernel_impl.func, misc.init


def compiled(function: Callable[..., None]) -> Any:
    """A kernel as Taichi calls it."""
    return kernel_impl.Kernel(function, kernel_impl.AutodiffMode.NONE)
