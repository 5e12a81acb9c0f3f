"""Batches on real workers: killed ones, broken recordings, any number of workers, a scheduler of one's own."""

import csv
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest

from fusion.batch.job import JobLimits
from fusion.batch.listing import items_in
from fusion.batch.run import Batch, BatchSettings, run_batch

pytest.importorskip("distributed", reason="comes with the extra batch")
pytest.importorskip("pyarrow", reason="comes with the extra batch")
pytestmark = [pytest.mark.slow, pytest.mark.filterwarnings("ignore::ResourceWarning")]

RUNNER = "light_command:run"
WORDS = ["do", "{rec}", "{out}"]


@pytest.fixture
def scans(tmp_path, monkeypatch):
    """Makes a folder of recordings with these habits."""
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parent))

    def make(*habits: str) -> Path:
        for number, habit in enumerate(habits):
            folder = tmp_path / "scans" / f"s{number}"
            folder.mkdir(parents=True)
            (folder / "habit.txt").write_text(habit + " " * number)  # no two are the same
        return tmp_path / "scans"

    return make


def run(scans: Path, home: Path, workers: int = 2, **more) -> Batch:
    items, _ = items_in(scans)
    return run_batch(items, WORDS, home, BatchSettings(workers, runner=RUNNER, **more))


def runs(scans: Path) -> Counter[str]:
    return Counter((scans / "runs.log").read_text().split())


def content(home: Path) -> dict[str, bytes]:
    """All files of a batch but for those that tell how long it took."""
    files = {path.relative_to(home).as_posix(): path for path in home.rglob("*") if path.is_file()}
    return {name: path.read_bytes() for name, path in files.items() if name != "timings.csv"}


def test_killed_workers_and_broken_recordings_leave_37_results_and_3_rows(scans, tmp_path):
    habits = ["kill" if n in (3, 9, 15, 21, 27) else "bad" if n in (5, 17, 30) else "good" for n in range(40)]
    made, home = scans(*habits), tmp_path / "out"
    batch = run(made, home)
    status = Counter(row.status for row in batch.rows)
    assert status == {"done": 37, "refused": 3}, [row.reason for row in batch.rows if row.reason]
    assert all("the recording is broken" in row.reason for row in batch.rows if row.status == "refused")
    assert len([path for path in home.iterdir() if path.name.startswith("s")]) == 37
    once = runs(made)
    assert all(count >= 2 for name, count in once.items() if habits[int(name[1:])] == "kill")
    before = content(home)
    again = run(made, home)
    assert not again.done and runs(made) == once and content(home) == before
    with (home / "results.csv").open(newline="") as file:
        assert [row["recording"] for row in csv.DictReader(file)] == [f"s{n}" for n in range(40)]
    assert not list(home.glob(".partial-*"))


def test_limits_stop_a_job_and_not_the_batch(scans, tmp_path):
    made = scans("sleep", "good", "hog", "crash", "full", "good")
    batch = run(made, tmp_path / "out", limits=JobLimits(seconds=3.0, gigabytes=0.3))
    assert [row.status for row in batch.rows] == ["stopped", "done", "stopped", "stopped", "stopped", "done"]
    told = [row.reason for row in batch.rows]
    assert "3 s" in told[0] and ("0.3 GB" in told[2] or "3 s" in told[2]) and "signal 11" in told[3]
    assert "the disk is full" in told[4]  # which does not lie in the recording: the next run tries again


@pytest.fixture
def scheduler(tmp_path):
    """Address of a scheduler with two workers, started as a user would."""
    file = tmp_path / "scheduler.json"
    start = [sys.executable, "-m", "distributed.cli.dask_scheduler"]
    common = ["--scheduler-file", str(file), "--host", "127.0.0.1", "--no-dashboard"]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    running = [subprocess.Popen([*start, *common, "--port", "0"], **quiet)]
    worker = [sys.executable, "-m", "distributed.cli.dask_worker", "--nthreads", "1", "--nworkers", "2"]
    running.append(subprocess.Popen([*worker, *common, "--local-directory", str(tmp_path / "dask")], **quiet))
    import json
    import time

    for _ in range(300):
        if file.exists() and file.stat().st_size:
            break
        time.sleep(0.1)
    yield json.loads(file.read_text())["address"]
    for one in reversed(running):
        one.terminate()
        one.wait(20)


def test_the_files_do_not_depend_on_who_works(scans, tmp_path, scheduler):
    """One worker, four, and a scheduler with workers of its own on loopback: equal bit for bit."""
    made = scans(*["good"] * 5, "bad")
    one = run(made, tmp_path / "one", workers=1)
    four = run(made, tmp_path / "four", workers=4)
    other = run(made, tmp_path / "other", scheduler=scheduler)
    assert one.rows == four.rows == other.rows
    assert content(tmp_path / "one") == content(tmp_path / "four") == content(tmp_path / "other")
