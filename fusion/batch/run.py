"""A command over many recordings, from the list to the tables and the page."""

import os
from collections.abc import Sequence
from concurrent.futures import CancelledError
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from fusion import __version__
from fusion.batch.cluster import client_of
from fusion.batch.fingerprint import fingerprint, key_of
from fusion.batch.job import OUT, RECORDING, Job, JobLimits, JobRow, filled, plain_name
from fusion.batch.listing import Item
from fusion.batch.page import write_index
from fusion.batch.place import mark
from fusion.batch.table import write_tables, write_timings
from fusion.batch.work import Done, forget, kept, work
from fusion.errors import FusionError
from fusion.files.extra import extra
from fusion.files.output.staging import sweep
from fusion.progress import each

RUNNER = "fusion.commands.main:main"


@dataclass(frozen=True)
class BatchSettings:
    """How a batch runs."""

    workers: int = 2  # processes on this machine, one job each at a time
    scheduler: str | None = None  # address of a Dask scheduler whose workers are used instead
    limits: JobLimits = field(default_factory=JobLimits)  # of one job
    retry: bool = False  # what was refused before is tried again
    again: bool = False  # what was done before is done again, and replaced
    runner: str = RUNNER  # "module:function" that runs the words of a command and gives its exit status


@dataclass(frozen=True)
class Batch:
    """What became of a batch."""

    rows: tuple[JobRow, ...]  # one for each recording, in the order of the list
    done: tuple[Done, ...]  # of the jobs that this run did

    def __repr__(self) -> str:
        count = {status: sum(row.status == status for row in self.rows) for status in ("done", "refused", "stopped")}
        told = ", ".join(f"{number} {status}" for status, number in count.items() if number)
        return f"<Batch of {len(self.rows)}: {told}; {len(self.done)} in this run>"


def run_batch(
    items: Sequence[Item], words: Sequence[str], home: Path | str, settings: BatchSettings | None = None
) -> Batch:
    """Run a command on each of many recordings, on Dask's workers; what was done before is not done again.

    A job's key is the hash of what is in its recording and in the files that its words name, of its words and of the
    program's version; its folder `NAME-KEY` appears in `home` whole or not at all. A job that fails becomes a row.

    Args:
        items: `items_in(folder or list)`.
        words: of the command, with `{rec}` and `{out}`, and `{column}` for further columns of a list.
        home: where the folders appear, with results.csv, results.parquet, index.html and timings.csv.
        settings: workers, limits.

    Raises:
        FusionError: the words lack `{rec}` or `{out}`, dask is not installed, or no scheduler answers.
    """
    settings, home = settings or BatchSettings(), Path(home).resolve()
    for needed in (RECORDING, OUT):
        if not any(needed in word for word in words):
            do = "for instance -- turntable {rec} -o {out}"
            raise FusionError(f"the command has no {needed}", "COMMAND", " ".join(words), f"{{rec}} and {{out}}, {do}")
    extra("pyarrow", "batch", "fusion batch", "")
    home.mkdir(parents=True, exist_ok=True)
    mark(home)
    with client_of(settings.workers, settings.scheduler) as client:
        jobs = _jobs(client, items, list(words), home, settings)
        _forget(home, jobs, settings)
        rows = {job.folder: kept(home, job) for job in jobs}
        todo = list({job.folder: job for job in jobs if rows[job.folder] is None}.values())
        done = _run(client, todo)
    sweep(home)  # what killed workers left
    rows |= {job.folder: one.row for job, one in zip(todo, done, strict=True)}
    found = [(rows[job.folder], job) for job in jobs]
    told = tuple(replace(row, recording=job.named) for row, job in found if row is not None)
    write_tables(home, told)
    write_index(home, told, list(words))
    write_timings(home, done)
    return Batch(told, tuple(done))


def _jobs(client: Any, items: Sequence[Item], words: list[str], home: Path, settings: BatchSettings) -> list[Job]:
    """A job for each item: workers look at the files, each file once."""
    here = Path.cwd()
    said = [tuple(_absolute(word, here) for word in filled(words, _values(item))) for item in items]
    paths = sorted({_file_in(word) for line in said for word in line} - {""})
    looked = dict(zip(paths, client.gather(client.map(_look, paths, pure=False)), strict=True))
    jobs = []
    for item, line in zip(items, said, strict=True):
        files = {word: _marked(word, looked) for word in line if _file_in(word)}
        key = key_of(__version__, list(line), files)
        told = (settings.runner, settings.limits, settings.again)
        jobs.append(Job(item.named, plain_name(item.path), key, line, str(home), *told))
    return jobs


def _forget(home: Path, jobs: Sequence[Job], settings: BatchSettings) -> None:
    for job in jobs:
        row = kept(home, job)
        if row is not None and (settings.again or (settings.retry and row.status == "refused")):
            forget(home, job)


def _values(item: Item) -> dict[str, str]:
    return {**item.columns, "rec": os.fspath(item.path.resolve())}


def _absolute(word: str, here: Path) -> str:
    """A word that names a file or folder, from the root: a job runs elsewhere."""
    option, equals, value = word.rpartition("=") if word.startswith("--") and "=" in word else ("", "", word)
    path = here / value
    there = bool(value) and not value.startswith("-") and OUT not in value and _exists(path)
    return f"{option}{equals}{path.resolve()}" if there else word


def _file_in(word: str) -> str:
    """The file or folder that a word names, "" where it names none."""
    value = word.rpartition("=")[2] if word.startswith("--") else word
    return value if value.startswith("/") and _exists(Path(value)) else ""


def _exists(path: Path) -> bool:
    try:
        return path.exists()
    except (OSError, ValueError):
        return False


def _marked(word: str, looked: dict[str, str]) -> str:
    """The word with what is in its file instead of where that lies."""
    path = _file_in(word)
    return f"{word.removesuffix(path)}{looked[path]}"


def _look(path: str) -> str:
    """Fingerprint of a file; what cannot be read is the command's to tell."""
    try:
        return fingerprint(path)
    except OSError as error:
        return f"{path}: {error.strerror}"


def _run(client: Any, jobs: list[Job]) -> list[Done]:
    """All jobs to their end, in the order of the list."""
    from distributed import as_completed

    futures = {client.submit(work, job, key=f"job-{job.folder}", pure=False): job for job in jobs}
    found: dict[str, Done] = {}
    for future in each(as_completed(futures), "running jobs", len(jobs)):
        job = futures[future]
        try:
            found[job.folder] = future.result()
        except (Exception, CancelledError) as error:
            reason = f"no worker brought it to its end ({type(error).__name__}: {error})"[:500]
            row = JobRow(job.named, job.name, "stopped", "failed", reason, "", job.key)
            found[job.folder] = Done(row, 0.0, 0.0, "")
    return [found[job.folder] for job in jobs]
