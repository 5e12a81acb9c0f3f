"""Whether tests notice slips: one operator or number of geometry, sensor and turntable is changed at a time.

Changes are made in a copy of the committed files, a random sample of all that Cosmic Ray knows of. A survivor is a
change after which the tests named here still pass: a place that no test looks at, or a change that changes nothing.
Cosmic Ray is no part of the project's environment: `pip install --target FOLDER cosmic-ray`.

python -m tools.endurance.mutants --cosmic-ray FOLDER [--sample 30] [--seed 26] [--only geometry]
"""

import argparse
import json
import os
import random
import sqlite3
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

PROJECT = Path(__file__).resolve().parents[2]
SECONDS = 120  # for the tests of one change: an endless loop counts as noticed
# sources and the tests that are theirs, which take a few seconds
PARTS = {
    "geometry": (
        "pose camera lens lens_forms trajectory trajectory_error",
        "pose camera trajectory trajectory_error lens lens_forms",
    ),
    "sensor": (
        "laws/layers correction/correction correction/summary weights/rating where correction/estimate",
        "layers correction rating placing where estimated_view",
    ),
    "turntable": (
        "circle steps wobble axis jumps guess/labels table/foot all_views/log",
        "circle steps wobble axis jumps labels foot log",
    ),
}


def main() -> None:
    """Count and list the survivors of each part."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cosmic-ray", type=Path, required=True, metavar="FOLDER", help="where it is installed")
    parser.add_argument("--sample", type=int, default=30, help="changes of each part")
    parser.add_argument("--seed", type=int, default=26)
    parser.add_argument("--only", choices=PARTS, nargs="+", default=list(PARTS))
    options = parser.parse_args()
    noticed = tried = 0
    with TemporaryDirectory() as place:
        copy = Path(place)
        archive = subprocess.run(["git", "archive", "HEAD"], cwd=PROJECT, check=True, capture_output=True).stdout
        subprocess.run(["tar", "x"], cwd=copy, input=archive, check=True)
        for part in options.only:
            survivors, count = _survivors(copy, part, options.cosmic_ray, options.sample, options.seed)
            print(f"{part}: {count - len(survivors)} of {count} noticed", *survivors, sep="\n    ", flush=True)
            noticed, tried = noticed + count - len(survivors), tried + count
    print(f"all: {noticed} of {tried} noticed, {noticed / tried:.0%}")


def _survivors(copy: Path, part: str, installed: Path, sample: int, seed: int) -> tuple[list[str], int]:
    """The changes that no test noticed, in words, and how many were made."""
    sources, tests = (names.split() for names in PARTS[part])
    paths = " ".join(f"tests/{part}/test_{name}.py" for name in tests)
    command = f"{sys.executable} -m pytest -n 0 -q -x -p no:cacheprovider -m 'not slow and not real' {paths}"
    table = {
        "module-path": [f"fusion/{part}/{name}.py" for name in sources],
        "timeout": float(SECONDS),
        "excluded-modules": [],
        "test-command": command,
    }
    lines = [f"{name} = {json.dumps(value)}" for name, value in table.items()]
    (copy / "mutants.toml").write_text(
        "\n".join(["[cosmic-ray]", *lines, '[cosmic-ray.distributor]\nname = "local"\n'])
    )
    base = copy / f"{part}.sqlite"
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(copy), str(installed.resolve())])}

    def run(*arguments: str) -> str:
        given = [sys.executable, "-m", "cosmic_ray.cli", *arguments]
        return subprocess.run(given, cwd=copy, env=environment, check=True, capture_output=True, text=True).stdout

    run("init", "mutants.toml", base.name)
    _keep(base, sample, seed)
    run("exec", "mutants.toml", base.name)
    return _told([json.loads(line) for line in run("dump", base.name).splitlines()])


def _keep(base: Path, sample: int, seed: int) -> None:
    """A random sample of the changes stays."""
    with sqlite3.connect(base) as session:
        jobs = sorted(row[0] for row in session.execute("select job_id from work_items"))
        left_out = set(jobs) - set(random.Random(seed).sample(jobs, min(sample, len(jobs))))
        for table in ("mutation_specs", "work_items"):
            session.executemany(f"delete from {table} where job_id = ?", [(job,) for job in left_out])


def _told(rows: Sequence[tuple[dict, dict]]) -> tuple[list[str], int]:
    survivors = []
    for item, outcome in rows:
        change = item["mutations"][0]
        if outcome["test_outcome"] == "survived":
            name = change["operator_name"].removeprefix("core/")
            survivors.append(f"{change['module_path']}:{change['start_pos'][0]}:{change['start_pos'][1]} {name}")
    return sorted(survivors), len(rows)


if __name__ == "__main__":
    main()
