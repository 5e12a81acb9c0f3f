"""How often each part of the surface was seen, and from which directions around the axis."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from fusion.geometry.pose import Array
from fusion.mesh.drawing.shading import Lit
from fusion.mesh.mesh import Mesh
from fusion.report.kit.page import Figure
from fusion.report.kit.palette import BLUE, SEQUENTIAL, new_figure, styled, to_svg
from fusion.report.kit.views import Scale, ViewRow, mesh_views, scale_colors
from fusion.report.scans.circle import Cylinder

THIN = 3  # a patch seen in fewer frames rests on single measurements (guess)


def coverage_scale(times_seen: Array) -> Scale:
    """Colours from never to the 98th percentile, so that a few favoured spots do not darken the rest."""
    known = times_seen[np.isfinite(times_seen)]
    high = float(np.percentile(known, 98)) if len(known) else 1.0
    return Scale(SEQUENTIAL, 0.0, max(high, 1.0), "frames that saw the surface")


def coverage_figure(mesh: Mesh, times_seen: Array, sights: Sequence[Lit]) -> Figure:
    """The mesh, seen from several sides, coloured by the number of frames (n,) that saw each vertex."""
    known = times_seen[np.isfinite(times_seen)]
    thin = float(np.mean(known < THIN)) if len(known) else float("nan")
    middle = float(np.median(known)) if len(known) else float("nan")
    title = f"Half of the surface was seen in {middle:.0f} frames or more; {thin:.0%} in fewer than {THIN}"
    scale = coverage_scale(times_seen)
    text = Figure(title, "coverage", title + ".", "Dark: seldom seen. Grey: unknown.")
    row = ViewRow(mesh, scale_colors(times_seen, scale), sights=sights)
    return mesh_views([row], [sight.side for sight in sights], text, scale)


def azimuth_figure(centres: Cylinder) -> Figure:
    """Number of frames per direction around the axis, as a polar plot.

    Args:
        centres: corrected camera centres about the axis.
    """
    azimuth = centres.azimuth[np.isfinite(centres.azimuth)] % (2 * np.pi)
    sorted_ = np.sort(azimuth)
    gap = float(np.degrees(np.diff(np.append(sorted_, sorted_[0] + 2 * np.pi)).max())) if len(sorted_) else 360.0
    title = f"Largest gap around the object: {gap:.1f} deg"
    bins = 24
    counts, edges = np.histogram(azimuth, bins=bins, range=(0, 2 * np.pi))
    most = max(int(np.max(counts)), 1)
    with styled():
        figure = new_figure(5.2, 3.9)
        ax: Any = figure.add_subplot(projection="polar")
        ax.bar(edges[:-1], counts, width=np.diff(edges) * 0.92, align="edge", color=BLUE, alpha=0.85)
        ax.plot(azimuth, np.full(len(azimuth), most * 1.08), "|", color=BLUE, markersize=5)
        ax.set_rmax(most * 1.15)
        ax.set_yticks(sorted({int(x) for x in np.linspace(1, most, 3)}))
        ax.set_rlabel_position(100)
        ax.set_xticks(np.radians(np.arange(0, 360, 45)), [f"{d} deg" for d in range(0, 360, 45)])
        ax.spines["polar"].set_visible(False)
        svg = to_svg(figure, "azimuth")
    caption = f"Frames per {360 // bins} deg around the axis; 0 deg is the first frame, which sees the front."
    return Figure(title, svg, title + ".", caption)
