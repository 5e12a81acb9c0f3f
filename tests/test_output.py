"""A result stands whole under its name, or not at all; the same command then works again."""

import os
import signal
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from fusion.errors import FusionError
from fusion.output import atomic_file, output_folder

STOPS = [ValueError("broken"), KeyboardInterrupt(), SystemExit(3), MemoryError()]


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def test_a_file_appears_whole_and_keeps_its_ending(tmp_path):
    with atomic_file(tmp_path / "new" / "mesh.ply") as partial:
        partial.write_text("whole")
        assert partial.suffix == ".ply"  # writers choose the format by it
        assert not (tmp_path / "new" / "mesh.ply").exists()
    assert (tmp_path / "new" / "mesh.ply").read_text() == "whole"
    assert names(tmp_path / "new") == ["mesh.ply"]


@pytest.mark.parametrize("stop", STOPS, ids=lambda stop: type(stop).__name__)
def test_a_stopped_file_leaves_nothing_and_starts_again(tmp_path, stop):
    with pytest.raises(type(stop)), atomic_file(tmp_path / "mesh.ply") as partial:
        partial.write_text("half")
        raise stop
    assert names(tmp_path) == []
    with atomic_file(tmp_path / "mesh.ply") as partial:
        partial.write_text("whole")
    assert names(tmp_path) == ["mesh.ply"]


@pytest.mark.parametrize("stop", STOPS, ids=lambda stop: type(stop).__name__)
def test_a_stopped_file_keeps_the_older_result(tmp_path, stop):
    (tmp_path / "mesh.ply").write_text("older")
    with pytest.raises(type(stop)), atomic_file(tmp_path / "mesh.ply") as partial:
        partial.write_text("half")
        raise stop
    assert (tmp_path / "mesh.ply").read_text() == "older"
    assert names(tmp_path) == ["mesh.ply"]


@pytest.mark.parametrize("stop", STOPS, ids=lambda stop: type(stop).__name__)
def test_a_stopped_folder_leaves_nothing_and_starts_again(tmp_path, stop):
    with pytest.raises(type(stop)), output_folder(tmp_path / "out") as partial:
        (partial / "mesh.ply").write_text("half")
        raise stop
    assert names(tmp_path) == []
    with output_folder(tmp_path / "out") as partial:
        (partial / "mesh.ply").write_text("whole")
    assert names(tmp_path) == ["out"]
    assert names(tmp_path / "out") == ["mesh.ply"]


def test_a_folder_replaces_its_own_files_only(tmp_path):
    for name in ["notes.txt", "mesh.ply", "depth/old.png"]:
        (tmp_path / "out" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "out" / name).write_text("older")
    with output_folder(tmp_path / "out") as partial:
        (partial / "mesh.ply").write_text("newer")
        (partial / "depth").mkdir()
        (partial / "depth" / "new.png").write_text("newer")
    assert names(tmp_path / "out") == ["depth", "mesh.ply", "notes.txt"]
    assert names(tmp_path / "out" / "depth") == ["new.png"]
    assert (tmp_path / "out" / "mesh.ply").read_text() == "newer"
    assert (tmp_path / "out" / "notes.txt").read_text() == "older"


def test_results_have_the_rights_that_the_user_chose(tmp_path):
    before = os.umask(0o027)
    try:
        with atomic_file(tmp_path / "a.json") as partial:
            partial.write_text("{}")
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "a.json").stat().st_mode) == 0o640


def test_a_file_where_a_folder_should_be_is_told(tmp_path):
    (tmp_path / "taken").write_text("")
    with pytest.raises(FusionError, match=r"not a folder.*taken"), output_folder(tmp_path / "taken"):
        pass
    with pytest.raises(FusionError, match=r"cannot be made.*taken"), output_folder(tmp_path / "taken" / "out"):
        pass
    with pytest.raises(FusionError, match=r"cannot be made.*taken"), atomic_file(tmp_path / "taken" / "a.ply"):
        pass


@pytest.mark.skipif(os.name != "posix", reason="needs POSIX signals")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL], ids=lambda number: number.name)
def test_a_stopped_process_leaves_no_half_result(tmp_path, number):
    program = """
import signal, sys, time
signal.signal(signal.SIGINT, signal.default_int_handler)  # a background job may have it switched off
from pathlib import Path
from fusion.output import output_folder
with output_folder(Path(sys.argv[1])) as partial:
    (partial / "mesh.ply").write_text("half")
    print("ready", flush=True)
    time.sleep(60)
"""
    command = [sys.executable, "-c", program, str(tmp_path / "out")]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        process.send_signal(number)
        assert process.wait(timeout=30) != 0
    assert not (tmp_path / "out").exists()
    if number == signal.SIGINT:  # Ctrl-C is the only one of these that lets Python tidy up
        assert names(tmp_path) == []
    with output_folder(tmp_path / "out") as partial:
        (partial / "mesh.ply").write_text("whole")
    assert names(tmp_path / "out") == ["mesh.ply"]
