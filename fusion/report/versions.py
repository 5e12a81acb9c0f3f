"""Versions of what made a result, read from the installed packages without importing them."""

import platform
from importlib.metadata import PackageNotFoundError, version

from fusion import __version__

PACKAGES = ("numpy", "scipy", "open3d", "taichi", "opencv-python-headless", "matplotlib", "plotly")


def versions() -> dict[str, str]:
    """Name to version of fusion, Python, the system and the packages that shape the result."""
    found = {"fusion": __version__, "python": platform.python_version(), "system": platform.platform(terse=True)}
    return found | {name: _version(name) for name in PACKAGES}


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"
