"""The stress test of `fusion explain`: recordings spoiled in one way in which users spoil them, scored strictly.

    python -m tools.trial.stress -o OUT --seed 101 --bases null --only poses centre repeat bow clutter --runs 20
    python -m tools.trial.stress -o OUT --seed 102 --bases planted --runs 26    cases that are named unspoiled
    python -m tools.trial.stress -o OUT --seed 103 --bases presets --runs 22    `fusion simulate` of the presets

Bases are the open challenges (../shared, where they are at hand), then cases of the trial's generator
(tools/trial/concealed), or what a preset's own simulation makes of walls and patches. Each is read, spoiled in one way
(tools/trial/spoiled/catalogue.py), written and given to the command `fusion explain`; nothing of the program is
imported. A base with a planted effect takes part if the unspoiled run names it. True under a spoil are the planted
effect and the spoil's own name where the catalogue has one; every other established claim, and a true one that is said
of a part of the data where it holds in all, is WRONG.

"told by": how the user learns of the spoil: a claim, `indicated`, `nuisances.pose_factor` or `.shape_rms_m` (within
a factor of two), `outliers` (these recordings and no others), `repeats`, the headline, a refusal.

`OUT/table.txt` and `OUT/table.json` hold what is printed; every look is one line of `OUT/looks.csv`. A seed that was
looked at is spent: figures that are reported come from a fresh one. The same seed makes the same spoils.
"""

import argparse
import datetime
import json
import os
import subprocess
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # products of small matrices: threads would only wait

from tools.trial.spoiled.bases import PRESETS, Base, base_of
from tools.trial.spoiled.catalogue import CONTROL, OF_FILE, SPOILS
from tools.trial.spoiled.running import Run, look, run
from tools.trial.spoiled.telling import HEAD, line, row, summary

BASES = {"null": "null", "planted": "planted", "presets": "preset"}


def main() -> int:
    """Spoil, run, score, print."""
    options = _options()
    options.output.mkdir(parents=True, exist_ok=True)
    runs: list[Run] = []
    print(HEAD, flush=True)
    try:
        for one in _runs(options):
            runs.append(one)
            print(line(one), flush=True)
            text = "\n".join([HEAD, *map(line, runs), summary(runs), ""])
            (options.output / "table.txt").write_text(text, encoding="utf-8")
            (options.output / "table.json").write_text(json.dumps(list(map(row, runs)), indent=1), encoding="utf-8")
    finally:  # a look that was broken off is a look
        _log(options, [one for one in runs if one.spoil != CONTROL])
    print(summary(runs))
    return 0


def _log(options: argparse.Namespace, spoiled: list[Run]) -> None:
    entry = {"date": datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d %H:%M"), "seed": options.seed}
    entry |= {"bases": options.bases, "spoils": " ".join(_spoils(options)), "runs": len(spoiled)}
    wrong = sum(one.score.outcome == "WRONG" for one in spoiled)
    look(options.output / "looks.csv", {**entry, "wrong": wrong, "version": _version()})


def _runs(options: argparse.Namespace) -> Iterator[Run]:
    """Base by base: the control first, then every spoil, until so many were run."""
    left, number = options.runs, 0
    with ThreadPoolExecutor(options.jobs) as pool:
        while left > 0 and number < 4 * options.runs + len(PRESETS):
            folder = options.output / f"base_{number:03d}"
            base = base_of(BASES[options.bases], number, options.seed, folder / "made")
            work = partial(_one, options, base, number)
            number += 1
            control = work(CONTROL)
            yield control
            if base.missing and control.score.outcome not in ("right", "set"):
                print(f"{base.name}: left out, it is not named unspoiled", flush=True)
                continue
            names = _spoils(options)[:left]
            left -= len(names)
            yield from pool.map(work, names)


def _one(options: argparse.Namespace, base: Base, number: int, spoil: str) -> Run:
    folder = options.output / f"base_{number:03d}" / spoil
    return run(base, number, spoil, options.seed, folder, options.keep)


def _spoils(options: argparse.Namespace) -> list[str]:
    preset = options.bases == "presets"
    return [name for name in options.only if not (preset and name in OF_FILE)]


def _version() -> str:
    """Commit of the checkout, "+" if it was changed."""
    command = ["git", "describe", "--always", "--dirty=+"]
    done = subprocess.run(command, cwd=Path(__file__).parent, capture_output=True, text=True, check=False)
    return done.stdout.strip() or "unknown"


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    all_of_them = [name for name in SPOILS if name != CONTROL]
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--bases", choices=list(BASES), default="null")
    parser.add_argument("--only", nargs="+", metavar="SPOIL", choices=all_of_them, default=all_of_them)
    parser.add_argument("--runs", type=int, default=26, help="spoiled runs; controls come on top")
    parser.add_argument("--jobs", type=int, default=1, help="runs at a time")
    parser.add_argument("--keep", action="store_true", help="keep the spoiled recordings")
    return parser.parse_args()


if __name__ == "__main__":
    raise SystemExit(main())
