"""Which files and folders a command reads, as its options name them."""

import argparse
import importlib
from pathlib import Path

# options that hold a file or a name, and who knows the names
NAMED = {
    "sensor": "fusion.sensor.presets.PRESETS",
    "camera": "fusion.recording.camera_presets.PRESETS",
    "scene": "fusion.simulation.scenes.SCENES",
    "poses": "",
}


def inputs(options: argparse.Namespace) -> list[Path]:
    """All files and folders that the options name, besides the output."""
    found: list[Path] = []
    for name, value in vars(options).items():
        if name != "output":
            values = value if isinstance(value, list) else [value]
            found += [Path(one) for one in values if isinstance(one, Path) or (one and name in NAMED)]
            if found and name in NAMED and _exists(found[-1]) and _is_known(name, str(value)):
                found.pop()  # a folder of that name is not what is meant
    return [path for path in found if _exists(path)]


def _is_known(option: str, value: str) -> bool:
    module, _, names = NAMED[option].rpartition(".")
    return bool(module) and value in getattr(importlib.import_module(module), names)


def _exists(path: Path) -> bool:
    try:
        return path.exists()
    except (OSError, ValueError):  # no name that a file can have
        return False
