"""Gain: how much better recordings are predicted that the engine was not given, against one who knows the form."""

import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tools.trial.concealed.decks import BEYOND, USUAL
from tools.trial.concealed.making import Made, oracle_for, write_recordings
from tools.trial.concealed.more import more_shots
from tools.trial.concealed.oracle import Oracle
from tools.trial.concealed.plan import Plan
from tools.trial.concealed.rays import cast
from tools.trial.concealed.shot import Shot
from tools.trial.engine import predicted

Array = NDArray[np.float64]

WORTH = 25.0  # of the oracle's own gain: below five sigma the share of it is noise
SETS = {"held out": USUAL, "extrapolation": BEYOND}
UNSUITED = ("turntable", "floor")  # decks of which no further recordings can be made


def sizes_of(made: Made) -> Array:
    """(k,) factors on the true laws that the case's own recordings tell to one who knows their form; near 1."""
    assert made.oracle is not None
    case, oracle = made.plan, made.oracle
    columns = np.column_stack([oracle.field([law], case.known) for law in _seen(case)])
    white = oracle.measured(made.depth, _clean(case, oracle))
    return np.asarray(np.linalg.lstsq(columns, white, rcond=None)[0])


def gains(made: Made, given: Path, better: Path, seed: list[int]) -> dict[str, Any]:
    """chi2 of held-out and of extrapolated recordings before, by the engine, by the oracle; {} where there are none.

    Args:
        given, better: sensor.json of the case and of the engine.
    """
    case = made.plan
    if made.oracle is None or case.setting.kind in UNSUITED or not better.is_file():
        return {}
    rng = np.random.default_rng([*seed, 99])
    further, depth = {}, {}
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        for k, (name, span) in enumerate(SETS.items()):
            further[name] = more_shots(rng, case.setting, case.shots, span)
            depth[name] = write_recordings(case, further[name], folder, rng, 10 * k)
        models = predicted(folder, [given, better], folder)
    if models is None:
        return {}
    sizes, out, start = sizes_of(made), {}, 0
    for name, shots in further.items():
        own = models[:, start : start + len(shots)]
        out[name] = _chi2(case, shots, depth[name], list(own), sizes)
        start += len(shots)
    return out


def share(chi2: dict[str, float]) -> float | None:
    """What the engine gains of what the oracle gains; None where that is too little to divide by."""
    worth = chi2["before"] - chi2["oracle"]
    return None if worth < WORTH else (chi2["before"] - chi2["engine"]) / worth


def _chi2(case: Plan, shots: list[Shot], depth: list[Array], models: list[Array], sizes: Array) -> dict[str, float]:
    oracle = oracle_for(case, shots)
    before, after = (oracle.measured(depth, list(model)) for model in models)
    known = before - np.column_stack([oracle.field([law], case.known) for law in _seen(case)]) @ sizes
    tiles = len(before)
    chi2 = {"before": float(before @ before), "engine": float(after @ after), "oracle": float(known @ known)}
    return {**chi2, "tiles": tiles}


def _seen(case: Plan) -> list[Any]:
    return [law for law in case.missing if law.channel == "bias"]


def _clean(case: Plan, oracle: Oracle) -> list[Array]:
    """(h, w) depth of each moment without what is missing, as stated: the true pose is not known to anyone."""
    out = []
    for shot, frame, _, _ in oracle.moments:
        stated = cast(shot.panels, shot.stated, shot.camera.rays()).z
        out.append(case.device.clean(shot, case.known, frame) + stated - shot.hits.z)
    return out
