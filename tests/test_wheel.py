"""What a package index would get: every file of the package, typed, under a name that is free, with its metadata."""

import email
import subprocess
import sys
from email.message import Message
from pathlib import Path
from zipfile import ZipFile

import pytest

from fusion import __version__

PROJECT = Path(__file__).resolve().parent.parent


@pytest.fixture(scope="module")
def wheel(tmp_path_factory) -> ZipFile:
    folder = tmp_path_factory.mktemp("wheel")
    build = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)]
    subprocess.run(build, cwd=PROJECT, check=True, capture_output=True, timeout=60)
    (path,) = folder.iterdir()
    assert path.name == f"fusion_scan-{__version__}-py3-none-any.whl"
    return ZipFile(path)


@pytest.fixture(scope="module")
def metadata(wheel) -> Message:
    return email.message_from_bytes(wheel.read(f"fusion_scan-{__version__}.dist-info/METADATA"))


def test_it_holds_every_file_of_the_package_and_no_other(wheel):
    ours = {path.relative_to(PROJECT).as_posix() for path in (PROJECT / "fusion").rglob("*") if path.is_file()}
    ours = {name for name in ours if "__pycache__" not in name}
    assert "fusion/py.typed" in ours
    assert {name for name in wheel.namelist() if ".dist-info/" not in name} == ours


def test_it_brings_the_command(wheel):
    entries = wheel.read(f"fusion_scan-{__version__}.dist-info/entry_points.txt").decode()
    assert "fusion = fusion.commands.console:run" in entries


def test_its_metadata_says_what_it_is(metadata):
    assert metadata["Name"] == "fusion-scan"
    assert "3D scanning" in metadata["Summary"]
    assert metadata["License-Expression"] == "Apache-2.0"
    assert "turntable" in metadata["Keywords"]
    assert "Typing :: Typed" in metadata.get_all("Classifier")
    assert metadata["Description-Content-Type"] == "text/markdown"
    assert metadata.get_payload().startswith("# fusion")


def test_it_requires_one_open3d_and_no_tools_nor_devices(metadata):
    always = [line for line in metadata.get_all("Requires-Dist") if "extra ==" not in line]
    assert not [line for line in always if line.startswith(("pytest", "ruff", "mypy", "evo", "pyusb"))]
    builds = dict(line.split("; ") for line in always if line.startswith("open3d"))
    markers = {name.split("<")[0]: marker for name, marker in builds.items()}
    assert set(markers) == {"open3d-cpu", "open3d"}
    for system, machine, build in [
        ("linux", "x86_64", "open3d-cpu"),
        ("linux", "aarch64", "open3d"),
        ("darwin", "arm64", "open3d"),
        ("win32", "AMD64", "open3d"),
    ]:
        place = {"sys_platform": system, "platform_machine": machine}
        assert [name for name, marker in markers.items() if eval(marker, {}, place)] == [build]
