"""Whether this process is a program of fusion's own, in which what concerns all of it may be set.

As a library fusion is one of several users of a process and leaves alone what the others would notice: how memory is
given back, which core a thread runs on, Python's collector and standard output. A program that is nothing but fusion
runs faster with all of it set: the console program asks for that, and so do the benchmarks.
"""

import sys
from collections.abc import Sequence
from importlib.machinery import ModuleSpec, PathFinder
from importlib.util import LazyLoader
from types import ModuleType

_own = False
# what Open3D imports to show clouds in notebooks: a web server and Plotly, 600 modules, three fifths of its import
NOTEBOOKS = {"dash": ("html", "dcc", "Dash"), "plotly": ("graph_objects",), "plotly.graph_objects": ()}
# SciPy takes over all names of NumPy, and so imports what NumPy itself loads when it is asked for: a third of the time
LATER = {"numpy.f2py", "numpy.testing", "numpy.ctypeslib"}


class _Later:
    """Finds modules that are loaded when something of them is asked for."""

    @staticmethod
    def find_spec(fullname: str, path: Sequence[str] | None, target: ModuleType | None = None) -> ModuleSpec | None:
        found = PathFinder.find_spec(fullname, path, target) if fullname in LATER else None
        if found is not None and found.loader is not None:
            found.loader = LazyLoader(found.loader)
        return found


def tune_process() -> None:
    """Take this process for a program of fusion's own; to be called before anything else of fusion is."""
    global _own
    if not _own:
        sys.meta_path.insert(0, _Later)
    _own = True
    if "open3d" not in sys.modules:
        for name, parts in NOTEBOOKS.items():
            empty = ModuleType(name, "Left out by fusion, which shows nothing in notebooks.")
            empty.__dict__.update(dict.fromkeys(parts))
            sys.modules.setdefault(name, empty)


def own_process() -> bool:
    """Whether the program asked for it."""
    return _own
