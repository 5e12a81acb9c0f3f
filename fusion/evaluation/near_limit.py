"""The shortest distance from which on a camera sees a bright or a dark surface."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

ENOUGH = 0.9  # valid share that is usable
APART = 2.0  # factor of brightness between bright and dark surfaces


@dataclass(frozen=True)
class SurfaceSeen:
    """One surface at one distance: distance [m], valid share, and its brightness at 1 m (NaN when not known)."""

    distance: float
    valid: float
    brightness: float


@dataclass(frozen=True)
class NearLimit:
    """Shortest usable distance of one kind of surface."""

    surface: str  # "bright", "dark" or "all"
    distance: float  # [m], interpolated where the valid share crosses 90 %; NaN when it never stays above
    # the distances measured on both sides of it [m]; (0, d) when the nearest is usable already
    interval: tuple[float, float]
    # distances, valid: what was measured, in order of distance
    distances: tuple[float, ...]
    valid: tuple[float, ...]


def near_limits(seen: Sequence[SurfaceSeen]) -> list[NearLimit]:
    """The limit of each kind of surface that was recorded at two or more distances."""
    known = [one for one in seen if np.isfinite([one.distance, one.valid]).all()]
    groups = _groups(known)
    return [_limit(name, group) for name, group in groups if len({round(one.distance, 3) for one in group}) > 1]


def _groups(seen: list[SurfaceSeen]) -> list[tuple[str, list[SurfaceSeen]]]:
    """Bright and dark surfaces, told apart where their brightness leaves a gap of a factor of two or more."""
    light = np.array([one.brightness for one in seen])
    order = np.argsort(light)
    ordered = light[order]
    if len(seen) < 4 or not (np.isfinite(ordered).all() and (ordered > 0).all()):
        return [("all", seen)]
    factors = ordered[1:] / ordered[:-1]
    cut = int(factors.argmax())
    if factors[cut] < APART:
        return [("all", seen)]
    dark = set(order[: cut + 1].tolist())
    return [
        ("bright", [one for i, one in enumerate(seen) if i not in dark]),
        ("dark", [one for i, one in enumerate(seen) if i in dark]),
    ]


def _limit(name: str, seen: list[SurfaceSeen]) -> NearLimit:
    ordered = sorted(seen, key=lambda one: one.distance)
    d, valid = np.array([one.distance for one in ordered]), np.array([one.valid for one in ordered])
    # the nearest distance from which on every valid share is enough; far limits are told by the shares
    best = int(np.argmax(valid))
    below = np.flatnonzero(valid[: best + 1] < ENOUGH)
    measured = (tuple(d.tolist()), tuple(valid.tolist()))
    if valid[best] < ENOUGH:
        return NearLimit(name, float("nan"), (float(d[-1]), float("inf")), *measured)
    if not len(below):
        return NearLimit(name, float(d[0]), (0.0, float(d[0])), *measured)
    k = int(below[-1])
    share = (ENOUGH - valid[k]) / (valid[k + 1] - valid[k])
    return NearLimit(name, float(d[k] + share * (d[k + 1] - d[k])), (float(d[k]), float(d[k + 1])), *measured)
