"""Versions of what made a result, read from the installed packages without importing them."""

import platform

from fusion import __version__
from fusion.files.extra import version_of

PACKAGES = ("numpy", "scipy", "open3d", "taichi", "opencv-python-headless", "matplotlib")
BUILDS = {"open3d": "open3d-cpu"}  # the same module under another name


def versions() -> dict[str, str]:
    """Name to version of fusion, Python, the system and the packages that shape the result."""
    found = {"fusion": __version__, "python": platform.python_version(), "system": platform.platform(terse=True)}
    return found | {
        name: version_of(name) or version_of(BUILDS.get(name, name)) or "not installed" for name in PACKAGES
    }
