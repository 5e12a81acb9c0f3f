"""The left and right edge of a target: where they are in every row of every frame, how much they jitter."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.calibration.noise.repeats import batch_error
from fusion.calibration.noise.target import FlatTarget

Image = NDArray[np.floating]

STRIP = (4, 14)  # [px] on both sides of an edge: fewest and most
OUTER = 4  # [px] at the outer end of the strip that show what is behind
STRAY = 0.01  # share of the pixels beyond an edge that show the target all the same, and least share of holes within
MOST_HOLES = 0.5  # share of holes that still leaves an edge
NEAR = 0.03  # [m] with nothing behind, nearer to the plane than this is target; above the noise of any camera nearby


def strip_width(target: FlatTarget) -> int:
    """Pixels on both sides of an edge that belong to it: a third of the target, so that its two edges stay apart."""
    width = int(np.median(target.mask[slice(*target.rows)].sum(axis=1)))
    return int(np.clip(width // 3, *STRIP))


@dataclass(frozen=True)
class SeenEdge:
    """One edge in one frame."""

    positions: NDArray[np.float64]  # (rows,) column [px] at which the target ends; NaN where that cannot be said
    holes: float  # share of the target's pixels just inside that do not show it; NaN where none is known


def seen_edge(depth: Image, target: FlatTarget, plane: Image, side: int) -> SeenEdge:
    """Where the target ends in every row of its inside.

    The likeliest place, as pixels are missing on the target, too: a count of those that show it would take each hole
    for a shift of the edge.

    Args:
        side: 0 for the left edge, 1 for the right.
    """
    rows, ends, width = _ends(target, side)
    columns = depth.shape[1]
    outwards = 1 if side else -1
    strip = ends[:, None] + outwards * np.arange(-width, width + 1)[None, :]
    whole = (ends >= 0) & (strip.min(axis=1) >= 0) & (strip.max(axis=1) < columns)
    strip = np.clip(strip, 0, columns - 1)
    z, at = depth[rows[:, None], strip], plane[rows[:, None], strip]
    # the outer end of the strip sees what is behind; nearer to the plane than half way is target
    outer = z[:, -OUTER:]
    behind = np.nanmedian(outer) if np.isfinite(outer).any() else np.nan
    half = 0.5 * (behind - at) if np.isfinite(behind) else np.full(at.shape, NEAR)
    on = np.abs(z - at) < np.maximum(np.abs(half), 1e-3)
    within = on[whole, : max(1, width // 2)]
    holes = 1.0 - float(within.mean()) if within.size else float("nan")
    p = float(np.clip(holes, STRAY, MOST_HOLES)) if np.isfinite(holes) else STRAY
    gain = np.cumsum(np.where(on, np.log((1 - p) / STRAY), np.log(p / (1 - STRAY))), axis=1)
    inside = strip.shape[1] - gain[:, ::-1].argmax(axis=1)  # the last of equally likely ones
    position = strip[:, 0] + outwards * (inside - 0.5)
    return SeenEdge(np.where(whole, position, np.nan), holes)


def edge_depth(target: FlatTarget, plane: Image, side: int) -> float:
    """Depth [m] of the target's plane at its left (0) or right (1) edge."""
    rows, ends, _ = _ends(target, side)
    return float(np.median(plane[rows[ends >= 0], ends[ends >= 0]])) if (ends >= 0).any() else float("nan")


def nothing_behind(valid: Image, target: FlatTarget, side: int) -> bool:
    """Whether most of the pixels just outside an edge have no depth in most frames; `valid`: (h, w) shares."""
    rows, ends, width = _ends(target, side)
    away = np.arange(2, width + 1) * (1 if side else -1)
    strip = ends[:, None] + away[None, :]
    inside = (ends >= 0)[:, None] & (strip >= 0) & (strip < valid.shape[1])
    seen = valid[np.broadcast_to(rows[:, None], strip.shape)[inside], strip[inside]]
    return bool(seen.size and np.median(seen) < 0.5)


def spread_with_error(positions: Image, holes: float = 0.0) -> tuple[float, float]:
    """Standard deviation [px] of edge positions (frames, rows) about a smooth line, and how well it is known.

    An edge that is not parallel to the columns meets all phases of the grid, so that rounding to whole pixels adds
    1/12 px^2 to the variance; that is taken out. So is what a share of `holes` p in the target adds: as many of the
    last pixels in a row are missing by chance as a geometric law has them, of variance p / (1 - p)^2.
    """
    known = np.isfinite(positions)
    if known.sum() < 10:
        return float("nan"), float("nan")
    rows = np.broadcast_to(np.linspace(-1, 1, positions.shape[1]), positions.shape)
    # a parabola: a lens bends straight edges
    line = np.polynomial.polynomial.polyfit(rows[known], positions[known], 2)
    residual = np.where(known, positions - np.polynomial.polynomial.polyval(rows, line), np.nan)
    kept = np.abs(residual - np.nanmedian(residual)) < 0.75 * STRIP[1]
    residual = np.where(kept, residual - residual[kept].mean(), np.nan)
    variance = float(np.nanmean(residual**2))
    chance = min(holes, MOST_HOLES) if np.isfinite(holes) else 0.0
    spread = float(np.sqrt(max(variance - 1 / 12 - chance / (1 - chance) ** 2, 0.0)))
    # few phases of the grid: the part of the rounding is not 1/12 px^2 where the jitter is far below a pixel
    across = np.ptp(np.polynomial.polynomial.polyval(rows[0], line))
    phases = np.exp(-2 * (np.pi * max(spread, 0.1)) ** 2) / 6 / (1 + 2 * across)
    error = float(np.hypot(batch_error(residual**2), phases))
    return spread, error / (2 * max(spread, np.sqrt(error) if error > 0 else 1e-6))


def _ends(target: FlatTarget, side: int) -> tuple[NDArray[np.intp], NDArray[np.intp], int]:
    """Rows of the inside, the column where the target ends in each (-1 without target), and the strip's width."""
    rows = np.arange(*target.rows)
    held = target.mask[rows]
    last = target.mask.shape[1] - 1
    ends = np.where(held.any(axis=1), held.argmax(axis=1) if side == 0 else last - held[:, ::-1].argmax(axis=1), -1)
    return rows, ends, strip_width(target)
