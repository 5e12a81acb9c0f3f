"""The point-to-plane equations of all edges of a joint fit, shrunk to one small normal matrix per edge."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fusion.compute.start import start
from fusion.errors import TrackingError
from fusion.geometry.robust import MAD_TO_STD
from fusion.turntable.axis import Axis, Turns
from fusion.turntable.selfcheck import NAMES, SelfCheck
from fusion.turntable.views import ObjectView

Array = NDArray[np.float64]
Edges = list[tuple[int, int]]

LEAST_PAIRS = 30  # an edge with fewer says nothing
LEAST_COSINE = 0.7  # between the normals of a pair
# of the stacked maps; beyond, every second pixel (third, ...) of them serves: many thousand pairs find the same motion,
# and memory that no cache holds is slow (180 views of 263 x 205 px: a fifth of the time of all pairs)
MOST_BYTES = 100e6
PART = 3_000_000  # pairs at a time
SLANT = np.deg2rad(60)  # flatter surfaces are drawn out more than twice in the image: a pixel there mixes
NOISES = 5.0  # standard deviations of one point within which the same place is seen: 3.5 of a difference (guess)


@dataclass(frozen=True)
class ViewStack:
    """The views of a scan in arrays that one kernel can reach."""

    views: Sequence[ObjectView]
    first: NDArray[np.int32]  # (n + 1,) where each view's points start
    points: NDArray[np.float32]  # (all, 7) of the sampled surface: point [m], normal, sigma [m]
    maps: NDArray[np.float32]  # (n, h, w, 7) the same of the pixels, every `stride`-th of them
    stride: int
    # tones, images: (all,), (n, h, w) what is printed there, see `ObjectView`; (0,), (0, 0, 0) without colour
    tones: NDArray[np.float32] = field(default_factory=lambda: np.zeros(0, np.float32))
    images: NDArray[np.float32] = field(default_factory=lambda: np.zeros((0, 0, 0), np.float32))

    def __post_init__(self) -> None:
        for array in (self.first, self.points, self.maps, self.tones, self.images):
            array.flags.writeable = False  # so they go to a card once

    @cached_property
    def noise(self) -> float:
        """Typical standard deviation of a point [m]."""
        return float(np.median(self.points[:, 6])) if len(self.points) else 0.0

    def reach(self, asked: float) -> float:
        """Largest distance [m] of two points of one place: what is asked, or more where noise alone puts them apart."""
        return max(asked, NOISES * self.noise)

    def thinned(self, most: int) -> "ViewStack":
        """About `most` of the points, evenly from all views."""
        step = max(1, len(self.points) // most)
        return self._with([np.arange(a, b, step) for a, b in pairwise(self.first.tolist())])

    def clear(self) -> "ViewStack":
        """The same without the rims: without points and pixels of surfaces that are seen at more than `SLANT`."""
        maps = self.maps.copy()
        maps[~_faces(maps)] = np.nan
        kept = [np.flatnonzero(_faces(self.points[a:b])) + a for a, b in pairwise(self.first.tolist())]
        return replace(self._with(kept), maps=maps)

    def plain(self) -> "ViewStack":
        """The same without what is printed there."""
        return ViewStack(self.views, self.first, self.points, self.maps, self.stride)

    def _with(self, kept: list[NDArray[np.intp]]) -> "ViewStack":
        """The same with some of the points of each view."""
        first = np.concatenate([[0], np.cumsum([len(k) for k in kept])]).astype(np.int32)
        chosen = np.concatenate(kept)
        tones = self.tones[chosen] if len(self.tones) else self.tones
        return replace(self, first=first, points=self.points[chosen], tones=tones)


def _faces(surface: NDArray[np.float32]) -> NDArray[np.bool_]:
    """Which of surfaces (..., 7), point and normal first, are seen at less than `SLANT`; not what is no surface."""
    point, normal = surface[..., :3], surface[..., 3:6]
    with np.errstate(invalid="ignore"):
        along = np.abs((point * normal).sum(axis=-1))
        return np.asarray(along > np.cos(SLANT) * np.linalg.norm(point, axis=-1))


class AskedErrors(NamedTuple):
    """Errors of camera and depth as they are now, and the names of those that a fit asks for."""

    check: SelfCheck
    names: Sequence[str] = ()

    @property
    def places(self) -> list[int]:
        """Of the asked ones in the order of all."""
        return [k for k, name in enumerate(NAMES) if name in self.names]


@dataclass(frozen=True)
class Sums:
    """What each of m edges adds: normal matrices (m, 15, 15) and vectors (m, 15) in [turn, axis (4), camera (10)],
    sums of squares (m,) [m^2], numbers of fitting and of visible points (m,)."""

    H: Array
    g: Array
    squares: Array
    fitting: NDArray[np.int64]
    visible: NDArray[np.int64]


def stack(views: Sequence[ObjectView]) -> ViewStack:
    """Put views (n), all of one window, together."""
    first = np.concatenate([[0], np.cumsum([len(v.points) for v in views])]).astype(np.int32)
    points = np.concatenate([np.column_stack([v.points, v.normals, v.sigma]) for v in views]).astype(np.float32)
    stride = max(1, int(np.ceil(np.sqrt(len(views) * views[0].map.sigma.size * 28 / MOST_BYTES))))
    maps = np.empty((len(views), *views[0].map.sigma[::stride, ::stride].shape, 7), np.float32)
    for i, v in enumerate(views):
        for k in range(3):  # one column after the other: three values side by side cost numpy twenty times as much
            maps[i, ..., k] = v.map.points[::stride, ::stride, k]
            maps[i, ..., 3 + k] = v.map.normals[::stride, ::stride, k]
        maps[i, ..., 6] = v.map.sigma[::stride, ::stride]
    plain = ViewStack(views, first, points, maps, stride)
    prints, tones = [v.print for v in views], [v.tones for v in views]
    if any(p is None for p in prints) or any(t is None for t in tones):
        return plain
    images = np.stack([p[::stride, ::stride] for p in prints if p is not None])
    return replace(plain, tones=np.concatenate([t for t in tones if t is not None]), images=images)


def edge_sums(
    seen: ViewStack,
    motion: Turns,
    edges: Edges,
    reach: float,
    errors: AskedErrors,
) -> Sums:
    """Equations of all edges.

    Args:
        seen: the views as the camera file has them.
        motion: axis and angles (n,) [rad].
        edges: m pairs of views.
        reach: largest distance of a pair [m], see `Stack.reach`.
        errors: of camera and depth; the columns of those that are not asked for stay 0.

    Raises:
        TrackingError: there is no pair of views to compare.
    """
    if not edges:
        steps = np.abs(np.diff(motion[1][np.isfinite(motion[1])]))
        found = f"about {np.rad2deg(np.median(steps)):.0f} deg from view to view" if len(steps) else "a single view"
        do = "check --step, or turntable_deg in telemetry.csv (--ignore-log does without)"
        raise TrackingError("no two views overlap", found=found, expected="25 deg or less", do=do)
    most = int(np.max(np.diff(seen.first)))
    part = max(1, PART // max(most, 1))
    parts = [_some(seen, motion, edges[k : k + part], reach, errors) for k in range(0, len(edges), part)]
    return Sums(*(np.concatenate([getattr(p, name) for p in parts]) for name in Sums.__dataclass_fields__))


def _some(seen: ViewStack, motion: Turns, edges: Edges, reach: float, errors: AskedErrors) -> Sums:
    from fusion.turntable.pairs.edge_pairs import PAIRED, sum_edges

    axis, angles = motion
    source, model = np.array(edges).T
    turns = angles[model] - angles[source]
    code, out = paired(seen, Turns(axis, turns), edges, (reach, LEAST_COSINE), errors)
    pair = code == PAIRED
    count = pair.sum(axis=1)
    ratio = np.full(code.shape, np.inf, np.float32)
    np.divide(np.abs(out[..., 0]), out[..., 1], out=ratio, where=pair)
    scale = np.where(count >= LEAST_PAIRS, _scale(ratio, count), 0)
    m, k = len(edges), 5 + len(NAMES)
    H, g, totals = np.zeros((m, k, k)), np.zeros((m, k)), np.zeros((m, 3))
    sum_edges(code, out, scale, np.array([*range(5), *(5 + k for k in errors.places)], np.int32), H, g, totals)
    squares, fitting, visible = totals.T
    return Sums(H + np.tril(H, -1).swapaxes(1, 2), g, squares, fitting.astype(np.int64), visible.astype(np.int64))


def _scale(ratio: NDArray[np.float32], count: NDArray[np.int64]) -> Array:
    """Observed over declared spread (m,), at least 1, from the medians of the first `count` of sorted ratios (m, k)."""
    ordered = np.sort(ratio, axis=1)
    rows, last = np.arange(len(ratio)), np.maximum(count, 1)
    middle = (ordered[rows, (last - 1) // 2].astype(float) + ordered[rows, last // 2]) / 2
    return np.maximum(1.0, MAD_TO_STD * np.where(count > 0, middle, 0))


def paired(
    seen: ViewStack,
    motion: Turns,
    edges: Edges,
    limits: tuple[float, float],
    errors: AskedErrors,
) -> tuple[NDArray[np.int8], NDArray[np.float32]]:
    """What became of every source point of every edge (see `edge_pairs`); of pairs residual, sigma and derivatives.

    Args:
        seen: the views as the camera file has them.
        motion: axis, and the turn (m,) [rad] of each edge.
        edges: m pairs of views.
        limits: largest distance of a pair [m] where noise does not ask for more, least cosine between its normals.
        errors: of camera and depth; those up to the last that is asked for have columns too.
    """
    from fusion.turntable.pairs.edge_pairs import CameraErrors, PairedViews, pair_edges  # starts Taichi

    start()
    (axis, turns), check = motion, errors.check
    camera = seen.views[0].map.camera
    most = int(np.max(np.diff(seen.first)))
    code = np.empty((len(edges), most), np.int8)
    out = np.empty((len(edges), most, 7 + max(errors.places, default=-1) + 1), np.float32)
    stated = np.array([camera.fx, camera.fy], np.float32)
    poses = axis.turns(turns).astype(np.float32)
    pair_edges(
        PairedViews(np.array(edges, np.int32), poses, seen.first, seen.points, seen.maps),
        CameraErrors(check.camera(camera).parameters, stated, check.values.astype(np.float32), check.span),
        np.vstack([axis.point, axis.direction, axis.across()]).astype(np.float32),
        np.array([seen.reach(limits[0]), limits[1], seen.stride], np.float32),
        code,
        out,
    )
    return code, out


CLEAR = 0.008  # [m] above a plate both are seen in one pixel: of the camera, not of the object (guess)
FEWEST = 150  # points of a view above a plate, or those on it are kept: a flat object, its marks and rim


def above(view: ObjectView, axis: Axis, height: float, most: int) -> ObjectView:
    """The view with only source points above a height [m], at most about so many.

    The plate turns into itself: it tells nothing of the angle, and what the camera bends in it pulls to no turn at all.
    """
    kept = np.flatnonzero(axis.distance(view.points.astype(float))[1] > height)
    if len(kept) > most:  # a fixed seed: the same scan gives the same result
        kept = np.sort(np.random.default_rng(0).permutation(kept)[:most])
    return view.of(kept)


def thinned_view(view: ObjectView, most: int) -> ObjectView:
    return above(view, Axis(np.zeros(3), np.array([0.0, -1.0, 0.0])), -np.inf, most)
