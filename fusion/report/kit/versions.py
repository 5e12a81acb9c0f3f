"""Versions of what made a result, read from the installed packages without importing them."""

import platform
from contextlib import suppress
from importlib.metadata import PackageNotFoundError, version

from fusion import __version__

PACKAGES = ("numpy", "scipy", "open3d", "taichi", "opencv-python-headless", "matplotlib")
BUILDS = {"open3d": "open3d-cpu"}  # the same module under another name


def versions() -> dict[str, str]:
    """Name to version of fusion, Python, the system and the packages that shape the result."""
    found = {"fusion": __version__, "python": platform.python_version(), "system": platform.platform(terse=True)}
    return found | {name: _version(name) for name in PACKAGES}


def _version(name: str) -> str:
    for each in filter(None, (name, BUILDS.get(name))):
        with suppress(PackageNotFoundError):
            return version(each)
    return "not installed"
