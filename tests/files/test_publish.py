"""A result stands whole under its name, or not at all; the same command then works again."""

import errno
import os
import signal
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from fusion.errors import FusionError, RecordingError
from fusion.files.output.publish import atomic_file, output_folder

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


def test_folders_around_it_come_with_it_and_not_before(tmp_path):
    with pytest.raises(ValueError, match="broken"), output_folder(tmp_path / "a" / "b" / "out"):
        raise ValueError("broken")
    assert names(tmp_path) == []
    with output_folder(tmp_path / "a" / "b" / "out") as partial:
        (partial / "mesh.ply").write_text("whole")
        assert not (tmp_path / "a").exists()
    assert names(tmp_path / "a" / "b" / "out") == ["mesh.ply"]


def test_two_that_need_the_same_new_folder_both_find_their_place(tmp_path):
    with atomic_file(tmp_path / "a" / "b" / "1.txt") as one, atomic_file(tmp_path / "a" / "b" / "2.txt") as two:
        one.write_text("1")
        two.write_text("2")
    assert names(tmp_path / "a" / "b") == ["1.txt", "2.txt"]


def test_a_link_leads_to_where_the_result_goes(tmp_path):
    (tmp_path / "real").mkdir()
    (tmp_path / "link").symlink_to("real")
    (tmp_path / "to_come").symlink_to("new")
    for name in ("link", "to_come"):
        with output_folder(tmp_path / name) as partial:
            (partial / "mesh.ply").write_text("whole")
        assert (tmp_path / name).is_symlink()
    assert names(tmp_path / "real") == names(tmp_path / "new") == ["mesh.ply"]


@pytest.mark.parametrize("name", ["loop", "n" * 5000, "a\0b"])
def test_a_name_that_nothing_can_have_is_told(tmp_path, name):
    (tmp_path / "loop").symlink_to("loop")
    with pytest.raises(FusionError, match="output's name"), output_folder(tmp_path / name):
        raise AssertionError("no work is done")


@pytest.mark.parametrize("exchange", [True, False])
def test_files_of_others_are_the_same_files_afterwards(tmp_path, monkeypatch, exchange):
    """No copies, which would lose what is written into them meanwhile; also where names cannot be exchanged."""
    if not exchange:
        monkeypatch.setattr("ctypes.CDLL", lambda *_, **__: object())  # a C library without renameat2
    out = tmp_path / "out"
    (out / "notes" / "empty").mkdir(parents=True)
    (out / "notes" / "1.txt").write_text("mine")
    (out / "link").symlink_to("nowhere")
    (out / "mesh.ply").write_text("older")
    before = (out / "notes" / "1.txt").stat().st_ino
    with output_folder(out) as partial:
        (partial / "mesh.ply").write_text("newer")
    assert names(out) == ["link", "mesh.ply", "notes"]
    assert names(out / "notes") == ["1.txt", "empty"]
    assert (out / "notes" / "1.txt").stat().st_ino == before
    assert (out / "link").readlink() == Path("nowhere")
    assert (out / "mesh.ply").read_text() == "newer"
    assert names(tmp_path) == ["out"]


def test_a_stop_between_the_two_steps_of_a_poor_file_system_is_put_right(tmp_path, monkeypatch):
    monkeypatch.setattr("ctypes.CDLL", lambda *_, **__: object())  # a C library without renameat2
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "mesh.ply").write_text("older")
    rename = Path.rename

    def stopped(self, target):
        if Path(target) == tmp_path / "out" and "new" in self.parts:
            raise KeyboardInterrupt
        return rename(self, target)

    monkeypatch.setattr(Path, "rename", stopped)
    with pytest.raises(KeyboardInterrupt), output_folder(tmp_path / "out") as partial:
        (partial / "mesh.ply").write_text("newer")
    assert (tmp_path / "out" / "mesh.ply").read_text() == "older"
    assert names(tmp_path) == ["out"]


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EDQUOT])
def test_a_full_disk_is_blamed_and_not_what_was_read(tmp_path, number):
    with pytest.raises(FusionError, match=rf"the disk.*{tmp_path.name}/out;.*free in /") as found:  # noqa: SIM117
        with output_folder(tmp_path / "out"):
            try:
                raise OSError(number, os.strerror(number))
            except OSError as error:
                raise RecordingError("the image cannot be copied", "source.png") from error
    assert "source.png" not in str(found.value)
    assert names(tmp_path) == []


def test_a_folder_that_cannot_be_written_is_told_before_the_work(tmp_path, monkeypatch):
    def refused(self, *_):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(self))

    monkeypatch.setattr(Path, "mkdir", refused)
    with (
        pytest.raises(FusionError, match=r"cannot be written.*out.*Permission denied"),
        output_folder(tmp_path / "out"),
    ):
        raise AssertionError("no work is done")


def test_a_file_where_a_folder_should_be_is_told(tmp_path):
    (tmp_path / "taken").write_text("")
    with pytest.raises(FusionError, match=r"not a folder.*taken"), output_folder(tmp_path / "taken"):
        pass
    with (
        pytest.raises(FusionError, match=r"cannot be written.*taken.*Not a directory"),
        output_folder(tmp_path / "taken" / "out"),
    ):
        pass
    with (
        pytest.raises(FusionError, match=r"cannot be written.*taken.*Not a directory"),
        atomic_file(tmp_path / "taken" / "a.ply"),
    ):
        pass


@pytest.mark.skipif(os.name != "posix", reason="needs POSIX signals")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL], ids=lambda number: number.name)
def test_a_stopped_process_leaves_no_half_result(tmp_path, number):
    program = """
import signal, sys, time
signal.signal(signal.SIGINT, signal.default_int_handler)  # a background job may have it switched off
from pathlib import Path
from fusion.files.output.publish import output_folder
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
    assert names(tmp_path) == ["out"]  # and what the dead process left is gone
