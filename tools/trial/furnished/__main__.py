"""Furnished rooms with concealed effects: makes cases, runs `fusion explain` on them, scores.

python -m tools.trial.furnished -o OUT --seed 1 --cases 30           makes, explains and scores in turn
python -m tools.trial.furnished -o OUT --seed 1 --cases 30 --made    makes only
python -m tools.trial.furnished.check OUT                            do the files hold what the answers tell?

Rooms, stairs, crates, sheets, boards, columns and corridors are seen from tripods, arms, rails and by hand, with
cameras of time of flight, zones of it, stereo and structured light; one or two effects are concealed, or nothing.
Whoever wrote the generator had read the contract of the files, the page of physics and the papers, and never the
engine; it imports nothing of the package. Cases are in OUT/cases, answers in OUT/answers, verdicts in OUT/explained.
The same seed and number of cases make the same cases; what was made and explained before is kept.
docs/explain_trial.md tells more.
"""

import argparse
from pathlib import Path

from tools.trial.furnished.making import made, name_of
from tools.trial.furnished.plan import Spec, plan
from tools.trial.furnished.running import explained
from tools.trial.furnished.scoring import CaseRow, line, scored, table


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--cases", type=int, required=True, help="how many; another number makes other cases")
    parser.add_argument("--only", type=int, nargs="+", metavar="I", help="these cases of the series alone")
    parser.add_argument("--made", action="store_true", help="make the cases, and explain none")
    parser.add_argument("-o", "--output", type=Path, required=True)
    options = parser.parse_args()
    specs = plan(options.seed, options.cases)
    rows = []
    for case in options.only or range(options.cases):
        row = _row(options, case, specs[case])
        if row is not None:
            rows.append(row)
            print(line(row), flush=True)
    if rows:
        print("\n" + table(rows))


def _row(options: argparse.Namespace, case: int, spec: Spec) -> CaseRow | None:
    """A case that is made and explained, None where it could not be made or is not to be explained."""
    name, out = name_of(case), options.output
    one = made(options.seed, case, spec, out)
    if one.answer is None:
        print(f"{name} could not be made: {one.why}", flush=True)
        return None
    if options.made:
        print(f"{name} made", flush=True)
        return None
    told = explained(out / "cases" / name, out / "explained" / name)
    said = scored(told.verdict, one.answer, told.complaint)
    return CaseRow(name, one.answer["kind"], one.answer["truth"], said, told.seconds)


if __name__ == "__main__":
    main()
