"""Where compiled kernels are kept: also where there is no home, or one that cannot be written to."""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from fusion.compute.back_end import KEPT
from fusion.compute.kept import kept_in

START = "from fusion.compute import start; print(start.start()); start.keep_kernels()"


@pytest.fixture
def elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Nothing says where; temporary files have a place of their own, and a home would be a file."""
    for name in (KEPT[0], "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    (tmp_path / "file").touch()
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(temporary))
    monkeypatch.setenv("HOME", str(tmp_path / "file"))
    return temporary


def test_below_the_home(elsewhere: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where it can be made; what a user says goes first."""
    monkeypatch.setenv("HOME", str(tmp_path))
    assert kept_in() == tmp_path / ".cache" / "fusion" / KEPT[1]
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    assert kept_in() == tmp_path / "cache" / "fusion" / KEPT[1]
    monkeypatch.setenv(KEPT[0], str(tmp_path / "own"))
    assert kept_in() == tmp_path / "own"
    assert (tmp_path / "own").is_dir()


def test_a_home_that_cannot_be_written_to(elsewhere: Path) -> None:
    """A folder of this user's alone, the same each time."""
    folder = kept_in()
    assert folder is not None and folder.parent == elsewhere
    assert folder.stat().st_mode & 0o077 == 0
    assert kept_in() == folder


def test_no_home_at_all(elsewhere: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A number without a name, as in a container."""

    def none() -> Path:
        raise RuntimeError("could not determine home directory")

    monkeypatch.setattr(Path, "home", none)
    folder = kept_in()
    assert folder is not None and folder.parent == elsewhere


def test_a_folder_that_others_can_write_to(elsewhere: Path) -> None:
    """What lies in it would be run: it is not taken."""
    folder = kept_in()
    assert folder is not None
    folder.chmod(0o777)
    assert kept_in() is None


@pytest.mark.parametrize("case", ["no home", "a file", "kept nowhere"])
def test_a_process_without_a_home_starts_and_ends(tmp_path: Path, case: str) -> None:
    """The back end took it down at its import, at its start or at its end."""
    environment = {name: value for name, value in os.environ.items() if name not in ("HOME", "XDG_CACHE_HOME", KEPT[0])}
    environment["TMPDIR"] = str(tmp_path)
    if case != "no home":
        (tmp_path / "file").touch()
        environment["HOME"] = str(tmp_path / "file")
    if case == "kept nowhere":
        folder = tmp_path / f"fusion-{KEPT[1]}-{os.getuid()}"
        folder.mkdir()
        folder.chmod(0o777)
    ran = subprocess.run([sys.executable, "-c", START], env=environment, capture_output=True, text=True, check=False)
    assert (ran.returncode, ran.stdout) == (0, "cpu\n"), ran.stderr
