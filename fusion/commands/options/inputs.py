"""Which files and folders a command reads, as its options name them."""

import argparse
import importlib
from pathlib import Path

# options that hold a file or a name, and who knows the names
NAMED = {
    "sensor": "fusion.sensor.presets.PRESETS",
    "camera": "fusion.recording.cameras.presets.PRESETS",
    "scene": "fusion.simulation.scenes.SCENES",
    "poses": "",
    "reflectance": "",
}


def inputs(options: argparse.Namespace) -> list[Path]:
    """All files and folders that the options name, besides the output."""
    found = []
    for name, value in vars(options).items():
        for one in value if isinstance(value, list) else [value]:
            may_be = isinstance(one, Path) or (name in NAMED and isinstance(one, str))
            if may_be and name != "output" and _exists(Path(one)) and not _is_known(name, one):
                found.append(Path(one))
    return found


def _is_known(option: str, value: Path | str) -> bool:
    """True for a name: a folder that is called so is not what is meant."""
    module, _, names = NAMED.get(option, "").rpartition(".")
    return bool(module) and isinstance(value, str) and value in getattr(importlib.import_module(module), names)


def _exists(path: Path) -> bool:
    try:
        return path.exists()
    except (OSError, ValueError):  # no name that a file can have
        return False
