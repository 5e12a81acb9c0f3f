"""What a worker does: one job to its end, and the row that tells of it."""

import json
import time
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import msgspec

from fusion.batch.job import Job, JobRow
from fusion.batch.thumbnail import write_thumbnail
from fusion.batch.warm import Answer, run_warm
from fusion.errors import FusionError
from fusion.files.json_file import read_json
from fusion.files.output.publish import atomic_file
from fusion.files.output.refused import of_the_disk
from fusion.results.judgement import worth_of
from fusion.results.light import LEVELS, Light, worst_first

BOOKS = ".batch"  # in the batch's folder: a row and a picture of each job
REASON = 500  # characters
# files that state what was given, and not what came out, but for these of their keys
GIVEN = {"settings": ("result", "agreement", "judgement")}
DEEPEST = 6
FEW = 8  # entries of a list that are numbers of the result; longer ones are curves, or there is one for each frame
LONGEST = 200  # characters of a text
MOST = 1000  # numbers of one result
LIGHTS = ("good", "doubtful", "failed")
Value = float | int | bool | str


@dataclass(frozen=True)
class Done:
    """A row, and what is another one each time."""

    row: JobRow  # of the job
    seconds: float  # the command ran
    whole_s: float  # the job took on the worker
    worker: str  # who did it


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
        status = "refused" if answer.status in (1, 2) and not of_the_disk(answer.said) else "stopped"
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


def numbers_in(folder: Path) -> dict[str, Value]:
    """`file.key.key` to number, text or truth value, of the JSON files in a folder; short lists by place."""
    found: dict[str, Value] = {}
    for stem, content in _contents(folder).items():
        if stem in GIVEN:
            content = {key: content[key] for key in GIVEN[stem] if key in content}
        for name, value in _flat(content, stem):
            if len(found) < MOST:
                found[name] = value
    return found


def _contents(folder: Path) -> dict[str, Mapping[str, Any]]:
    """What stands in the JSON files of a folder that can be read, by their names without the ending, in their order."""
    found: dict[str, Mapping[str, Any]] = {}
    for path in sorted(folder.glob("*.json")):
        if not path.name.startswith("."):
            with suppress(FusionError):
                found[path.stem] = read_json(path)
    return found


def light_of(folder: Path) -> tuple[str, str]:
    """The verdict of a result in one word, and its worst reason; "done" where nothing is judged.

    That is what a file of the result says in so many words (`verdict`, `reasons`), else what the lights come to that a
    command wrote (`judgement`), whatever its file is called.
    """
    found = _contents(folder) if folder.is_dir() else {}
    for content in (found[name] for name in ("turntable", "merge", "settings") if name in found):
        for holder in (content, content.get("judgement")):
            if isinstance(holder, dict) and holder.get("verdict") in LIGHTS:
                reasons = holder.get("reasons")
                first = reasons[0] if isinstance(reasons, list) and reasons else ""
                return str(holder["verdict"]), str(first) if holder["verdict"] != "good" else ""
    if lights := [light for content in found.values() for light in _lights(content.get("judgement"))]:
        worth = worth_of(worst_first(lights))
        return worth.word, next(iter(worth.sentences()), "")
    return "done", ""


def _lights(written: Any) -> list[Light]:
    """The lights of a judgement as a command writes it; none where this is something else."""
    try:
        lights = msgspec.convert(written, list[Light])
    except msgspec.ValidationError:
        return []
    return [light for light in lights if light.level in LEVELS]


def unread_in(numbers: Mapping[str, Value]) -> str:
    """What a result says of frames that could not be read, in a sentence; "" where all were."""
    lost = sum(int(value) for name, value in numbers.items() if name.endswith(".frames_unreadable"))
    return f"{lost} frame{'s' * (lost > 1)} could not be read" if lost else ""


def _flat(content: Mapping[str, Any], before: str, depth: int = 0) -> Iterator[tuple[str, Value]]:
    for key, value in content.items():
        name = f"{before}.{key}"
        if isinstance(value, list) and len(value) <= FEW:
            value = {str(place): entry for place, entry in enumerate(value)}
        if isinstance(value, dict) and depth < DEEPEST:
            yield from _flat(value, name, depth + 1)
        elif isinstance(value, bool | int | float) or (isinstance(value, str) and len(value) <= LONGEST):
            yield name, value
