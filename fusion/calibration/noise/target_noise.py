"""Noise and valid shares on a flat target, as Fankhauser 2015 measures them."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.calibration.noise.target import Target, find_target
from fusion.calibration.series import PixelSeries
from fusion.errors import FusionError
from fusion.geometry.camera import Camera

Image = NDArray[np.floating]

PATCH = 240  # [px] of the target nearest to its middle: noise changes little over them
STRIP = 8  # [px] on both sides of an edge
OUTLIER = 6.0  # standard deviations from the plane
LEAST_OUTLIER = 0.03  # [m] nearer to the plane than this nothing is an outlier


@dataclass(frozen=True)
class TargetNoise:
    """What one pose of the target says.

    Attributes:
        pixel: (v, u) of the target's middle, to which all else belongs.
        depth: there [m], of the plane through the target.
        tilt: between the line of sight to the middle and the normal [rad].
        frames: number of frames.
        axial: standard deviation of one depth at the middle [m], NaN without values.
        axial_std: how well it is known [m].
        lateral: of the left and of the right edge [m], the spread of their pixels; NaN where there is none.
        valid, no_data, outliers: shares of the pixels inside, one in sum.
        z_scores: a sample of depths less their pixel's mean, over their pixel's standard deviation.
    """

    pixel: tuple[int, int]
    depth: float
    tilt: float
    frames: int
    axial: float
    axial_std: float
    lateral: tuple[float, float]
    valid: float
    no_data: float
    outliers: float
    z_scores: NDArray[np.float32]


def measure_target(
    depths: Iterable[Image], camera: Camera, target: Target | None = None, sigma: float | None = None
) -> TargetNoise:
    """Noise of a target that stands still in front of a still camera.

    Args:
        depths: frames (h, w) [m], iterated twice, so no one-way iterator.
        target: where it is, when that is known; else it is found in the mean of the frames.
        sigma: a noise [m] to judge outliers by; the measured one by default.
    Raises:
        FusionError: no target, or fewer than two frames.
    """
    series = PixelSeries(camera.shape)
    for depth in depths:
        series.add(depth)
    if series.frames < 2:
        raise FusionError("too few frames for a noise", found=series.frames, expected="2 or more, better 100")
    # a pixel with few values would bring its outliers into the search
    found = target or find_target(np.where(series.valid > 0.5, series.mean, np.nan), camera)
    plane, tilt = found.plane_depth(camera), found.tilt(camera)
    middle = _middle(found, camera.shape)
    axial, error = _pooled(series, middle)
    limit = max(OUTLIER * (sigma if sigma is not None else np.nan_to_num(axial)), LEAST_OUTLIER)
    shares = np.zeros(3)
    edges: tuple[list[Image], list[Image]] = ([], [])
    scores: list[Image] = []
    for depth in depths:
        inside = depth[found.inside]
        off = np.abs(inside - plane[found.inside]) > limit
        none = ~np.isfinite(inside)
        shares += [(~off & ~none).mean(), none.mean(), (off & ~none).mean()]
        for side, positions in zip((0, 1), edges, strict=True):
            positions.append(edge_positions(depth, found, plane, side))
        if len(scores) < 20:
            scores.append(_scores(depth, series, middle))
    v, u = (int(np.mean(indices)) for indices in np.nonzero(middle))
    lateral = tuple(lateral_spread(np.array(p)) * plane[v, u] / camera.fx for p in edges)
    return TargetNoise(
        (v, u),
        float(plane[v, u]),
        float(tilt[v, u]),
        series.frames,
        axial,
        error,
        (lateral[0], lateral[1]),
        valid=float(shares[0] / series.frames),
        no_data=float(shares[1] / series.frames),
        outliers=float(shares[2] / series.frames),
        z_scores=np.concatenate(scores).astype(np.float32),
    )


def edge_positions(depth: Image, target: Target, plane: Image, side: int) -> NDArray[np.float64]:
    """(rows,) column [px] at which the target ends in every row of its inside; NaN where that cannot be said.

    Args:
        side: 0 for the left edge, 1 for the right.
    """
    rows = np.arange(*target.rows)
    columns = np.arange(target.mask.shape[1])
    held = target.mask[rows]
    ends = np.where(
        held.any(axis=1), held.argmax(axis=1) if side == 0 else columns[-1] - held[:, ::-1].argmax(axis=1), -1
    )
    strip = ends[:, None] + np.arange(-STRIP, STRIP + 1)[None, :]
    whole = (ends >= 0) & (strip[:, 0] >= 0) & (strip[:, -1] < len(columns))
    strip = np.clip(strip, 0, len(columns) - 1)
    z, at = depth[rows[:, None], strip], plane[rows[:, None], strip]
    # the outer end of the strip sees what is behind; nearer to the plane than half way is target
    outer = z[:, :4] if side == 0 else z[:, -4:]
    behind = np.nanmedian(outer) if np.isfinite(outer).any() else np.nan
    half = 0.5 * (behind - at) if np.isfinite(behind) else np.full(at.shape, LEAST_OUTLIER)
    on = np.abs(z - at) < np.maximum(np.abs(half), 1e-3)
    count = on.sum(axis=1)
    position = strip[:, -1] + 0.5 - count if side == 0 else strip[:, 0] - 0.5 + count
    return np.where(whole, position, np.nan)


def lateral_spread(positions: NDArray[np.float64]) -> float:
    """Standard deviation [px] of edge positions (frames, rows) about a smooth line, the pixel grid's part removed.

    An edge that is not parallel to the columns meets all phases of the grid, so that rounding to whole pixels adds
    1/12 px^2 to the variance.
    """
    if not np.isfinite(positions).any():
        return float("nan")
    rows = np.broadcast_to(np.linspace(-1, 1, positions.shape[1]), positions.shape)
    known = np.isfinite(positions)
    # a parabola: a lens bends straight edges
    line = np.polynomial.polynomial.polyfit(rows[known], positions[known], 2)
    residual = (positions - np.polynomial.polynomial.polyval(rows, line))[known]
    centre = np.median(residual)
    kept = residual[np.abs(residual - centre) < 0.75 * STRIP]
    return float(np.sqrt(max(kept.var() - 1 / 12, 0.0)))


def _middle(target: Target, shape: tuple[int, int]) -> NDArray[np.bool_]:
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


def _pooled(series: PixelSeries, where: NDArray[np.bool_]) -> tuple[float, float]:
    """Standard deviation of one value [m], and how well it is known: pixels taken as independent."""
    variance, freedom = series.std[where] ** 2, series.count[where] - 1
    known = freedom > 0
    total = int(freedom[known].sum())
    if not total:
        return float("nan"), float("nan")
    sigma = float(np.sqrt((variance[known] * freedom[known]).sum() / total))
    return sigma, sigma / float(np.sqrt(2 * total))


def _scores(depth: Image, series: PixelSeries, where: NDArray[np.bool_]) -> NDArray[np.float32]:
    """Depths less their pixel's mean over its standard deviation; pixels that never change are left out."""
    spread = series.std[where]
    known = np.isfinite(spread) & (spread > 0)
    return ((depth[where] - series.mean[where])[known] / spread[known]).astype(np.float32)
