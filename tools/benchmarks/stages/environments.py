"""Environments of the peers: the running Python where it has the packages, else one made in the cache; programs of
Debian unpacked there, as nothing is installed on the machine."""

import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Needs:
    """What a program imports.

    Attributes:
        modules: names to import, for the check.
        packages: what pip installs for them.
        python: "3.10" where wheels exist for that version only, "" for the running one.
        debian: a package of Debian that it runs.
    """

    modules: tuple[str, ...]
    packages: tuple[str, ...]
    python: str = ""
    debian: str = ""


OPEN3D = Needs(("open3d",), ("open3d==0.20.0",))
OPENCV = Needs(("cv2",), ("opencv-contrib-python-headless==5.0.0.93",))
GICP = Needs(("small_gicp",), ("small_gicp==1.0.1", "numpy"))
IGL = Needs(("igl",), ("libigl==2.6.3", "numpy"))
VDB = Needs(("vdbfusion",), ("vdbfusion==0.1.6", "numpy<2"), "3.10")
CLOUDCOMPARE = Needs(("numpy",), ("numpy",), debian="cloudcompare")


def interpreter(needs: Needs, cache: Path) -> tuple[str, str]:
    """The interpreter that has what a program needs, and "" or the reason why there is none."""
    if needs.debian and (reason := unpacked(needs.debian, cache)):
        return "", reason
    if not needs.python and _imports(sys.executable, needs):
        return sys.executable, ""
    folder = cache / ("venv-" + "-".join(needs.modules))
    inside = folder / "bin" / "python"
    if _imports(str(inside), needs):
        return str(inside), ""
    base = _base(needs.python)
    if not base:
        return "", f"no Python {needs.python} on this machine"
    shutil.rmtree(folder, ignore_errors=True)
    for command in ([base, "-m", "venv", folder], [inside, "-m", "pip", "install", "--quiet", *needs.packages]):
        done = subprocess.run([str(c) for c in command], capture_output=True, text=True, check=False)
        if done.returncode:
            return "", (done.stderr.strip().splitlines() or ["unknown"])[-1]
    return (str(inside), "") if _imports(str(inside), needs) else ("", "installed, but does not import")


def unpacked(package: str, cache: Path) -> str:
    """Put a package of Debian, with all that it needs and is not installed, below cache/debian-PACKAGE.

    Returns:
        "" or the reason why there is none.
    """
    folder, archives = (cache / f"debian-{package}").resolve(), (cache / f"archives-{package}").resolve()
    if folder.exists():
        return ""
    if shutil.which("apt-get") is None:
        return "no apt-get on this machine"
    archives.mkdir(parents=True, exist_ok=True)
    plan = subprocess.run(
        ["apt-get", "install", "--simulate", "--no-install-recommends", package],
        capture_output=True,
        text=True,
        check=False,
    )
    missing = [line.split()[1] for line in plan.stdout.splitlines() if line.startswith("Inst ")]
    if not missing:
        return f"apt-get finds no {package}; apt-get update may help"
    done = subprocess.run(["apt-get", "download", *missing], cwd=archives, capture_output=True, text=True, check=False)
    if done.returncode:
        return (done.stderr.strip().splitlines() or ["unknown"])[-1]
    partial = folder.with_suffix(".partial")
    for archive in archives.glob("*.deb"):
        subprocess.run(["dpkg", "-x", archive, partial], check=True)
    shutil.rmtree(archives)
    partial.rename(folder)
    return ""


def _base(version: str) -> str:
    """An interpreter of a version: on the path, or among pyenv's."""
    if not version:
        return sys.executable
    # pyenv's first: a name on the path may be its shim of another version
    known = sorted((Path.home() / ".pyenv" / "versions").glob(f"{version}*/bin/python"))
    return str(known[-1]) if known else shutil.which(f"python{version}") or ""


def _imports(python: str, needs: Needs) -> bool:
    if not Path(python).exists():
        return False
    command = [python, "-c", "import " + ", ".join(needs.modules)]
    return subprocess.run(command, capture_output=True, check=False).returncode == 0
