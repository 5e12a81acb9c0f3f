"""Recordings that `fusion explain` once explained wrongly, each row anew: what is said of them today?

    python -m tools.trial.rows -o OUT --seed 301                 each row, small images
    python -m tools.trial.rows -o OUT --seed 302 --variants 4    and three relatives of each
    python -m tools.trial.rows -o OUT --seed 301 --large         with those of 640 x 480, minutes each

Rows (tools/trial/once_wrong/rows.py) are made by the stress test's spoils, by the trial's generator and by `fusion
simulate`, and explained by the command in a process of its own. "right": what is true is said, and nothing else is
established; "told": it is said in the headline and not by a name; "silent": nothing is established that is false, and
the truth is not said; "WRONG": something false is. `OUT/table.txt` holds what is printed. A seed that was looked at is
spent, as everywhere.
"""

import argparse
import os
import shutil
from pathlib import Path

import numpy as np

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # products of small matrices: threads would only wait

from tools.trial.once_wrong.row import verdict_on
from tools.trial.once_wrong.rows import ROWS
from tools.trial.spoiled.running import Run, answered

HEAD = f"{'row':<44} {'once':<38} {'today':<7} {'chi2':>5} {'s':>4}  established claims | headline"


def main() -> int:
    """Make, explain, judge, print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--variants", type=int, default=1, help="of each row; the first is the row itself")
    parser.add_argument("--only", nargs="+", type=int, default=range(len(ROWS)), metavar="N", help="numbers of rows")
    parser.add_argument("--large", action="store_true", help="rows of 640 x 480 too")
    parser.add_argument("--keep", action="store_true", help="keep the recordings")
    options = parser.parse_args()
    options.output.mkdir(parents=True, exist_ok=True)
    lines, counts = [HEAD], dict.fromkeys(("right", "told", "silent", "WRONG"), 0)
    print(HEAD, flush=True)
    for number in options.only:
        if ROWS[number].large and not options.large:
            continue
        for variant in range(options.variants):
            run = _run(number, variant, options)
            counts[verdict_on(run)] += 1
            lines.append(_line(number, variant, run))
            print(lines[-1], flush=True)
            (options.output / "table.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")
    print(", ".join(f"{name} {count}" for name, count in counts.items()))
    return 0


def _run(number: int, variant: int, options: argparse.Namespace) -> Run:
    folder = options.output / f"row_{number:02d}_{variant}"
    rng = np.random.default_rng([options.seed, number, variant])
    shutil.rmtree(folder, ignore_errors=True)
    base, spoiled = ROWS[number].make(variant, rng, folder / "made")
    run = answered(base, spoiled, number, ROWS[number].name, folder, options.keep)
    if not options.keep:
        shutil.rmtree(folder / "made")
    return run


def _line(number: int, variant: int, run: Run) -> str:
    row, chi2 = ROWS[number], "" if run.chi2 is None else f"{run.chi2:.2f}"
    name = f"{number} {row.name}" + (f" ({variant})" if variant else "")
    said = ", ".join(run.score.claims) if run.score.outcome not in ("failed", "refused") else ""
    return (
        f"{name[:44]:<44} {row.was[:38]:<38} {verdict_on(run):<7} {chi2:>5} {run.seconds:4.0f}  {said} | {run.headline}"
    )


if __name__ == "__main__":
    raise SystemExit(main())
