"""fusion: metric 3D scanning with depth cameras.

    >>> import fusion
    >>> recording = fusion.open_recording("my_scan")
    >>> recording
    <Recording my_scan: native, 26 frames of 160 x 120 in 12.5 s; depth, color, ir, poses, scene, turntable_deg>
    >>> recording[0].depth.shape
    (120, 160)

Lengths are metres, times seconds, angles radians. The names of `__all__` are the public ones; each is loaded when it is
first used, so that the import costs nothing.
"""

import importlib

__version__ = "0.1.0"

# `__init__.pyi` says where each name is; read without pathlib, which would take longer than all else here. None may be
# called like a module or folder beside this file, which would take its place
with open(f"{__file__}i", encoding="utf-8") as _stub:  # noqa: PTH123
    _HOME = {words[3]: words[1] for words in map(str.split, _stub) if words[:1] == ["from"]}
__all__ = ["__version__", *sorted(_HOME)]


def __getattr__(name: str) -> object:
    """A public name, loaded now that it is used (PEP 562)."""
    if name not in _HOME:
        raise AttributeError(f"module 'fusion' has no attribute {name!r}")
    value = globals()[name] = getattr(importlib.import_module(_HOME[name]), name)
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOME})
