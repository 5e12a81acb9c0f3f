"""Installs what the machine lacks where nobody has to be asked; else says the command to type, and ends with 1.

    python3 -m tools.system_packages [--browser] [--usb]    (in the project's folder, before there is an environment)

`--browser` also wants Chromium, which the slow tests of the report open; `--usb` what the emulated Kinect of the slow
tests stands on (tests/devices/emulator), with libfreenect's programs as its foreign judge.
"""

import importlib.util
import os
import shutil
import subprocess
import sys

from fusion.commands.terminal.system_libraries import install_command, missing_libraries, packages_of

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome")

USB = {  # program: the packages that it and those beside it come with, all of Debian and Ubuntu
    "umockdev-wrapper": ("umockdev", "gir1.2-umockdev-1.0", "python3-gi", "libusb-1.0-0"),
    "freenect-camtest": ("libfreenect-bin",),
}


def main(arguments: list[str]) -> int:
    """Returns the exit status: 0 when nothing is missing any more."""
    libraries = missing_libraries()
    lacking, packages = list(libraries), packages_of(libraries)
    if importlib.util.find_spec("ensurepip") is None:  # Debian's python3 comes without
        lacking.append("Python's module ensurepip")
        packages.append(f"python3.{sys.version_info.minor}-venv")
    if "--browser" in arguments and not any(map(shutil.which, BROWSERS)):
        lacking.append("Chromium")
        packages.append("chromium")
    if "--usb" in arguments:
        lacking += [f"{program} (emulated USB)" for program in USB if not shutil.which(program)]
        packages += [name for program, names in USB.items() if not shutil.which(program) for name in names]
    if not lacking:
        return 0
    if not shutil.which("apt-get"):
        return _told(f"this machine lacks {', '.join(lacking)}: install the packages of your system that hold them")
    prefix = _as_root()
    if prefix is None:
        return _told(f"this machine lacks {', '.join(lacking)}; type: {install_command(packages)}")
    print(f"installing the system packages {' '.join(packages)}", flush=True)
    return _install(prefix, packages)


def _as_root() -> list[str] | None:
    """What makes a command run as root without a question; None where nothing does."""
    if os.geteuid() == 0:
        return []
    if shutil.which("sudo") and not subprocess.run(["sudo", "-n", "true"], capture_output=True).returncode:
        return ["sudo", "-n"]
    return None


def _install(prefix: list[str], packages: list[str]) -> int:
    quiet = [*prefix, "env", "DEBIAN_FRONTEND=noninteractive", "apt-get", "-qq"]
    for command in ([*quiet, "update"], [*quiet, "install", "-y", "--no-install-recommends", *packages]):
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        if done.returncode:
            last = next(reversed(done.stdout.split("\n")[:-1]), "it says nothing")
            return _told(f"{' '.join(command)} failed: {last}; type: {install_command(packages)}")
    return 0


def _told(line: str) -> int:
    print(f"make: {line}", file=sys.stderr)
    return 1


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
