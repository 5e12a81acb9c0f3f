"""Quadrants, a fork of Taichi with nearly its interface; used as it is, but for what it prints when it starts."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from fusion.compute.modules import loaded_again, said, unheard
from fusion.files.extra import extra

__all__ = ["KNOWN", "compiled", "func", "init", "reading", "ti"]

NAME = "quadrants"
KEPT = ("QD_OFFLINE_CACHE_FILE_PATH", "kernels_quadrants")  # compiled kernels: its variable, our folder
KNOWN = False  # kernels are called as it calls them

with said(ENABLE_QUADRANTS_HEADER_PRINT="0", QD_ENABLE_PYBUF="0"), unheard():
    ti = extra("quadrants", "quadrants", "FUSION_KERNELS=quadrants", "FUSION_KERNELS")

misc = loaded_again("quadrants.lang.misc")  # how it is started
misc.print = lambda *_: None  # type: ignore[attr-defined]

func, init = ti.func, misc.init


@contextmanager
def reading() -> Iterator[None]:
    """While it reads source."""
    yield


def compiled(function: Callable[..., None]) -> Any:
    """A kernel as Quadrants calls it."""
    return ti.kernel(function)
