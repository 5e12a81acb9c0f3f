"""Runs as lines of a table, and all of them in one figure."""

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from tools.trial.scoring import interval
from tools.trial.spoiled.catalogue import CONTROL
from tools.trial.spoiled.running import Run

HEAD = f"{'base':<26} {'spoil':<9} {'how':<38} {'outcome':<8} {'told by':<22} {'chi2':>5} {'s':>4}  established claims"


def line(run: Run) -> str:
    """One run; a wrong claim stands between exclamation marks."""
    score = run.score
    told = "" if score.told is None else ",".join(score.how) or "-"
    chi2 = "" if run.chi2 is None else f"{run.chi2:.2f}"
    claims = score.claims if score.outcome != "failed" else ()
    shown = [f"!{claim}!" if any(wrong.startswith(claim) for wrong in score.wrong) else claim for claim in claims]
    said = ", ".join(shown) or (run.headline if score.outcome in ("failed", "refused") else "")
    return (
        f"{run.base[:26]:<26} {run.spoil:<9} {run.text[:38]:<38} {score.outcome:<8} {told:<22} {chi2:>5} "
        f"{run.seconds:4.0f}  {said}"
    )


def summary(runs: Sequence[Run]) -> str:
    """The one figure, then the same by spoil and by kind of base; controls are told apart."""
    spoiled = [run for run in runs if run.spoil != CONTROL]
    controls = [run for run in runs if run.spoil == CONTROL]
    lines = ["", f"wrong established claims: {_share(spoiled, 'WRONG')}"]
    for name, some in (("nulls", [r for r in spoiled if r.null]), ("planted", [r for r in spoiled if not r.null])):
        if some:
            right = _share(some, "right") if name == "planted" else f"told {sum(bool(r.score.told) for r in some)}"
            lines.append(
                f"  {name}: wrong {_share(some, 'WRONG')}; {'right name ' if name == 'planted' else ''}{right}"
            )
    for spoil in dict.fromkeys(run.spoil for run in spoiled):
        some = [run for run in spoiled if run.spoil == spoil]
        counts = {o: sum(r.score.outcome == o for r in some) for o in dict.fromkeys(r.score.outcome for r in some)}
        outcomes = ", ".join(f"{name} {count}" for name, count in counts.items())
        lines.append(f"  {spoil:<9} told {sum(bool(r.score.told) for r in some)} of {len(some)}; {outcomes}")
    lines.append(f"unspoiled: wrong established claims {_share(controls, 'WRONG')}")
    return "\n".join(lines)


def row(run: Run) -> dict[str, Any]:
    """For JSON."""
    return asdict(run)


def _share(runs: Sequence[Run], outcome: str) -> str:
    """n of m with its exact 95 % interval."""
    hits = sum(run.score.outcome == outcome for run in runs)
    low, high = interval(hits, len(runs))
    return f"{hits} of {len(runs)} (95 %: {100 * low:.1f} to {100 * high:.1f} %)"
