"""A mesh from several sides at one scale, with a scale bar [mm]."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.mesh.mesh import Mesh
from fusion.mesh.shading import CLAY, picture, vertex_normals
from fusion.mesh.sight import Side, Sight, look_around
from fusion.report.page import Figure
from fusion.report.palette import INK, SOFT, new_figure, styled, to_svg

PIXELS = 420  # of the mesh's longest edge in a view; looked at with twice as many


@dataclass(frozen=True)
class Scale:
    """How numbers become colours: matplotlib's colour map, the values at its ends, what the bar says."""

    cmap: str
    low: float
    high: float
    label: str


@dataclass(frozen=True)
class Row:
    """One row of views: the mesh, its vertex colours (n, 3) 0 to 1 (None: clay), what it is called, and, where it is
    shown again, what `seen_alone` gave for it."""

    mesh: Mesh
    colors: NDArray | None = None
    name: str = ""
    sights: Sequence[Sight] | None = None


def mesh_views(rows: Sequence[Row], sides: list[Side], text: Figure, scale: Scale | None = None) -> Figure:
    """Rows of views, all at the same scale.

    Args:
        rows: what to show; a row with an empty mesh says so.
        sides: from where, one column each.
        text: title, alt and caption; its svg is "name" for the ids inside the picture.
        scale: adds a colour bar.
    """
    pixel = _pixel([row.mesh for row in rows])
    pictures = _pictures(rows, sides, pixel)
    widths = [max(p.shape[1] for p in column) for column in zip(*pictures, strict=True)]
    heights = [max(p.shape[0] for p in line) for line in pictures]
    inch = 11.0 / max(sum(widths), 1)
    with styled():
        height = float(np.clip(sum(heights) * inch + 0.35 * len(rows) + 0.35 + (0.5 if scale else 0), 1.5, 12))
        figure = new_figure(11.0, height)
        grid = figure.subplots(
            len(rows), len(sides), squeeze=False, gridspec_kw={"width_ratios": widths, "height_ratios": heights}
        )
        for row, line, axes, room in zip(rows, pictures, grid, heights, strict=True):
            for place, (side, rgba, ax) in enumerate(zip(sides, line, axes, strict=True)):
                label = f"{row.name}, {side.name}" if row.name and place == 0 else side.name
                _show(ax, rgba, label, room)
        _scale_bar(grid[-1][0], heights[-1], 2 * pixel, widths[0])
        for ax in grid[-1]:
            ax.set_ylim(heights[-1] * 1.03 + 6, 0)
        if scale:
            _color_bar(figure, grid, scale)
        return Figure(text.title, to_svg(figure, text.svg, photos=True), text.alt, text.caption)


def seen_alone(mesh: Mesh, sides: list[Side]) -> list[Sight]:
    """What `mesh_views` looks at for this mesh alone: several figures of it share the work."""
    return look_around(mesh, sides, _pixel([mesh]))


def scale_colors(values: NDArray, scale: Scale) -> NDArray[np.float64]:
    """Colours (n, 3) of values (n,); clay where a value is missing."""
    import matplotlib

    known = np.isfinite(values)
    share = (np.where(known, values, scale.low) - scale.low) / max(scale.high - scale.low, 1e-12)
    colors = matplotlib.colormaps[scale.cmap](np.clip(share, 0, 1))[:, :3]
    colors[~known] = CLAY
    return colors


def nice_length(length: float) -> float:
    """The largest of 1, 2, 5 times a power of ten that is not above a length."""
    if not (np.isfinite(length) and length > 0):
        return 1.0
    power = 10.0 ** np.floor(np.log10(length))
    return float(power * max(step for step in (1, 2, 5) if step * power <= length * (1 + 1e-9)))


def _pixel(meshes: list[Mesh]) -> float:
    """Edge [m] of a looked-at pixel that fits the largest mesh."""
    longest = 0.0
    for mesh in meshes:
        points = mesh.vertices[np.isfinite(mesh.vertices).all(axis=1)]
        longest = max([longest, *(np.ptp(points, axis=0).tolist() if len(points) else [])])
    return longest / (2 * PIXELS) if longest > 0 else 1e-3


def _pictures(rows: Sequence[Row], sides: list[Side], pixel: float) -> list[list[NDArray[np.uint8]]]:
    """A line of pictures for each row; what several rows show in different colours is looked at once."""
    sights: dict[int, Sequence[Sight]] = {}
    for row in rows:
        if id(row.mesh) not in sights:
            sights[id(row.mesh)] = row.sights or look_around(row.mesh, sides, pixel)
    return [[_picture(row, sight) for sight in sights[id(row.mesh)]] for row in rows]


def _picture(row: Row, sight: Sight) -> NDArray[np.uint8]:
    colors = np.broadcast_to(CLAY, (len(row.mesh.vertices), 3)) if row.colors is None else row.colors
    return picture(sight, vertex_normals(row.mesh), colors)


def _show(ax, rgba: NDArray[np.uint8], label: str, room: int) -> None:
    """A picture that stands on the bottom of its row, which is `room` pixels high."""
    height, width = rgba.shape[:2]
    ax.imshow(rgba, interpolation="none", extent=(0, width, room, room - height))
    ax.set_ylim(room, 0)
    ax.set_axis_off()
    ax.set_title(label, color=SOFT, fontsize=9.5, fontweight="normal", loc="center")
    if not rgba[..., 3].any():
        ax.text(0.5, 0.5, "empty", transform=ax.transAxes, ha="center", color=SOFT)


def _scale_bar(ax, height: int, pixel: float, width: int) -> None:
    """A bar below the picture, at most 60 % of its width."""
    length = nice_length(0.6 * width * pixel * 1000)  # [mm]
    y = height * 1.03 + 4
    ax.plot([0, length / 1000 / pixel], [y, y], color=INK, linewidth=2.2, solid_capstyle="butt", clip_on=False)
    ax.annotate(
        f"{length:g} mm", (length / 2000 / pixel, y), (0, -5), textcoords="offset points", ha="center", va="top",
        fontsize=9, annotation_clip=False,
    )  # fmt: skip


def _color_bar(figure, grid, scale: Scale) -> None:
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    paint = ScalarMappable(Normalize(scale.low, scale.high), scale.cmap)
    bar = figure.colorbar(paint, ax=list(grid.flat), location="bottom", shrink=0.5, aspect=45, pad=0.03)
    bar.outline.set_visible(False)
    bar.set_label(scale.label)
