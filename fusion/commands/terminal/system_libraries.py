"""The libraries that a minimal Debian or Ubuntu lacks, their packages, and the command that installs these.

Needs nothing but Python: make asks it before there is an environment.
"""

import ctypes
import os
import shutil
import sys
from collections.abc import Iterable

# What Open3D 0.20 and Taichi 1.7 load and their wheels do not bring (`objdump -p`); the names are the same in
# Debian 12 and 13 and in Ubuntu 22.04 and 24.04
PACKAGES = {
    "libEGL.so.1": "libegl1",
    "libGL.so.1": "libgl1",
    "libX11.so.6": "libx11-6",
    "libidn2.so.0": "libidn2-0",
    "libudev.so.1": "libudev1",
    "libusb-1.0.so.0": "libusb-1.0-0",
}


def missing_libraries() -> list[str]:
    """Names of those that the loader does not find; none on systems whose wheels bring everything."""
    return [name for name in PACKAGES if not _loads(name)] if sys.platform == "linux" else []


def packages_of(libraries: Iterable[str]) -> list[str]:
    """The packages that hold these libraries; those of unknown libraries are left out."""
    return sorted({PACKAGES[name] for name in libraries if name in PACKAGES})


def install_command(packages: Iterable[str]) -> str:
    """What to type in a shell, as whoever asks."""
    command = f"apt-get update && apt-get install -y --no-install-recommends {' '.join(packages)}"
    if os.geteuid() == 0:
        return command
    return f"sudo sh -c '{command}'" if shutil.which("sudo") else f"su -c '{command}'"


def _loads(name: str) -> bool:
    try:
        ctypes.CDLL(name)
    except OSError:
        return False
    return True
