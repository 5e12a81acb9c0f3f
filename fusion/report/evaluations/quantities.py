"""The page of results of many units of one camera: each quantity over time, and one table of how far they spread."""

from pathlib import Path

import numpy as np

from fusion.report.evaluations.units import unit_color
from fusion.report.kit.page import Figure, Number, Page, Section, write_page
from fusion.report.kit.palette import new_figure, styled, to_svg
from fusion.report.kit.tables import numbers_table
from fusion.simulation.exporting.quantities import Quantities

MOST = 12  # pictures


def quantities_report(path: Path, found: Quantities, command: str) -> None:
    """Write `report.html`."""
    page = Page(
        title=f"{len(found.names)} units of one camera",
        subtitle=", ".join(found.names)[:200],
        numbers=[Number("Units", str(len(found.names)), "", f"{len(found.unit)} results")],
        sections=[
            Section("Spread", "", (over_units(found),), html=quantity_table(found)),
            *([Section("Over time", "", (over_time(found),))] if np.isfinite(found.date).any() else []),
        ],
        warnings=[],
        command=command,
    )
    write_page(path, page)


def over_units(found: Quantities) -> Figure:
    """Each quantity by unit."""
    return _figure(found, found.unit.astype(float), "unit", "Units side by side", "units-side-by-side")


def over_time(found: Quantities) -> Figure:
    """Each quantity over the dates."""
    return _figure(found, found.date, "date [years]", "Units over time", "units-over-time")


def quantity_table(found: Quantities) -> str:
    """Quantity by quantity."""
    head = ["quantity", "mean of all", "between units (95 %)", "between dates (95 %)", "drift a year (95 %)"]
    return numbers_table(head, table_rows(found))


def table_rows(found: Quantities) -> list[list[str]]:
    """Quantity, mean and the three intervals, as text."""
    rows = []
    for n, label in enumerate(found.labels):
        cells = [label, f"{found.values[:, n].mean():.5g}"]
        for one in (found.between, found.within, found.drift):
            known = np.isfinite(one.value[n])
            cells.append(f"{one.value[n]:.3g} ({one.low[n]:.3g} to {one.high[n]:.3g})" if known else "-")
        rows.append(cells)
    return rows


def _figure(found: Quantities, place: np.ndarray, along: str, title: str, name: str) -> Figure:
    shown = found.labels[:MOST]
    rows = -(-len(shown) // 3)
    with styled():
        figure = new_figure(11.0, 2.6 * rows)
        for n, label in enumerate(shown):
            ax = figure.add_subplot(rows, 3, n + 1)
            for unit in range(len(found.names)):
                some = np.flatnonzero((found.unit == unit) & np.isfinite(place))
                some = some[np.argsort(place[some], kind="stable")]
                color = unit_color(len(found.names), unit)
                ax.plot(place[some], found.values[some, n], color=color, marker="o", markersize=4)
            ax.set_title(label, fontsize=8)
            ax.set_xlabel(along)
        svg = to_svg(figure, name)
    left = f" The first {MOST} of {len(found.labels)} quantities." if len(found.labels) > MOST else ""
    return Figure(title, svg, title + ".", f"A colour is a unit, a point a result.{left}")
