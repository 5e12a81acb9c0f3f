"""The trial of `fusion explain` on concealed effects: makes cases, seals their labels, runs the engine, scores.

python -m tools.trial.run --cases 200 --seed 1 -o OUT                       all families in turn
python -m tools.trial.run --cases 200 --families null "hard null" -o OUT    nulls only
python -m tools.trial.run --cases 120 --families power -o OUT               how small an effect is found
python -m tools.trial.run --cases 40 --families "left out" -o OUT           effects that the engine does not have
python -m tools.trial.run --open ../shared/challenges -o OUT                the open challenges

The generator (tools/trial/concealed) shares no formula and no code with the package: rays, raw samples and disparities
of its own. The engine runs as a separate process on a folder that holds no label; labels stay in memory until it has
ended, and their hashes are written before it starts. The same seed makes the same cases. A trial that was stopped goes
on where it was; with --workers or --scheduler its cases are jobs of a batch. docs/explain_trial.md tells of families,
strata and figures.
"""

import argparse
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from tools.trial.case import Order, opened, tried
from tools.trial.concealed.laws.left_out import LEFT_OUT
from tools.trial.concealed.plan import FAMILIES, POWER
from tools.trial.figures import figures, table
from tools.trial.on_batch import tried_on_workers
from tools.trial.scoring import stratum

ALL = [*FAMILIES, POWER, LEFT_OUT]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", type=int, default=30, help="how many, in turn over the families")
    parser.add_argument("--families", nargs="+", choices=ALL, default=list(FAMILIES))
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--open", type=Path, help="folder with cases/ and answers/ to run instead")
    parser.add_argument("--shared", type=Path, help="folder with data/, for real recordings")
    parser.add_argument("--baselines", action="store_true", help="let plainer methods answer too")
    parser.add_argument("--no-gain", action="store_true", help="skip the recordings that the engine is not given")
    parser.add_argument("--whole", action="store_true", help="run the command with its report, not the verdict alone")
    parser.add_argument("--only", type=int, nargs="+", metavar="I", help="these cases of the series alone")
    parser.add_argument("--keep", action="store_true", help="keep the recordings")
    parser.add_argument("--workers", type=int, default=1, help="cases at a time; more than one by `fusion batch`")
    parser.add_argument("--scheduler", metavar="ADDRESS", help="Dask workers that run already, on any machines")
    parser.add_argument("-o", "--output", type=Path, required=True)
    options = parser.parse_args()
    options.output.mkdir(parents=True, exist_ok=True)
    results = []
    for result in _results(options):
        if "absent" in result:
            print(result["absent"], flush=True)
            continue
        results.append(result)
        print(_line(result), flush=True)
        _write(options.output, results)
    print("\n" + table(results))


def _results(options: argparse.Namespace) -> Iterator[dict[str, Any]]:
    """Results in the order of the series."""
    if options.open:
        yield from opened(options.open, options.output, options.whole)
        return
    orders = []
    for i in options.only or range(options.cases):
        family = options.families[i % len(options.families)]
        seed = [options.seed, i, ALL.index(family)]
        order = Order(f"case_{i:04d}", family, tuple(seed), options.output, options.shared)
        orders.append(order.having(options.whole, options.keep, not options.no_gain, options.baselines))
    if options.workers == 1 and options.scheduler is None:
        yield from map(tried, orders)
        return
    yield from tried_on_workers(orders, options.output, options.workers, options.scheduler)


def _line(result: dict[str, Any]) -> str:
    label, points = result["label"], result["score"]
    truth = "+".join(t["effect"] + ("*" if t.get("form_shifted") else "") for t in label["missing"]) or "nothing"
    said = "; ".join(_said(claim) for claim in result["claims"]) or result["complaint"] or "nothing"
    z = "" if label["z_o"] is None else f" z_o {label['z_o']:.0f}"
    alike = f" ~ {','.join(label['equivalent'])}" if label["equivalent"] else ""
    where = f"{label['principle'][:4]} {label['deck']}, {label['notes']}"
    head = f"{result['case']} {label['family']} ({where}) {stratum(label)}{z}: {truth}{alike}"
    more = f" {result['asked']}: {'solved' if result['solved'] else 'not solved'}" if "solved" in result else ""
    return f"{head} -> {said} [{points['outcome']} {points['points']:+.1f}]{more} {result['seconds']:.0f} s"


def _said(claim: dict[str, Any]) -> str:
    alike = claim.get("indistinguishable_from") or []
    variables = f"({','.join(claim['where']['variables'])})" if claim["effect"] == "unknown" else ""
    return claim["effect"] + variables + (f" or {', '.join(alike)}" if alike else "")


def _write(folder: Path, results: list[dict[str, Any]]) -> None:
    content = {"format": "fusion-trial/1", "figures": figures(results), "table": table(results), "results": results}
    (folder / "trial.json").write_text(json.dumps(content, indent=1), encoding="utf-8")


if __name__ == "__main__":
    main()
