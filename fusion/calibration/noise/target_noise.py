"""Noise and valid shares on a flat target, as Fankhauser 2015 measures them."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fusion.calibration.noise.edge import SeenEdge, edge_depth, nothing_behind, seen_edge, spread_with_error
from fusion.calibration.noise.repeats import Repeats, repeats_of
from fusion.calibration.noise.target import FlatTarget, find_target, fit_plane
from fusion.calibration.series import PixelSeries
from fusion.calibration.shared_noise import COARSE, SharedNoise, middle_mean, shared_noise
from fusion.errors import FusionError
from fusion.geometry.camera import Camera

Image = NDArray[np.floating]

PATCH = 240  # [px] of the target nearest to its middle: noise changes little over them
OUTLIER = 6.0  # standard deviations from the plane
LEAST_OUTLIER = 0.03  # [m] nearer to the plane than this nothing is an outlier; above the noise of any camera nearby
MOST_FRAMES = 2000  # whose values are kept at a time; of longer series every second, third, ...
SUNNY, FEWEST = 0.1, 5  # share of the frames and number of values that still place a target, where more are missing
SCORES = 20  # frames whose z-scores are kept


@dataclass(frozen=True)
class TargetNoise:
    """What one pose of the target says."""

    pixel: tuple[int, int]  # (v, u) of the target's middle
    depth: float  # there [m], of the plane through the target as it was measured, mean over the pixels of `axial`
    tilt: float  # between the lines of sight to these pixels and the normal [rad], as `mean_tilt`
    frames: int  # number of frames
    axial: float  # standard deviation of one depth at the middle [m], NaN without values; outliers are left out
    axial_std: float  # how well it is known [m], from the scatter between frames: neighbours may share their noise
    # of the left and of the right edge [m], the spread of their pixels; NaN where there is none
    lateral: tuple[float, float]
    # valid, no_data, outliers: shares of the pixels inside, one in sum
    valid: float
    no_data: float
    outliers: float
    z_scores: NDArray[np.float32]  # a sample of depths less their pixel's mean, over their pixel's standard deviation
    lateral_std: tuple[float, float] = (float("nan"), float("nan"))  # how well the lateral spreads are known [m]
    # whether most pixels just outside the left and the right edge have no depth: shadow or empty
    nothing_behind: tuple[bool, bool] = (False, False)
    step: float = 0.0  # mean gap between neighbouring values that occur [m]: the rounding; 0 where it cannot be told
    middle: tuple[NDArray[np.intp], ...] = ()  # rows and columns (n,) of the pixels that `axial` is of
    # of the left and the right edge [m]: those of a tilted target are nearer and farther than its middle
    edge_depth: tuple[float, float] = (float("nan"), float("nan"))
    # what the middle's pixels and the edges' share from frame to frame; where it is told, no noise above holds it
    shared: SharedNoise | None = None


def measure_target(
    depths: Iterable[Image],
    camera: Camera,
    target: FlatTarget | None = None,
    sigma: float | None = None,
    correct: Callable[[Image], Image] | None = None,
) -> TargetNoise:
    """Noise of a target that stands still in front of a still camera.

    Args:
        depths: frames (h, w) [m], iterated twice, so no one-way iterator.
        target: where it is, when that is known; else it is found in the mean of the frames.
        sigma: a noise [m] to judge outliers by; the measured one by default.
        correct: takes known errors out of a mean depth (h, w) [m]; the tilt is then that of the corrected target.
            Depth and noise are those of the images as they come, which is what a filter knows later.
    Raises:
        FusionError: no target, or fewer than two frames.
    """
    series = PixelSeries(camera.shape)
    for depth in depths:
        series.add(depth)
    if series.frames < 2:
        raise FusionError("too few frames for a noise", found=series.frames, expected="2 or more, better 100")
    found, mean = _found(series, camera, target)
    plane = found.plane_depth(camera)
    middle = _middle(found, camera.shape)
    limit = max(OUTLIER * (sigma if sigma is not None else _pooled(series, middle)), LEAST_OUTLIER)
    where = np.nonzero(middle)
    look = _look(depths, found, plane, limit, -(-series.frames // MOST_FRAMES), where)
    v, u = (round(float(np.mean(indices))) for indices in where)
    at_edges = edge_depth(found, plane, 0), edge_depth(found, plane, 1)
    stands = found if correct is None else fit_plane(correct(mean), camera, found)
    tilts = stands.tilt(camera)[middle]
    repeats, shared = _own_noise(look.values, tilts)
    lateral = [
        [z / camera.fx * x for x in _jitter(seen, shared.told)] for z, seen in zip(at_edges, look.edges, strict=True)
    ]
    return TargetNoise(
        (v, u),
        float(plane[middle].mean()),
        mean_tilt(tilts),
        series.frames,
        repeats.sigma,
        repeats.sigma_std,
        (lateral[0][0], lateral[1][0]),
        valid=look.shares[0],
        no_data=look.shares[1],
        outliers=look.shares[2],
        z_scores=repeats.scores[: SCORES * PATCH],
        lateral_std=(lateral[0][1], lateral[1][1]),
        nothing_behind=(nothing_behind(series.valid, found, 0), nothing_behind(series.valid, found, 1)),
        step=repeats.step,
        middle=where,
        edge_depth=at_edges,
        shared=shared,
    )


def _found(series: PixelSeries, camera: Camera, target: FlatTarget | None) -> tuple[FlatTarget, Image]:
    """The target and the mean depth (h, w) [m] that shows it."""
    # a pixel with few values would bring its outliers into the search
    mean = np.where(series.valid > 0.5, series.mean, np.nan)
    if target is not None:
        return target, mean
    try:
        return find_target(mean, camera), mean
    except FusionError:
        # in the sun most values are missing: means of fewer, where they are the majority's
        fewer = np.where((series.valid > SUNNY) & (series.count >= FEWEST), series.mean, np.nan)
        if np.isfinite(fewer).sum() < 1.05 * np.isfinite(mean).sum() + 1:
            raise
        return find_target(fewer, camera), fewer


@dataclass(frozen=True)
class _Look:
    """The second look at the frames: shares inside, left and right edge per frame, values (frames, n) of the middle."""

    shares: tuple[float, float, float]
    edges: tuple[list[SeenEdge], list[SeenEdge]]
    values: Image


def _look(
    depths: Iterable[Image],
    found: FlatTarget,
    plane: Image,
    limit: float,
    every: int,
    where: tuple[NDArray[np.intp], ...],
) -> _Look:
    """The frames once more: target and its plane (h, w) [m], outlier limit [m] and every which frame, middle."""
    shares, frames = np.zeros(3), 0
    edges: tuple[list[SeenEdge], list[SeenEdge]] = ([], [])
    values: list[Image] = []
    for frames, depth in enumerate(depths, start=1):
        inside = depth[found.inside]
        off = np.abs(inside - plane[found.inside]) > limit
        none = ~np.isfinite(inside)
        shares += [(~off & ~none).mean(), none.mean(), (off & ~none).mean()]
        if frames % every == 0:
            values.append(depth[where])
            for side, seen in enumerate(edges):
                seen.append(seen_edge(depth, found, plane, side))
    valid, no_data, outliers = (float(share) for share in shares / max(frames, 1))
    return _Look((valid, no_data, outliers), edges, np.array(values))


def _own_noise(values: Image, tilts: Image) -> tuple[Repeats, SharedNoise]:
    """What values (frames, n) [m] do beside each other, and what they share from frame to frame.

    The second is the rig's where it is much: a camera that sways or creeps before its target.
    """
    found = repeats_of(values, tilts)
    known = np.isfinite(values).any(axis=0)
    away = values[:, known] - np.nanmedian(values[:, known], axis=0)
    means = np.array([middle_mean(row) for row in away])
    shared = shared_noise(
        np.arange(len(means), dtype=float), means, found.sigma, bool(found.sigma < COARSE * found.step)
    )
    if not shared.told:
        return found, shared
    own = repeats_of(values - np.nan_to_num(means)[:, None], tilts)
    return replace(own, step=found.step), shared


def _jitter(seen: list[SeenEdge], alone: bool) -> tuple[float, float]:
    """By how much an edge jitters [px], and how well that is known; `alone`: without what all of its rows share."""
    known = [edge.holes for edge in seen if np.isfinite(edge.holes)]
    positions = np.array([edge.positions for edge in seen], float)
    if alone:
        usual = np.array([middle_mean(column) for column in positions.T])
        positions = positions - np.nan_to_num([middle_mean(row) for row in positions - usual])[:, None]
    return spread_with_error(positions, float(np.mean(known)) if known else 0.0)


def mean_tilt(tilts: Image) -> float:
    """The tilt [rad] at which noise grows as on the average over these: noise is steep in the angle near 90 deg."""
    held = np.clip(tilts, 0.0, np.deg2rad(89.0))
    root = float(np.sqrt(np.mean((held / (np.pi / 2 - held)) ** 2)))  # laws hold this square
    return np.pi / 2 * root / (1.0 + root)


def _middle(target: FlatTarget, shape: tuple[int, int]) -> NDArray[np.bool_]:
    """(h, w) the pixels inside nearest to the middle of the target."""
    v, u = np.mgrid[0 : shape[0], 0 : shape[1]]
    high, wide = np.ptp(target.rows), np.ptp(target.columns)
    # columns count more where the target is narrow: the tilt changes across them
    away = np.hypot((v - np.mean(target.rows)) / high, (u - np.mean(target.columns)) / wide)
    inside = np.zeros(shape, bool)
    inside[target.inside] = True
    away[~inside] = np.inf
    nearest = np.argsort(away, axis=None)[: min(PATCH, int(inside.sum()))]
    out = np.zeros(shape, bool)
    out.flat[nearest] = True
    return out


def _pooled(series: PixelSeries, where: NDArray[np.bool_]) -> float:
    """Standard deviation of one value [m], 0 where there are none."""
    variance, freedom = series.std[where] ** 2, series.count[where] - 1
    known = freedom > 0
    return float(np.sqrt((variance[known] * freedom[known]).sum() / max(freedom[known].sum(), 1)))
