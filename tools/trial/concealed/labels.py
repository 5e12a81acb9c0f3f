"""The label of a case: what is missing, how significant it is, and what looks like it."""

import json
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tools.trial.concealed.laws import named
from tools.trial.concealed.laws.flight import Flight
from tools.trial.concealed.laws.law import Law
from tools.trial.concealed.laws.left_out import LEFT_OUT, as_left_out
from tools.trial.concealed.oracle import Oracle
from tools.trial.concealed.plan import Plan
from tools.trial.concealed.rig import DRAWS
from tools.trial.concealed.shot import Place

Array = NDArray[np.float64]

ALIKE = 0.95
DRAWS_OF_FORM = 5  # of a law whose form has free shape parameters, to span what it can look like


def label_of(case: Plan, oracle: Oracle | None, seed: list[int]) -> dict[str, Any]:
    """All that a verdict is scored by."""
    label: dict[str, Any] = {"family": case.family, "seed": seed, "deck": case.setting.kind, "notes": case.notes}
    label |= {"principle": "itof" if case.flight else "structured_light", "nothing_missing": not case.missing}
    label |= {"missing": [], "equivalent": [], "accept_on_null": [], "ratio": case.ratio}
    label |= {"wrong_metadata": case.metadata or None, "decoy": case.decoy or None}
    if case.setting.bow_m:
        label["accept_on_null"] = ["reference_shape_error"]
    label["known_truth"] = {case.stated["name"]: case.stated} if case.stated else {}
    for law in case.missing:
        label["missing"].append(_one(case, law, oracle))
        label["equivalent"] += [name for name, cosine in label["missing"][-1]["similar"].items() if cosine > ALIKE]
    label["z_o"] = max((one["z_o"] for one in label["missing"]), default=0.0)
    return json.loads(json.dumps(as_left_out(label) if case.family == LEFT_OUT else label))


def _one(case: Plan, law: Law, oracle: Oracle | None) -> dict[str, Any]:
    one: dict[str, Any] = {"effect": law.name, "channel": law.channel, "variables": list(law.variables)}
    one |= {"region": list(law.region), "accept": list(law.accept), "form_shifted": law.shifted, "size": law.size}
    one |= {"similar": {}, "mixed": case.family == "mixture"}
    if oracle is None or law.channel != "bias":
        one["z_o"] = spread_significance(case, law)
    else:
        white = change_of(case, oracle, law)
        one["z_o"] = float(np.linalg.norm(white))
        if case.family != "mixture":
            one["similar"] = _similar(case, oracle, law, white)
    if law.parameter is not None and law.mask is None:
        one["parameters"] = {law.parameter[0]: {"value": law.parameter[1] * law.size}}
    return one


def change_of(case: Plan, oracle: Oracle, law: Law) -> Array:
    """(n,) whitened change of the tiles by a law."""
    if case.table is None or law.stage != "rig":
        return oracle.field([law], case.known)
    return oracle.moved(case.shots)


def _similar(case: Plan, oracle: Oracle, law: Law, white: Array) -> dict[str, float]:
    """Share of the true change that another named law can make, of those that make most of it."""
    out = {name: _reach(columns, white) for name, columns in _others(case, oracle, law).items()}
    return {k: v for k, v in sorted(out.items(), key=lambda kv: -kv[1]) if v > 0.7}


def _others(case: Plan, oracle: Oracle, law: Law) -> dict[str, list[Array]]:
    rng = np.random.default_rng(0)
    out: dict[str, list[Array]] = {}
    if case.table is not None:
        for name in DRAWS:
            if name != law.name:
                out[name] = [oracle.moved(shots) for shots in case.table.looks_like(name)]
        return out
    for other, maker in (named.FLIGHT if case.flight else named.MATCHING).items():
        if other in (law.name, "fixed_pattern") or (other == "multipath" and case.setting.kind != "corner"):
            continue
        free = other in ("cyclic_error", "disparity_distortion", "vertical_banding")
        out[other] = [oracle.field([maker(rng)], case.known) for _ in range(DRAWS_OF_FORM if free else 1)]
    return out


def _reach(columns: list[Array], white: Array) -> float:
    A = np.column_stack([c / max(float(np.linalg.norm(c)), 1e-12) for c in columns])
    fitted = A @ np.linalg.lstsq(A, white, rcond=1e-6)[0]
    return round(float(np.linalg.norm(fitted) / max(float(np.linalg.norm(white)), 1e-12)), 3)


def spread_significance(case: Plan, law: Law) -> float:
    """Of a change of the spread or of the validity, to someone who knows its form."""
    total = 0.0
    for shot in case.shots:
        place = Place(shot, 0, np.ones(shot.hits.z.shape))
        inside, frames = shot.interior, len(shot.times)
        if law.stage in ("noise", "filter"):
            share = float(law.size * law.acts(None)) if law.stage == "filter" else 0.0
            factor = np.sqrt((1 - share) / (1 + share)) if share else law.acts(place)
            own = np.broadcast_to(2 * np.log(factor), inside.shape)[inside]
            # the logarithm of a variance from n frames has variance 2 / (n - 1); pixels of a matcher share a window
            alone = 1.0 if case.flight else 0.25
            total += float((own**2).sum()) * alone * (frames - 1) / 2
        elif law.stage == "loss":
            total += float(np.nansum((law.share(place) * law.acts(place))[inside])) * frames
        elif isinstance(case.device, Flight):
            light = np.abs(case.device.phasors(shot, (), 0)[0])
            before, after = case.device.limits(()), case.device.limits([law])
            lost = ((light < after[0]) & (light > before[0])) | ((light > after[1]) & (light < before[1]))
            total += float((lost & inside).sum())
    return float(np.sqrt(total))
