"""Modules of others that are imported unheard, and modules that fusion has for itself."""

import io
import os
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from importlib import import_module
from importlib.util import find_spec, module_from_spec
from tempfile import gettempdir
from types import ModuleType

from fusion.compute.process import own_process


def loaded_again(name: str) -> ModuleType:
    """A module loaded once more, known to nobody else; in a process of our own the one that there is, as functions of
    its package, which kernels call too, use that one."""
    if own_process():
        return import_module(name)
    spec = find_spec(name)
    assert spec is not None and spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@contextmanager
def said(**variables: str) -> Iterator[None]:
    """Environment variables for a while, where nobody has set them; one more where no home is told, as to a service
    often none is: back ends end the whole process then, when they are imported and when they start."""
    if not os.environ.get("HOME"):
        variables["XDG_CACHE_HOME"] = gettempdir()
    ours = {name: value for name, value in variables.items() if name not in os.environ}
    os.environ.update(ours)
    try:
        yield
    finally:
        for name in ours:
            os.environ.pop(name, None)


@contextmanager
def unheard() -> Iterator[None]:
    """Where the import of a back end fails it prints to standard output, beside what it raises."""
    if own_process():
        with redirect_stdout(io.StringIO()):
            yield
    else:
        yield
