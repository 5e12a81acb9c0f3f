"""What a worker does: one job to its end, and the row that tells of it."""

import json
import time
from dataclasses import asdict, dataclass, replace
from pathlib import Path

from fusion.batch.job import Job, JobRow
from fusion.batch.numbers import light_of, numbers_in, unread_in
from fusion.batch.thumbnail import write_thumbnail
from fusion.batch.warm import Answer, run_warm
from fusion.files.output.publish import atomic_file

BOOKS = ".batch"  # in the batch's folder: a row and a picture of each job
REASON = 500  # characters


@dataclass(frozen=True)
class Done:
    """A row, and what is another one each time.

    Attributes:
        row: of the job.
        seconds: the command ran.
        whole_s: the job took on the worker.
        worker: who did it.
    """

    row: JobRow
    seconds: float
    whole_s: float
    worker: str


def work(job: Job) -> Done:
    """Run a job on this worker; whatever happens to it becomes a row.

    Where its folder stands already it is whole, and not made again: a worker that dies takes with it what it has told
    of jobs that are done, and they are given out anew.
    """
    begun, home = time.perf_counter(), Path(job.home)
    if (row := kept(home, job)) is not None:
        return Done(row, 0.0, 0.0, _worker())
    there = (home / job.folder).exists() and not job.again
    answer = Answer(0, "", 0.0) if there else run_warm(job.said, job.home, job.runner, job.limits)
    row = _row(job, answer, home / job.folder)
    keep(home, job, row)
    return Done(row, answer.seconds, time.perf_counter() - begun, _worker())


def kept(home: Path, job: Job) -> JobRow | None:
    """The row of a job that was done before, or refused; None where there is something to do."""
    try:
        content = json.loads((home / BOOKS / f"{job.folder}.json").read_text(encoding="utf-8"))
        row = JobRow(**content | {"recording": job.named, "name": job.name})
    except (OSError, ValueError, TypeError):
        return None
    if row.status == "done" and not (home / job.folder).exists():
        return None
    return row if row.status in ("done", "refused") and row.key == job.key else None


def forget(home: Path, job: Job) -> None:
    """Take the row of a job out of the books, so that it is done again."""
    (home / BOOKS / f"{job.folder}.json").unlink(missing_ok=True)


def keep(home: Path, job: Job, row: JobRow) -> None:
    """Put a row, and a picture of the result, into the books."""
    books = home / BOOKS
    books.mkdir(exist_ok=True)
    if row.folder:
        write_thumbnail(home / row.folder, books / f"{job.folder}.jpg", [Path(word) for word in job.words])
    with atomic_file(books / f"{job.folder}.json") as partial:
        partial.write_text(json.dumps(asdict(row), indent=1) + "\n", encoding="utf-8")


def _row(job: Job, answer: Answer, folder: Path) -> JobRow:
    there = job.folder if folder.exists() else ""
    numbers = numbers_in(folder) if there and folder.is_dir() else {}
    row = JobRow(job.named, job.name, "done", "done", "", there, job.key, numbers)
    if answer.status is None:
        return replace(row, status="stopped", light="failed", reason=answer.said)
    if answer.status:
        status = "refused" if answer.status in (1, 2) else "stopped"
        return replace(row, status=status, light="failed", reason=_reason(answer.said))
    if not there:
        return replace(row, status="refused", light="failed", reason="the command wrote nothing to {out}")
    light, reason = light_of(folder)
    return replace(row, light=light, reason=reason or unread_in(numbers))


def _reason(said: str) -> str:
    """The line in which a command says what is wrong, without its name."""
    lines = [line for line in said.splitlines() if line.strip()]
    told = [line for line in lines if line.startswith("fusion ") and ": " in line]
    line = told[-1].partition(": ")[2] if told else lines[-1] if lines else "the command said nothing"
    return line.strip()[:REASON]


def _worker() -> str:
    from distributed import get_worker

    try:
        return str(get_worker().address)
    except ValueError:  # called where there is none
        return ""
