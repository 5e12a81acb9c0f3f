"""Signed distances between a mesh and its reference: coloured views and the histogram."""

from collections.abc import Sequence

import numpy as np

from fusion.geometry.pose import Array
from fusion.mesh.drawing.shading import Lit
from fusion.mesh.mesh import Mesh
from fusion.report.kit.page import Figure
from fusion.report.kit.palette import BLUE, DIVERGING, GREEN, GREY, INK, ORANGE, new_figure, styled, to_svg
from fusion.report.kit.views import Scale, ViewRow, mesh_views, nice_length, scale_colors

WITHIN = (0.001, 0.002, 0.005)  # [m] as of `DistanceStatistics`


def distance_scale(distance: Array) -> Scale:
    """Symmetric colours [mm] that hold 95 % of the distances (n,) [m], rounded to 1, 2, 5 times a power of ten."""
    known = np.abs(distance[np.isfinite(distance)]) * 1000
    wanted = float(np.percentile(known, 95)) if len(known) else 1.0
    low = nice_length(max(wanted, 1e-3))
    half = next(step * low for step in (1, 2, 2.5, 5) if step * low >= wanted * (1 - 1e-9))
    return Scale(DIVERGING, -half, half, "signed distance [mm] (red: outside the reference, blue: inside)")


def shares(distance: Array) -> dict[float, float]:
    """Share of the known distances (n,) [m] whose size is at most 1, 2, 5 mm; NaN when none is known."""
    known = np.abs(distance[np.isfinite(distance)])
    return {limit: float(np.mean(known <= limit)) if len(known) else float("nan") for limit in WITHIN}


def distance_views(mesh: Mesh, distance: Array, sights: Sequence[Lit], within: dict[float, float]) -> Figure:
    """The mesh coloured by its signed distance (n,) [m]."""
    said = ", ".join(f"{share:.0%} within {limit * 1000:g} mm" for limit, share in within.items())
    scale = distance_scale(distance)
    text = Figure(f"Of the mesh, {said}", "distance", f"Mesh coloured by signed distance: {said}.", _CAPTION)
    row = ViewRow(mesh, scale_colors(distance * 1000, scale), sights=sights)
    return mesh_views([row], [sight.side for sight in sights], text, scale)


_CAPTION = (
    "Strongest colours: at or beyond the ends of the scale, which holds 95 % of the distances. Grey: no distance."
)


def histogram_figure(counts: Array, edges: Array, within: dict[float, float], median: float) -> Figure:
    """Histogram of the signed distances.

    Args:
        counts, edges: (k,) points per bin, (k + 1,) [m].
    """
    total = max(float(counts.sum()), 1.0)
    middle = (edges[:-1] + edges[1:]) / 2 * 1000
    title = f"The middle of the signed distances is {median * 1000:+.2f} mm" if np.isfinite(median) else "No distances"
    with styled():
        figure = new_figure(11.0, 3.4)
        ax = figure.subplots()
        for (limit, share), color in zip(reversed(within.items()), (ORANGE, GREEN, BLUE), strict=False):
            ax.axvspan(-limit * 1000, limit * 1000, color=color, alpha=0.1, linewidth=0)
            label = f"within {limit * 1000:g} mm: {share:.1%}" if np.isfinite(share) else "unknown"
            ax.axvline(-limit * 1000, color=color, linewidth=1)
            ax.axvline(limit * 1000, color=color, linewidth=1, label=label)
        ax.bar(middle, counts / total * 100, width=np.diff(edges) * 1000, color=GREY, linewidth=0)
        ax.axvline(0, color=INK, linewidth=0.8)
        ax.set_xlim(edges[0] * 1000, edges[-1] * 1000)
        ax.set_xlabel("signed distance to the reference [mm]")
        ax.set_ylabel("share per bin [%]")
        ax.legend(loc="upper right")
        svg = to_svg(figure, "histogram")
    alt = title + ". " + ", ".join(f"{s:.1%} within {m * 1000:g} mm" for m, s in within.items()) + "."
    return Figure(title, svg, alt, "Positive: outside the reference. The coloured bands hold the shares in the legend.")
