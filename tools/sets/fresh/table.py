"""The judgement in words: a line for each unit, and the figures of all."""

import math
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from tools.sets.fresh.judged import ANGLE, RATIO, WORST, Judged

HEAD = (
    f"{'unit':<9}{'sensor':<7}{'object':<8}{'scale %':>8}{'limit':>6} {'within':<7}{'own fit':>8}{'floor':>7}"
    f"{'known':>7}{'raw mm':>8}{'bias':>6}{'angle deg':>10}{'bound':>7}{'largest':>9}{'std mm':>8}{'true':>7}"
    f"{'ratio':>7}{'fx %':>7}  {'said':<10}{'told':<5}{'status':<11}law"
)


def line(one: Judged) -> str:
    """Scale and its limit, max(0.2 %, 2 sd), in percent; `floor`, `bias`: at true poses; `known`: what the scan says of
    its size; `bound`: of the angles, at best; `told`: of scale or depth; statuses in order.
    """
    kind = {"itof": "itof", "structured_light": "sl"}[one.kind]
    verdict = one.said.verdict if one.said.stated else f"({one.said.verdict})"
    statuses = " ".join(str(x) for x in one.status.values())
    return (
        f"{one.name:<9}{kind:<7}{one.shape:<8}{100 * one.scale:>8.2f}{100 * one.limit:>6.2f} "
        f"{'yes' if one.within else 'no':<7}{100 * one.again:>8.2f}{100 * one.floor:>7.2f}{100 * one.known:>7.2f}"
        f"{1e3 * one.raw:>8.2f}{1e3 * one.bias:>6.2f}{one.angle:>10.3f}{one.allowed.angle:>7.3f}{one.largest:>9.2f}"
        f"{1e3 * one.std:>8.2f}{1e3 * one.std_true:>7.2f}{one.ratio:>7.2f}{100 * one.focal:>7.2f}  "
        f"{verdict:<10}{'yes' if one.told else 'no':<5}{statuses:<11}{one.law}"
    )


def summary(units: Sequence[Judged]) -> str:
    """How many reach what is asked."""
    n = len(units)
    unsaid = [u.name for u in units if u.unsaid]
    well = [u for u in units if u.within]
    angles, ratios = ([getattr(u, name) for u in units] for name in ("angle", "ratio"))
    rows = [
        f"scale within max(0.2 %, 2 sd): {len(well)} of {n}",
        f"scale within it beyond that of true poses and depth (own fit less floor): "
        f"{sum(abs(u.beyond) <= u.limit for u in units)} of {n}",
        f"scale by own fit, rms: {100 * _rms([u.again for u in units]):.3f} %, floor "
        f"{100 * _rms([u.floor for u in units]):.3f} %, beyond it {100 * _rms([u.beyond for u in units]):.3f} %",
        f"scale over what the scan says that it is known to, rms: {_rms([u.scale / u.known for u in units]):.2f}",
        f"worse than {WORST:.1%} (or no mesh) and nothing said: {len(unsaid)} {' '.join(unsaid)}",
        f"right scale, and yet told of scale or depth: {sum(u.told for u in well)} of {len(well)}",
        f"angles within {ANGLE} deg rms: {sum(a <= ANGLE for a in angles)} of {n}, median {_median(angles):.3f}, "
        f"all together {_rms(angles):.3f}",
        f"std within {RATIO} of true poses and depth: {sum(r <= RATIO for r in ratios)} of {n}, median "
        f"{_median(ratios):.3f}",
        f"angles over what the depth allows at best: median {_median([u.angle / u.allowed.angle for u in units]):.2f}",
        "sd of scale that walls and boards allow: "
        + ", ".join(f"{100 * np.quantile([u.allowed.scale for u in units], q):.3f}" for q in (0, 0.5, 1))
        + " % (least, median, largest)",
    ]
    return "\n".join(rows)


def _median(values: Sequence[float]) -> float:
    known = [x for x in values if math.isfinite(x)]
    return float(np.median(known)) if known else math.nan


def _rms(values: Sequence[float]) -> float:
    known = [x for x in values if math.isfinite(x)]
    return float(np.sqrt(np.mean(np.square(known)))) if known else math.nan


def row(one: Judged) -> dict[str, Any]:
    """For JSON; NaN becomes null."""
    told = asdict(one) | {
        "ratio": one.ratio,
        "beyond": one.beyond,
        "limit": one.limit,
        "within": one.within,
        "told": one.told,
    }
    told["unsaid"] = one.unsaid
    return {k: None if isinstance(x, float) and not math.isfinite(x) else x for k, x in told.items()}
