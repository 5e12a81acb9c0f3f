"""Figures: what a trial shows, against what it should, each share with its exact binomial interval."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from tools.trial.gain import share
from tools.trial.scoring import interval, stratum

Result = dict[str, Any]

WITHIN = 1.645  # standard deviations: a 90 % interval
RIGHT = ("right", "set", "quiet")
WRONG = ("wrong", "false claim")
ALIKE_ENOUGH = 0.8  # F1 of the variables of an unknown effect
SOLID = 5.0  # sigma of the oracle


def figures(results: Sequence[Result]) -> list[dict[str, Any]]:
    """One row per figure: `measure`, `hits`, `of`, `value`, `low`, `high`, `goal`."""
    nulls = [r for r in results if r["label"]["nothing_missing"] and _outcome(r) != "failed"]
    solid = [r for r in results if _solid(r)]
    named = [r for r in solid if r["label"]["family"] not in ("unknown", "left out", "confusable", "power")]
    unknown, without = ([r for r in solid if r["label"]["family"] == family] for family in ("unknown", "left out"))
    rows = [
        _share("established claims on nulls", nulls, lambda r: _outcome(r) == "false claim", "at most 0.02"),
        _share("right name or right group, oracle 5 sigma", named, lambda r: _outcome(r) in RIGHT, "at least 0.90"),
        _share("wrong name, oracle 5 sigma", named, lambda r: _outcome(r) == "wrong", "at most 0.03"),
        _share("a further name that is wrong", named, lambda r: bool(r["score"]["extra"]), ""),
        _mixtures(named),
        _share("bounds of a partial effect by the right variable", _partial(named), lambda r: r["score"]["region"], ""),
        coverage("90 % intervals that hold the true parameter", results),
        *_gains(solid),
        _share("unknown, with the right variables", unknown, _found_out, "at least 0.80"),
        _share("unknown, misnamed", unknown, lambda r: _outcome(r) == "wrong", "at most 0.05"),
        _share("left out of the catalogue, called unknown", without, lambda r: _outcome(r) == "right", ""),
        _share("left out, unknown with the right variables", without, _found_out, "at least 0.80"),
        _share("left out, misnamed", without, lambda r: _outcome(r) == "wrong", "at most 0.05"),
        *_confused(results),
        _share("no verdict at all", results, lambda r: _outcome(r) == "failed", "none"),
        _seconds(results),
    ]
    return [row for row in rows if row["of"]]


def coverage(measure: str, results: Sequence[Result]) -> dict[str, Any]:
    errors = [error for r in results for error in r["score"]["errors"]]
    inside = sum(abs(error) < WITHIN for error in errors)
    return _row(measure, inside, len(errors), "0.85 to 0.95")


def table(results: Sequence[Result]) -> str:
    """The figures, families by what the oracle could do, parameters by family, methods, powers, failures; as text."""
    parts = ["\n".join(_text(row) for row in figures(results)), _families(results)]
    by_family = {family: [r for r in results if r["label"]["family"] == family] for family in _names(results)}
    covered = [coverage(f"  {family}", cases) for family, cases in by_family.items()]
    parts.append("90 % intervals of parameters, by family\n" + "\n".join(_text(row) for row in covered if row["of"]))
    parts += [_methods(results), _powers(results), _failures(by_family)]
    return "\n\n".join(part for part in parts if part)


def _solid(result: Result) -> bool:
    return not result["label"]["nothing_missing"] and stratum(result["label"]) == "possible"


def _outcome(result: Result) -> str:
    return str(result["score"]["outcome"])


def _row(measure: str, hits: int, of: int, goal: str) -> dict[str, Any]:
    low, high = interval(hits, of)
    value = hits / of if of else None
    return {"measure": measure, "hits": hits, "of": of, "value": value, "low": low, "high": high, "goal": goal}


def _share(measure: str, results: Sequence[Result], hit: Callable[[Result], Any], goal: str) -> dict[str, Any]:
    return _row(measure, sum(bool(hit(r)) for r in results), len(results), goal)


def _partial(results: Sequence[Result]) -> list[Result]:
    return [r for r in results if r["score"]["region"] is not None and _outcome(r) in RIGHT]


def _mixtures(results: Sequence[Result]) -> dict[str, Any]:
    mixed = [r for r in results if r["score"]["missing"] > 1]
    hits, of = (sum(r["score"][key] for r in mixed) for key in ("recalled", "missing"))
    return _row("effects of mixtures that are named", hits, of, "")


def _found_out(result: Result) -> bool:
    return _outcome(result) == "right" and (result["score"]["variables"] or 0.0) >= ALIKE_ENOUGH


def _gains(results: Sequence[Result]) -> list[dict[str, Any]]:
    out = []
    for name, goal in (("held out", "at least 0.90"), ("extrapolation", "at least 0.80")):
        shares = [share(r["gain"][name]) for r in results if name in r.get("gain", {})]
        values = np.array([value for value in shares if value is not None])
        if len(values):
            low, high = np.quantile(values, [0.1, 0.9])
            row = {"measure": f"gain against the oracle's, {name}: median, deciles", "hits": None, "of": len(values)}
            out.append({**row, "value": float(np.median(values)), "low": float(low), "high": float(high), "goal": goal})
    return out


def _confused(results: Sequence[Result]) -> list[dict[str, Any]]:
    """Of cases that two names explain alike."""
    alike = [r for r in results if r["label"]["family"] == "confusable" and r["label"]["equivalent"] and _solid(r)]
    told = [r for r in alike if "solved" in r]
    return [
        _share("look-alikes, said to be so", alike, lambda r: _outcome(r) == "set", "at least 0.90"),
        _share("look-alikes, solved by the proposed recording", told, lambda r: r["solved"], "at least 0.80"),
    ]


def _seconds(results: Sequence[Result]) -> dict[str, Any]:
    seconds = sorted(r["seconds"] for r in results) or [0.0]
    row = {"measure": "seconds of a case: median, least, most", "hits": None, "of": len(results)}
    return {**row, "value": float(np.median(seconds)), "low": seconds[0], "high": seconds[-1], "goal": "under 60"}


def _text(row: dict[str, Any]) -> str:
    if not row["of"]:
        return ""
    count = f"{row['hits']} of {row['of']}" if row["hits"] is not None else f"{row['of']} cases"
    numbers = f"{row['value']:6.2f} [{row['low']:.2f}, {row['high']:.2f}]"
    return f"{row['measure']:<62}{count:>12}  {numbers:<22}{row['goal']}".rstrip()


def _names(results: Sequence[Result]) -> list[str]:
    return list(dict.fromkeys(r["label"]["family"] for r in results))


def _families(results: Sequence[Result]) -> str:
    """Families against outcomes, by what the oracle could do."""
    rows: dict[tuple[str, str], list[Result]] = {}
    for result in results:
        rows.setdefault((result["label"]["family"], stratum(result["label"])), []).append(result)
    heads = ("n", "right", "set", "unknown", "silent", "wrong", "extra", "points")
    out = [f"{'family':<16}{'oracle':<12}" + "".join(f"{h:>8}" for h in heads) + "  right or quiet, 95 %"]
    for (family, level), cases in rows.items():
        count = {name: sum(_outcome(c) == name for c in cases) for name in OUTCOMES}
        good, bad = sum(count[name] for name in RIGHT), sum(count[name] for name in WRONG)
        extra, points = sum(bool(c["score"]["extra"]) for c in cases), sum(c["score"]["points"] for c in cases)
        numbers = [len(cases), count["right"] + count["quiet"], count["set"], count["unknown"]]
        numbers += [count["silent"] + count["failed"], bad, extra]
        low, high = interval(good, len(cases))
        line = f"{family:<16}{level:<12}" + "".join(f"{x:>8}" for x in numbers) + f"{points / len(cases):>8.2f}"
        out.append(f"{line}  {good / len(cases):.2f} [{low:.2f}, {high:.2f}]")
    return "\n".join(out)


def _methods(results: Sequence[Result]) -> str:
    """The engine and plainer methods: claims on nulls; right and wrong names where the oracle has five sigma."""
    compared = [r for r in results if r.get("others")]
    if not compared:
        return ""
    names = list(compared[0]["others"])
    nulls = [r for r in compared if r["label"]["nothing_missing"]]
    solid = [r for r in compared if _solid(r) and r["label"]["family"] != "power"]
    out = [f"{'method':<18}{'claims on nulls':>28}{'right name or group':>30}{'wrong name':>30}"]
    for name in ("engine", *names):
        words = [_brief(nulls, name, WRONG), _brief(solid, name, RIGHT), _brief(solid, name, ("wrong",))]
        out.append(f"{name:<18}{words[0]:>28}{words[1]:>30}{words[2]:>30}")
    return "\n".join(out)


def _brief(results: Sequence[Result], method: str, wanted: Sequence[str]) -> str:
    said = [r["score"] if method == "engine" else r["others"][method] for r in results]
    hits = sum(one["outcome"] in wanted for one in said)
    low, high = interval(hits, len(said))
    return f"{hits} of {len(said)} [{low:.2f}, {high:.2f}]" if said else "-"


def _powers(results: Sequence[Result]) -> str:
    """Share that is named, by size over the noise of a frame."""
    cases = [r for r in results if r["label"].get("ratio")]
    rows = []
    for key in sorted({(r["label"]["notes"], r["label"]["ratio"]) for r in cases}):
        own = [r for r in cases if (r["label"]["notes"], r["label"]["ratio"]) == key]
        z = float(np.median([r["label"]["z_o"] for r in own]))
        rows.append(_share(f"  {key[0]} at {key[1]} sigma (oracle {z:.0f})", own, lambda r: _outcome(r) in RIGHT, ""))
    return "named, by size over the noise of a single frame\n" + "\n".join(_text(row) for row in rows) if rows else ""


def _failures(families: dict[str, list[Result]]) -> str:
    out = []
    for family, cases in families.items():
        failed = [r for r in cases if _outcome(r) in (*WRONG, "failed") or (_solid(r) and _outcome(r) not in RIGHT)]
        if failed:
            words = (f"{r['case']} ({_outcome(r)}: {r['score']['claimed'] or 'nothing'})" for r in failed)
            out.append(f"  {family}: {', '.join(words)}")
    return "failures by family\n" + "\n".join(out) if out else ""


OUTCOMES = ("right", "set", "silent", "unknown", "wrong", "false claim", "quiet", "failed")
