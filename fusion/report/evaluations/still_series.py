"""Over time: the series of one pixel with its histogram, and the drift of the centre with its fit."""

import numpy as np
from numpy.typing import NDArray

from fusion.evaluation.still.drift import SHORTEST, Drift
from fusion.report.kit.page import Figure
from fusion.report.kit.palette import BLUE, GREY, ORANGE, new_figure, styled, to_svg

SHOWN = 2000  # values of a series that are drawn
Array = NDArray[np.floating]


def pixel_figure(time: Array, series: Array, text: Figure) -> Figure:
    """Depth (n,) [m] of one pixel over time [s], and its histogram with the normal curve of the same deviation."""
    known = np.isfinite(series)
    z = series[known]
    mean, sigma = float(z.mean()), float(z.std(ddof=1))
    off = (series - mean) * 1e3
    step = max(1, len(series) // SHOWN)
    with styled():
        figure = new_figure(11.0, 3.4)
        grid = figure.add_gridspec(1, 2, width_ratios=(3, 1))
        left = figure.add_subplot(grid[0])
        left.plot(time[::step], off[::step], ".-", color=BLUE, markersize=4, linewidth=0.7)
        left.axhline(0, color=GREY, linewidth=0.8)
        left.set_xlabel("time [s]")
        left.set_ylabel(f"depth less {mean:.4f} m [mm]")
        right = figure.add_subplot(grid[1], sharey=left)
        edges = _bins(off[known])
        right.hist(off[known], edges.tolist(), orientation="horizontal", color=GREY, alpha=0.7)
        if sigma > 0:
            x = np.linspace(edges[0], edges[-1], 201)
            normal = np.exp(-0.5 * (x / sigma / 1e3) ** 2) / (np.sqrt(2 * np.pi) * sigma * 1e3)
            right.plot(normal * len(z) * (edges[1] - edges[0]), x, color=BLUE, label="normal")
            right.legend(loc="upper right")
        right.tick_params(labelleft=False)
        right.set_xlabel("frames")
        return Figure(text.title, to_svg(figure, "pixel-series"), text.alt, text.caption)


def _bins(off: Array) -> Array:
    """Borders [mm] that do not cut through the values of a rounded depth."""
    values = np.unique(np.round(off, 6))
    if 1 < len(values) <= 24:
        step = float(np.median(np.diff(values)))
        return np.arange(values[0] - step / 2, values[-1] + step, step)
    low, high = float(np.min(off)), float(np.max(off))
    return np.linspace(low, max(high, low + 1e-3), 25)


def drift_figure(time: Array, centre: Array, drift: Drift, text: Figure) -> Figure:
    """Mean of the centre (n,) [m] over time [s], block means and the warm-up curve."""
    step = max(1, len(time) // SHOWN)
    long = float(time[-1]) if len(time) else 0.0
    unit, name = (60.0, "min") if long > 300 else (1.0, "s")
    with styled():
        figure = new_figure(11.0, 3.4)
        ax = figure.subplots()
        ax.plot(time[::step] / unit, centre[::step] * 1e3, ".", color=GREY, markersize=3, label="frames")
        if len(drift.time) < len(time):
            ax.plot(drift.time / unit, drift.value * 1e3, "o", color=ORANGE, markersize=4, label="means of blocks")
        if np.isfinite(drift.fitted).all() and long >= SHORTEST:
            ax.plot(drift.time / unit, drift.fitted * 1e3, color=BLUE, label="warm-up curve")
        ax.set_xlabel(f"time [{name}]")
        ax.set_ylabel("mean depth of the centre,\nless its usual value [mm]")
        ax.legend(loc="best", ncols=3)
        return Figure(text.title, to_svg(figure, "drift"), text.alt, text.caption)
