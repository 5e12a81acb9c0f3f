"""The exposure of each view and the light before each camera, from what views show of the same points."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.pose import Array
from fusion.texture.lighting.light import TERMS, Facings, Lighting, terms
from fusion.texture.lighting.parted import Seen, parted

DARKEST = 8.0  # [counts] below, ratios are noise
SIDES = 3  # of an object in one view, that light changes apart from each other: those of a box
INNER = 0.02, 0.98  # shares of the points between which the object lies
KNOWN = 0.002, 0.998  # shares of the looks: beyond what these are lit like, a polynomial runs away


@dataclass(frozen=True)
class SampledView:
    """What one view shows of sample points."""

    source: int  # which camera took it: light stands still before that
    index: NDArray[np.int64]  # (k,) the points, each once
    facing: Facings  # these before the camera
    weight: NDArray[np.float32]  # (k,) above 0
    low: NDArray[np.float32]  # (k, 3) coarse colour [counts]
    fine: NDArray[np.float32]  # (k,) size of what is fine [counts]


@dataclass(frozen=True)
class Exposed:
    """What brightness is made of besides paint."""

    views: Array  # (views, 3) logarithm of each view's exposure; 0 on average
    lights: list[Lighting]  # before each camera, in the order of `source`


def exposed(looks: list[SampledView], points: int) -> Exposed:
    """Part brightness into paint, exposure and light; `looks` show at least one of `points` points.

    There is no light where it explains no more than chance would.
    """
    sources = 1 + max(look.source for look in looks)
    frames = [_frame(looks, source) for source in range(sources)]
    columns = []
    for look in looks:
        own = np.zeros((len(look.index), sources, TERMS - 1))
        own[:, look.source] = terms(look.facing, *frames[look.source])[:, 1:]
        columns.append(own.reshape(len(own), -1))
    tone = [np.log(np.maximum(look.low, DARKEST)) for look in looks]
    plain = parted(seen_of(looks, tone), len(looks), points)
    found = parted(seen_of(looks, tone, columns), len(looks), points)
    if not found.pays(plain):
        even = Lighting(np.zeros(3), 1.0, np.zeros((TERMS, 3)), np.zeros((2, 3)))
        return Exposed(_believed(plain.views, plain.left), [even] * sources)
    weight = np.concatenate([look.weight for look in looks])
    lights = []
    for source, numbers in enumerate(np.split(found.terms, sources)):
        mine = np.concatenate([np.full(len(look.index), look.source == source) for look in looks])
        shade = np.concatenate(columns)[mine, source * (TERMS - 1) : (source + 1) * (TERMS - 1)] @ numbers
        mean = weight[mine] @ shade / max(weight[mine].sum(), 1e-12)
        known = np.quantile(shade - mean, KNOWN, axis=0) if mine.any() else np.zeros((2, 3))
        lights.append(Lighting(*frames[source], np.vstack([-mean, numbers]), known))
    return Exposed(_believed(found.views, found.left), lights)


def seen_of(looks: list[SampledView], values: list[NDArray], columns: list[NDArray] | None = None) -> Seen:
    """What views show, one after the other: values (k, c) of each, and terms (k, t) that may be in them."""
    count = [len(look.index) for look in looks]
    return Seen(
        np.repeat(np.arange(len(looks)), count),
        np.concatenate([look.index for look in looks]),
        np.concatenate([look.weight for look in looks]).astype(float),
        np.concatenate(values).astype(float),
        np.zeros((sum(count), 0)) if columns is None else np.concatenate(columns),
    )


def _frame(looks: list[SampledView], source: int) -> tuple[Array, float]:
    """Middle (3,) and half the size of what a camera sees, in its frame [m]."""
    points = [look.facing.points for look in looks if look.source == source and len(look.index)]
    if not points:
        return np.zeros(3), 1.0
    low, high = np.quantile(np.concatenate(points).astype(float), INNER, axis=0)
    return (low + high) / 2, max(float((high - low).max() / 2), 1e-3)


def _believed(own: NDArray[np.float64], left: float) -> NDArray[np.float64]:
    """Exposures (views, 3) as far as they spread by more than light does that differs between the sides of an object.

    Of light that differs by s (standard deviation) between n sides a view's mean takes s^2 / n, which looks like an
    exposure, and s^2 (n - 1) / n is left over: `left` squared.
    """
    spread = float(np.mean(own**2)) if len(own) else 0.0
    return own * max(0.0, 1 - left**2 / (SIDES - 1) / spread) if spread > 0 else own
