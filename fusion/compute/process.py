"""Whether this process is a program of fusion's own, in which what concerns all of it may be set.

As a library fusion is one of several users of a process and leaves alone what the others would notice: how memory is
given back, which core a thread runs on, Python's collector and standard output. A program that is nothing but fusion
runs faster with all of it set: the console program asks for that, and so do the benchmarks.
"""

import sys
from types import ModuleType

_own = False
# what Open3D imports to show clouds in notebooks: a web server and Plotly, 600 modules, three fifths of its import
NOTEBOOKS = {"dash": ("html", "dcc", "Dash"), "plotly": ("graph_objects",), "plotly.graph_objects": ()}


def tune_process() -> None:
    """Take this process for a program of fusion's own; to be called before anything else of fusion is."""
    global _own
    _own = True
    if "open3d" not in sys.modules:
        for name, parts in NOTEBOOKS.items():
            empty = ModuleType(name, "Left out by fusion, which shows nothing in notebooks.")
            empty.__dict__.update(dict.fromkeys(parts))
            sys.modules.setdefault(name, empty)


def own_process() -> bool:
    """Whether the program asked for it."""
    return _own
