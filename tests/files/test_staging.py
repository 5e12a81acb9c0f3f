"""What dead processes left is swept away; what lives, or is not ours, stays."""

import shutil
from pathlib import Path

import pytest

from fusion.files.output import staging as module
from fusion.files.output.staging import staging, sweep


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def dead(folder: Path, token: str = "0123abcd", machine: list[str] | None = None) -> Path:
    """A place as a process leaves it that was killed."""
    place = folder / f".partial-{token}"
    (place / "new" / "out").mkdir(parents=True)
    (place / "new" / "out" / "mesh.ply").write_text("half")
    (place / "lock").write_text("\n".join([*(machine or module._machine()), "out"]))
    return place


def test_the_next_result_sweeps_what_the_dead_left(tmp_path):
    dead(tmp_path)
    with staging(tmp_path / "other"):
        pass
    assert names(tmp_path) == []


def test_what_a_living_process_makes_stays(tmp_path):
    with staging(tmp_path / "out") as living:
        sweep(tmp_path)
        assert living.made.parent.is_dir()
    assert names(tmp_path) == []


@pytest.mark.parametrize("left", [[], ["lock"], ["lock", "new"], ["lock", "old"]], ids=str)
def test_a_sweep_that_was_stopped_itself_is_finished(tmp_path, left):
    place = tmp_path / ".partial-0123abcd"
    place.mkdir()
    for name in left:
        (place / name).touch() if name == "lock" else (place / name).mkdir()
    sweep(tmp_path)
    assert names(tmp_path) == []


def test_a_place_of_another_machine_stays_for_its_lock_may_not_be_seen_here(tmp_path):
    dead(tmp_path, machine=["elsewhere", "1234"])
    sweep(tmp_path)
    assert names(tmp_path) == [".partial-0123abcd"]


def test_after_a_new_start_and_in_another_container_the_dead_are_known(tmp_path):
    name, start = module._machine()
    dead(tmp_path, "00000001", [name, "an earlier start"])
    dead(tmp_path, "00000002", ["another container", start])
    sweep(tmp_path)
    assert names(tmp_path) == []


def test_what_only_looks_like_ours_stays(tmp_path):
    (dead(tmp_path, "00000001") / "mine.txt").write_text("mine")
    (dead(tmp_path, "00000002") / "lock").unlink()
    (tmp_path / ".partial-00000003").write_text("a file")
    (tmp_path / ".partial-upload").mkdir()
    (tmp_path / ".partial-00000004").symlink_to(tmp_path / ".partial-upload")
    before = names(tmp_path)
    sweep(tmp_path)
    assert names(tmp_path) == before


def test_a_result_that_was_moved_aside_returns(tmp_path):
    place = dead(tmp_path)
    shutil.move(place / "new" / "out", tmp_path / "kept")
    (place / "old").mkdir()
    shutil.move(tmp_path / "kept", place / "old" / "out")
    sweep(tmp_path)
    assert names(tmp_path) == ["out"]
    assert (tmp_path / "out" / "mesh.ply").exists()


def test_without_locks_in_the_file_system_results_are_made_and_nothing_is_swept(tmp_path, monkeypatch):
    def no_locks(*_):
        raise OSError(37, "No locks available")

    monkeypatch.setattr(module.fcntl, "flock", no_locks)
    dead(tmp_path)
    with staging(tmp_path / "out") as at:
        at.made.mkdir()
    assert names(tmp_path) == [".partial-0123abcd"]


def test_a_place_that_was_swept_before_it_was_held_is_made_anew(tmp_path, monkeypatch):
    swept = []

    def flock(lock, how):
        if not swept:
            swept.append(next(tmp_path.iterdir()))
            shutil.rmtree(swept[0])
        return held(lock, how)

    held = module.fcntl.flock
    monkeypatch.setattr(module.fcntl, "flock", flock)
    with staging(tmp_path / "out") as at:
        assert at.folder != swept[0]
        assert at.folder.is_dir()
    assert names(tmp_path) == []


@pytest.mark.skipif(not Path("/proc/self").exists(), reason="of Linux")
def test_a_file_system_that_holds_no_new_folder_is_no_endless_try():
    with pytest.raises(OSError), staging(Path("/proc/out")):
        pass
