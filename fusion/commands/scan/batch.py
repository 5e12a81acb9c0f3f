"""`fusion batch`: a command over many recordings, on the cores of this machine or on Dask's workers anywhere."""

import argparse
import os
import sys
from pathlib import Path

from fusion.commands.options.numbers import number, whole_number
from fusion.errors import FusionError
from fusion.files.json_values import json_text
from fusion.quantity import JOB_GIGABYTES, JOB_SECONDS, WORKERS

EXAMPLE = "fusion batch scans -o out --workers 2 -- turntable {rec} -o {out} --sensor kinect-v1"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The command's options."""
    add = parser.add_argument
    given = "folder of recordings, or a CSV file with a column rec; its other columns fill {column} in COMMAND"
    add("list", type=Path, metavar="LIST", help=given)
    # not named output: a batch goes on in its folder, and nothing in it is replaced
    out = (
        "folder for the results: a folder for each job, results.parquet, results.csv, index.html; may be an earlier one"
    )
    add("-o", "--output", dest="home", type=Path, required=True, metavar="OUT", help=out)
    add(
        "command", nargs="+", metavar="COMMAND", help="after --: a fusion command; {rec} and {out} stand for each job's"
    )
    add(
        "--workers", type=whole_number(WORKERS), metavar="N", help="jobs at a time (default: the cores of this machine)"
    )
    add("--scheduler", metavar="ADDRESS", help="of a running Dask scheduler (tcp://host:8786), whose workers are used")
    add("--time-limit", type=number(JOB_SECONDS), metavar="S", help="stop a job that takes longer [s]")
    add("--memory-limit", type=number(JOB_GIGABYTES), metavar="GB", help="stop a job that takes more memory [GB]")
    add("--overwrite", action="store_true", help="do again what was done before, and replace it")
    add("--retry", action="store_true", help="try again what was refused before")
    add("--json", action="store_true", help="print one JSON object")


def run(options: argparse.Namespace) -> int:
    """Run the batch; 0 also where jobs failed, as their rows say it, 1 where none is done."""
    from fusion.batch.job import JobLimits
    from fusion.batch.listing import items_in
    from fusion.batch.place import check_place
    from fusion.batch.run import BatchSettings, run_batch

    words = _command(options.command)
    check_place(options.home, [options.list])
    items, notes = items_in(options.list)
    settings = BatchSettings(
        workers=options.workers or os.cpu_count() or 1,
        scheduler=options.scheduler,
        limits=JobLimits(options.time_limit, options.memory_limit),
        retry=options.retry,
        again=options.overwrite,
    )
    batch = run_batch(items, words, options.home, settings)
    if not options.quiet:
        sys.stderr.writelines(f"note: {note}\n" for note in notes)
    count = {status: sum(row.status == status for row in batch.rows) for status in ("done", "refused", "stopped")}
    status = 0 if count["done"] or not batch.rows else 1
    if options.json:
        told = {"output": str(options.home), "recordings": len(batch.rows), **count, "run_now": len(batch.done)}
        print(json_text(told))
        return status
    for row in batch.rows:
        if row.status != "done":
            print(f"{row.status:<9} {row.recording}: {row.reason}")
    words = [f"{number} {status}" for status, number in count.items() if number]
    print(f"{len(batch.rows)} recordings: {', '.join(words)}; {len(batch.done)} in this run")
    print(f"index     {options.home / 'index.html'}")
    return status


def _command(given: list[str]) -> list[str]:
    """The words after `fusion`. Raises FusionError where they name no command."""
    from fusion.commands.catalogue import COMMANDS

    words = given[1:] if given[:1] == ["fusion"] else given
    able = [name for name in COMMANDS if name not in ("batch", "completion", "demo")]
    if not words or words[0] not in able:
        raise FusionError("there is no such command", "COMMAND", words[0] if words else "nothing", ", ".join(able))
    return words
