"""The page of many units of one camera: each over depth, over time, and one table of how far they spread."""

from pathlib import Path

import numpy as np

from fusion.report.kit.page import Figure, Number, Page, Section, write_page
from fusion.report.kit.palette import new_figure, styled, to_svg
from fusion.report.kit.tables import numbers_table
from fusion.simulation.exporting.units import Interval, Units

SHOWN = (1.0, 2.0, 4.0)  # [m] over time
COLORS = "viridis"


def units_report(path: Path, found: Units, command: str) -> None:
    """Write `report.html`."""
    at = int(np.argmin(np.abs(found.depths - 1.0)))
    drift = found.drift
    numbers = [
        Number("Units", str(len(found.names)), "", f"{len(found.unit)} models"),
        Number("Between units at 1 m", _mm(found.between.value[at]), "mm", _ends(found.between, at)),
    ]
    if np.isfinite(drift.value[at]):
        numbers.append(Number("Drift at 1 m", _mm(drift.value[at]), "mm a year", _ends(drift, at)))
    pictures = [over_depth(found)]
    dated = bool(np.isfinite(found.date).any())
    page = Page(
        title=f"{len(found.names)} units of one camera",
        subtitle=", ".join(found.names)[:200],
        numbers=numbers,
        sections=[
            Section("Over depth", "", tuple(pictures), html=unit_table(found)),
            *([Section("Over time", "", (over_time(found),))] if dated else []),
        ],
        warnings=[],
        command=command,
    )
    write_page(path, page)


def over_depth(found: Units) -> Figure:
    """Mean error and spread of each model."""
    with styled():
        figure = new_figure(11.0, 3.6)
        for ax, values, name in zip(
            figure.subplots(1, 2), (found.bias, found.sigma), ("mean error", "spread"), strict=True
        ):
            for row, unit in enumerate(found.unit):
                ax.plot(
                    found.depths, 1e3 * values[row], color=unit_color(len(found.names), unit), marker="o", markersize=3
                )
            ax.set_xlabel("depth [m]")
            ax.set_ylabel(f"{name} [mm]")
        svg = to_svg(figure, "units-over-depth")
    widest = 1e3 * np.nanmax(found.between.value)
    title = f"Units differ by {widest:.2g} mm (one standard deviation) where they differ most"
    return Figure(title, svg, title + ".", "A colour is a unit, a line a model; frontal walls, over the image.")


def over_time(found: Units) -> Figure:
    """Mean error of each unit over its dates."""
    with styled():
        figure = new_figure(11.0, 3.4)
        for ax, depth in zip(figure.subplots(1, len(SHOWN)), SHOWN, strict=True):
            column = int(np.argmin(np.abs(found.depths - depth)))
            for unit in range(len(found.names)):
                rows = np.flatnonzero((found.unit == unit) & np.isfinite(found.date))
                rows = rows[np.argsort(found.date[rows])]
                ax.plot(
                    found.date[rows],
                    1e3 * found.bias[rows, column],
                    color=unit_color(len(found.names), unit),
                    marker="o",
                    markersize=4,
                )
            ax.set_title(f"at {depth:g} m")
            ax.set_xlabel("date [years]")
            ax.ticklabel_format(axis="x", useOffset=False)
            ax.locator_params(axis="x", nbins=4)
            ax.set_ylabel("mean error [mm]")
        svg = to_svg(figure, "units-over-time")
    at = int(np.argmin(np.abs(found.depths - 1.0)))
    known = np.isfinite(found.drift.value[at])
    title = f"Drift at 1 m: {_mm(found.drift.value[at])} mm a year, {_ends(found.drift, at)}" if known else "Over time"
    return Figure(
        title, svg, title + ".", "A colour is a unit. The slope is common to all, each with a mean of its own."
    )


def unit_table(found: Units) -> str:
    """Depth by depth."""
    names = ["between units", "between dates", "drift a year"]
    head = ["depth [m]", "mean of all [mm]", *(f"{name} [mm] (95 %)" for name in names)]
    rows = []
    for n, depth in enumerate(found.depths):
        cells = [f"{depth:g}", _mm(float(np.mean(found.bias[:, n])))]
        some = [(one.value[n], one) for one in (found.between, found.within, found.drift)]
        cells += [f"{_mm(value)} ({_ends(one, n)})" if np.isfinite(value) else "-" for value, one in some]
        rows.append(cells)
    return numbers_table(head, rows)


def unit_color(count: int, unit: int) -> tuple[float, ...]:
    """Of one of `count` units."""
    import matplotlib

    return tuple(matplotlib.colormaps[COLORS](0.05 + 0.85 * unit / max(count - 1, 1)))


def _mm(value: float) -> str:
    return "-" if not np.isfinite(value) else f"{1e3 * value:.3f}"


def _ends(one: Interval, n: int) -> str:
    known = np.isfinite(one.low[n]) and np.isfinite(one.high[n])
    return f"{1e3 * one.low[n]:.3f} to {1e3 * one.high[n]:.3f}" if known else "-"
