"""What `-v` tells beside the result: versions and options before the work, settings and files after it; on stderr."""

import argparse
import json
import platform
import sys

from fusion import __version__
from fusion.files.extra import version_of

LIBRARIES = ("numpy", "open3d", "taichi", "opencv-python-headless")  # that results depend on most


def tell_begin(options: argparse.Namespace) -> None:
    """Versions, and the options as they were understood."""
    _tell("version", f"fusion {__version__}, Python {platform.python_version()}, {platform.platform()}")
    _tell("version", ", ".join(f"{name} {version_of(name) or 'not installed'}" for name in LIBRARIES))
    for name, value in sorted(vars(options).items()):
        if not callable(value) and name not in ("verbose", "folder", "claim"):
            _tell("option", f"{name} {value}")


def tell_end(options: argparse.Namespace) -> None:
    """The settings that were chosen, and the files that stand in the output."""
    output = getattr(options, "output", None)
    if output is None or not output.exists():
        return
    settings = output / "settings.json"
    if settings.is_file():
        for name, value in json.loads(settings.read_text(encoding="utf-8")).items():
            _tell("setting", f"{name} {json.dumps(value)}")
    for path in sorted(output.iterdir()) if output.is_dir() else [output]:
        if not path.name.startswith("."):
            _tell("file", f"{path}, {path.stat().st_size / 1e6:.2f} MB" if path.is_file() else f"{path}/")


def _tell(kind: str, text: str) -> None:
    sys.stderr.write(f"{kind:<8} {text}\n")
