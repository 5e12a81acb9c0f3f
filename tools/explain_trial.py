"""The trial of `fusion explain` on concealed effects: makes cases, seals their labels, runs the engine, scores.

python tools/explain_trial.py --cases 60 --families null "hard null" -o OUT     nulls only
python tools/explain_trial.py --cases 200 --seed 1 -o OUT                       all families in turn
python tools/explain_trial.py --open ../shared/challenges -o OUT                the open challenges

The generator (tools/concealed) shares no formula and no code with the package: rays, raw samples and disparities of
its own. The engine runs as a separate process on a folder that holds no label; labels stay in memory until it has
ended, and their hashes are written before it starts. The same seed makes the same cases.
"""

import argparse
import json
import shutil
import tempfile
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

from trial.engine import explained
from concealed.making import make
from concealed.plan import FAMILIES
from trial.scoring import score, stratum, table
from trial.sealing import sealed


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", type=int, default=20, help="how many, in turn over the families")
    parser.add_argument("--families", nargs="+", choices=FAMILIES, default=list(FAMILIES))
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--open", type=Path, help="folder with cases/ and answers/ to run instead")
    parser.add_argument("--whole", action="store_true", help="run the command with its report, not the verdict alone")
    parser.add_argument("--only", type=int, nargs="+", metavar="I", help="these cases of the series alone")
    parser.add_argument("--keep", action="store_true", help="keep the recordings")
    parser.add_argument("-o", "--output", type=Path, required=True)
    options = parser.parse_args()
    options.output.mkdir(parents=True, exist_ok=True)
    results = []
    for result in _opened(options) if options.open else _drawn(options):
        results.append(result)
        print(_line(result), flush=True)
        _write(options.output, results)
    print("\n" + table(results))


def _drawn(options: argparse.Namespace) -> Iterator[dict[str, Any]]:
    """Cases made for this trial, one at a time."""
    for i in options.only or range(options.cases):
        family = options.families[i % len(options.families)]
        name = f"case_{i:04d}"
        with tempfile.TemporaryDirectory() as scratch:
            case = Path(scratch) / name
            label = make(family, [options.seed, i, FAMILIES.index(family)], case)
            seal, salt = sealed(label)
            with (options.output / "seals.txt").open("a", encoding="utf-8") as file:
                file.write(f"{name} {seal}\n")
            if options.keep:
                shutil.copytree(case, options.output / "cases" / name, dirs_exist_ok=True)
            verdict, *run = explained(case, options.output / name, options.whole)
            yield _result(name, verdict, {"label": label, "seal": seal, "salt": salt}, run)


def _opened(options: argparse.Namespace) -> Iterator[dict[str, Any]]:
    """The open challenges; an answer is read after the engine has ended."""
    for case in sorted((options.open / "cases").iterdir()):
        verdict, *run = explained(case, options.output / case.name, options.whole)
        answer = json.loads((options.open / "answers" / f"{case.name}.json").read_text(encoding="utf-8"))
        yield _result(case.name, verdict, {"label": answer}, run)


def _result(name: str, verdict: dict[str, Any] | None, extra: dict[str, Any], run: list[Any]) -> dict[str, Any]:
    claims = [] if verdict is None else verdict["missing"]
    about = {"case": name, "seconds": round(run[0], 1), "complaint": run[1], "claims": claims, **extra}
    return {**about, "score": asdict(score(verdict, extra["label"]))}


def _line(result: dict[str, Any]) -> str:
    label, points = result["label"], result["score"]
    truth = "+".join(t["effect"] + ("*" if t.get("form_shifted") else "") for t in label["missing"]) or "nothing"
    said = "; ".join(_said(claim) for claim in result["claims"]) or result["complaint"] or "nothing"
    z = "" if label["z_o"] is None else f" z_o {label['z_o']:.0f}"
    alike = f" ~ {','.join(label['equivalent'])}" if label["equivalent"] else ""
    where = f"{label['principle'][:4]} {label['deck']}, {label['notes']}"
    head = f"{result['case']} {label['family']} ({where}) {stratum(label)}{z}: {truth}{alike}"
    return f"{head} -> {said} [{points['outcome']} {points['points']:+.1f}] {result['seconds']:.0f} s"


def _said(claim: dict[str, Any]) -> str:
    alike = claim.get("indistinguishable_from") or []
    variables = f"({','.join(claim['where']['variables'])})" if claim["effect"] == "unknown" else ""
    return claim["effect"] + variables + (f" or {', '.join(alike)}" if alike else "")


def _write(folder: Path, results: list[dict[str, Any]]) -> None:
    failures = [r["case"] for r in results if r["score"]["outcome"] in ("wrong", "false claim", "failed")]
    content = {"format": "fusion-trial/1", "table": table(results), "failures": failures, "results": results}
    (folder / "trial.json").write_text(json.dumps(content, indent=1), encoding="utf-8")


if __name__ == "__main__":
    main()
