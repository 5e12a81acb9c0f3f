"""One case of the trial: made, sealed, explained in another process, scored."""

import json
import shutil
import tempfile
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from tools.trial.asked import kind_asked
from tools.trial.concealed.making import Made, make, write_recordings
from tools.trial.concealed.more import asked_shots
from tools.trial.engine import explained, naively
from tools.trial.gain import gains, sizes_of
from tools.trial.scoring import POSSIBLE, score
from tools.trial.sealing import sealed

Result = dict[str, Any]

SURE = 4.0  # sigma at which the oracle says so
LOGGED = ("time", "warm rail")  # recordings with temperatures, whatever the others have
FIRST = 20  # number of the first recording that was asked for


@dataclass(frozen=True)
class Order:
    """What to try.

    Attributes:
        output: folder of the trial; `output/name` holds what the engine wrote.
        shared: folder with `data/`, None without real recordings.
        whole: run the command with its report.
        keep: keep the recordings.
        gain: predict recordings that the engine was not given.
        others: let plainer methods answer too.
        seals: file that the hash of the label is added to; `output/seals.txt` where it is not said.
    """

    name: str
    family: str
    seed: tuple[int, ...]
    output: Path
    shared: Path | None = None
    whole: bool = False
    keep: bool = False
    gain: bool = True
    others: bool = False
    seals: Path | None = None

    def having(self, whole: bool, keep: bool, gain: bool, others: bool) -> "Order":
        return replace(self, whole=whole, keep=keep, gain=gain, others=others)


def tried(order: Order) -> Result:
    """The result of one case, as it was if it was tried before; `absent` where its real recordings are not at hand."""
    file = order.output / f"{order.name}.json"
    if file.is_file():
        return dict(json.loads(file.read_text(encoding="utf-8")))
    with tempfile.TemporaryDirectory() as scratch:
        case = Path(scratch) / order.name
        made = make(order.family, list(order.seed), case, order.shared)
        if made is None:
            return {"absent": f"{order.name} {order.family}: left out, the real recordings are absent (--shared)"}
        result = _judged(order, case, made)
    file.write_text(json.dumps(result, indent=1), encoding="utf-8")
    return result


def opened(folder: Path, output: Path, whole: bool) -> Iterator[Result]:
    """The open challenges; an answer is read after the engine has ended."""
    for case in sorted((folder / "cases").iterdir()):
        verdict, *run = explained(case, output / case.name, whole)
        answer = json.loads((folder / "answers" / f"{case.name}.json").read_text(encoding="utf-8"))
        yield _result(case.name, verdict, {"label": answer}, run)


def _judged(order: Order, case: Path, made: Made) -> Result:
    seal, salt = sealed(made.label)
    with (order.seals or order.output / "seals.txt").open("a", encoding="utf-8") as file:
        file.write(f"{order.name} {seal}\n")
    if order.keep:
        shutil.copytree(case, order.output / "cases" / order.name, dirs_exist_ok=True)
    out = order.output / order.name
    verdict, *run = explained(case, out, order.whole, made.label.get("withheld", ()))
    result = _result(order.name, verdict, {"label": made.label, "seal": seal, "salt": salt}, run)
    if order.gain and verdict is not None:
        result["gain"] = gains(made, case / "sensor.json", out / "sensor.json", list(order.seed))
    if order.others:
        result["others"] = _others(case, made)
    if order.family == "confusable" and made.label["equivalent"] and verdict is not None and verdict["missing"]:
        result |= _asked(order, case, made, verdict)
    return result


def _result(name: str, verdict: Result | None, extra: Result, run: list[Any]) -> Result:
    claims = [] if verdict is None else verdict["missing"]
    about = {"case": name, "seconds": round(run[0], 1), "complaint": run[1], "claims": claims, **extra}
    return {**about, "score": asdict(score(verdict, extra["label"]))}


def _asked(order: Order, case: Path, made: Made, verdict: Result) -> Result:
    """The case again with the recordings that the answer asks for."""
    kind = kind_asked(verdict["missing"][0].get("record_next") or "")
    if kind is None:
        return {"asked": "nothing that can be made", "solved": False}
    rng = np.random.default_rng([*order.seed, 98])
    write_recordings(made.plan, asked_shots(rng, kind, made.plan.shots), case, rng, FIRST, kind in LOGGED)
    again, _, complaint = explained(case, order.output / f"{order.name}_again")
    claims = (again or {}).get("missing", [])
    truth = made.label["missing"][0]
    right = bool(claims) and claims[0]["effect"] in (truth["effect"], *truth["accept"])
    alike = set(claims[0].get("indistinguishable_from", ())) if claims else set()
    solved = right and not alike & set(made.label["equivalent"])
    return {"asked": kind, "solved": solved, "claims_again": claims, "complaint_again": complaint}


def _others(case: Path, made: Made) -> Result:
    """Scores of plainer methods, and of the oracle, which knows the form of the effect and is asked for its size."""
    said = naively(case, case.parent / "naive.json")
    out = {}
    for method, names in said.items():
        claims = [{"effect": name, "where": {"variables": []}} for name in names]
        out[method] = asdict(score({"missing": claims}, made.label))
    out["oracle"] = {"outcome": _oracle(made)}
    return out


def _oracle(made: Made) -> str:
    label = made.label
    if label["nothing_missing"]:
        return "quiet"
    if made.oracle is None or any(law.stage == "rig" for law in made.plan.missing):
        return "right" if label["z_o"] >= POSSIBLE else "silent"
    sure = np.abs(sizes_of(made)) * np.array([one["z_o"] for one in label["missing"] if one["channel"] == "bias"])
    return "right" if np.max(sure) >= SURE else "silent"
