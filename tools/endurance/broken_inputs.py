"""Broken inputs against the program: a table of all that breaks its word.

python -m tools.endurance.broken_inputs                      the quick part
python -m tools.endurance.broken_inputs --each               each input, with one command or two
python -m tools.endurance.broken_inputs --all --jobs 4       every input with every command
python -m tools.endurance.broken_inputs --match 'mesh: .*pcd' --keep out/broken
python -m tools.endurance.broken_inputs --all -o table.md    the table as Markdown

Exit status 0 where every case keeps the rule of tests/broken/judge.py, 1 otherwise.
"""

import argparse
import multiprocessing
import os
import re
import shlex
import sys
import tempfile
import time
from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests"))

from broken import bases, corpus, judge
from broken.runner import Server, forget, keep_kernels, run


@dataclass(frozen=True)
class Row:
    """What became of one case."""

    number: int
    name: str
    wrong: list[str]
    words: list[str]
    seconds: float
    cpu: float
    peak: int
    said: str


_SERVER: list[Server] = []  # of this worker process


def main() -> int:
    """Make, run, judge, print."""
    options = _options()
    with tempfile.TemporaryDirectory(prefix="broken-") as made:
        place = options.keep or Path(made)
        bases.prepare(place.resolve() / "bases")
        keep_kernels(Path(made))  # else each case that scans compiles them anew
        chosen = _chosen(options)
        start = time.monotonic()
        rows = []
        jobs = [(n, str(place.resolve()), options.keep is not None, options.themes) for n in chosen]
        with multiprocessing.get_context("spawn").Pool(options.jobs) as pool:
            for done, row in enumerate(pool.imap_unordered(_one, jobs), 1):
                rows.append(row)
                if done % 100 == 0:
                    print(f"{done} of {len(jobs)}, {time.monotonic() - start:.0f} s", file=sys.stderr, flush=True)
                    _write(options.output, table(rows, time.monotonic() - start))
    rows.sort(key=lambda row: row.number)
    text = table(rows, time.monotonic() - start)
    print(text)
    _write(options.output, text)
    return int(any(row.wrong for row in rows))


def _write(path: Path | None, text: str) -> None:
    if path:
        path.write_text(text + "\n", encoding="utf-8")


def _chosen(options: argparse.Namespace) -> list[int]:
    """Numbers of the cases to run, in the list of all."""
    cases = list(corpus.cases(options.themes))
    if options.each:
        names = {case.name for case in corpus.spread(cases)}
    elif options.match:
        names = {case.name for case in cases if options.match.search(case.name)}
    else:
        names = {case.name for case in cases if case.quick or options.all}
    return [n for n, case in enumerate(cases) if case.name in names][options.skip :: options.every]


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--all", action="store_true", help="every case, not only the quick part")
    parser.add_argument("--each", action="store_true", help="each input once or twice: what `make slow` runs")
    parser.add_argument("--match", type=re.compile, help="cases whose name holds this regular expression")
    parser.add_argument("--themes", nargs="+", default=corpus.THEMES, choices=corpus.THEMES)
    parser.add_argument("--every", type=int, default=1, help="only each n-th of them")
    parser.add_argument("--skip", type=int, default=0, help="leave out the first")
    parser.add_argument("--jobs", type=int, default=max(1, (os.cpu_count() or 2) // 2))
    parser.add_argument("--keep", type=Path, help="keep the inputs and results in this folder")
    parser.add_argument("-o", "--output", type=Path, help="write the table here too, as it grows")
    return parser.parse_args()


def _one(job: tuple[int, str, bool, tuple[str, ...]]) -> Row:
    """In a worker: run one case by its number; the list of cases is made once."""
    number, place, keep, themes = job
    if not _SERVER:
        os.environ["FUSION_BROKEN_BASES"] = str(Path(place) / "bases")
        _SERVER.append(Server())
        _CASES.extend(corpus.cases(themes))
    case = _CASES[number]
    folder = Path(place) / f"{number:05d}"
    try:
        ran = run(case, _SERVER[0], folder)
        wrong = judge.judged(case, ran)
        said = judge.said(ran)[-1:]
        return Row(number, case.name, wrong, ran.words, ran.seconds, ran.cpu, ran.peak, said[0] if said else "")
    except (AssertionError, OSError, ValueError) as error:  # of the corpus itself: the others go on
        return Row(number, case.name, [f"the corpus failed: {error!r}"], [], 0.0, 0.0, 0, "")
    finally:
        if not keep:
            forget(folder)


_CASES: list = []


def table(rows: list[Row], seconds: float) -> str:
    """Violations by kind, the kind with most first; of each input the shortest command, and which do the same."""
    kinds: dict[str, dict[str, list[tuple[Row, str]]]] = defaultdict(lambda: defaultdict(list))
    for row in rows:
        for wrong in row.wrong:
            kinds[wrong.split(":")[0]][row.name.rsplit(": ", 1)[0]].append((row, wrong))
    bad = sum(bool(row.wrong) for row in rows)
    longest, largest = max((r.seconds for r in rows), default=0), max((r.peak for r in rows), default=0)
    work = sum(row.cpu for row in rows)
    told = [f"{len(rows)} cases, {bad} break the rule, {seconds:.0f} s, {work:.0f} s of work"]
    told += [f"the longest {longest:.1f} s, the largest {largest / 1e9:.2f} GB", ""]
    for kind, inputs in sorted(kinds.items(), key=lambda item: -len(item[1])):
        count = sum(map(len, inputs.values()))
        told += [
            f"## {kind}: {count} cases of {len(inputs)} inputs",
            "",
            "| input | shortest command | what | said | more |",
            "|---|---|---|---|---|",
        ]
        for name, found in inputs.items():
            row, wrong = min(found, key=lambda pair: len(pair[0].words))
            others = " ".join(other.name.rsplit(": ", 1)[1] for other, _ in found if other is not row)
            cells = [name, shlex.join(["fusion", *row.words]), wrong.split(": ", 1)[-1], row.said]
            cells = [_shown(cell) for cell in cells]
            told.append("| " + " | ".join([*cells, others]) + " |")
        told.append("")
    return "\n".join(told)


def _shown(text: str) -> str:
    return ascii(text)[1:-1].replace("|", "\\|")[:200]


if __name__ == "__main__":
    raise SystemExit(main())
