"""A mesh from several sides at one scale, with a scale bar [mm].

The SVG is written here: pictures, words and a bar need no plotting library, which took four fifths of the time.
"""

import base64
import io
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from html import escape

import numpy as np
from numpy.typing import NDArray

from fusion.mesh.drawing.shading import CLAY, Lit, lit, picture, vertex_normals
from fusion.mesh.drawing.sight import SightSide, look_around
from fusion.mesh.mesh import Mesh
from fusion.report.kit.page import Figure
from fusion.report.kit.palette import INK, SOFT, themed, webp

PIXELS = 420  # of the mesh's longest edge in a view; looked at with twice as many
WIDE, TALL = 792.0, 864.0  # of the figure, and at most of its pictures; as all below in 1/72 inch
BETWEEN, NAME, BAR, SCALE = 8.0, 20.0, 26.0, 44.0  # gap between views, room for names, scale bar and colour scale
FONT = 9.5
DRAWING = 2  # threads: NumPy and WebP leave Python's lock alone, and memory feeds no more of them


@dataclass(frozen=True)
class Scale:
    """How numbers become colours: matplotlib's colour map, the values at its ends, what the bar says."""

    cmap: str
    low: float
    high: float
    label: str


@dataclass(frozen=True)
class ViewRow:
    """One row of views: the mesh, its vertex colours (n, 3) 0 to 1 (None: clay), what it is called, and, where it is
    shown again, what `seen_alone` gave for it."""

    mesh: Mesh
    colors: NDArray | None = None
    name: str = ""
    sights: Sequence[Lit] | None = None


@dataclass(frozen=True)
class _Picture:
    """Width and height [px], and the WebP file in base64; "" where nothing is seen."""

    width: int
    height: int
    data: str = ""


def mesh_views(rows: Sequence[ViewRow], sides: list[SightSide], text: Figure, scale: Scale | None = None) -> Figure:
    """Rows of views, all at the same scale.

    Args:
        rows: what to show, at the scale of what `seen_alone` gave for one of them; a row with an empty mesh says so.
        text: title, alt and caption; its svg is "name" for the ids inside the picture.
    """
    looked = next((row.sights for row in rows if row.sights), None)
    pixel = looked[0].sight.pixel if looked else pixel_of([row.mesh for row in rows])
    pictures = _pictures(rows, sides, pixel)
    widths = [max(p.width for p in column) for column in zip(*pictures, strict=True)]
    heights = [max(p.height for p in line) for line in pictures]
    unit = min((WIDE - BETWEEN * (len(sides) - 1)) / sum(widths), TALL / sum(heights))  # edge of a picture's pixel
    parts, top = [], 0.0
    for row, line, room in zip(rows, pictures, heights, strict=True):
        left = (WIDE - BETWEEN * (len(sides) - 1) - unit * sum(widths)) / 2
        for place, (side, shown, width) in enumerate(zip(sides, line, widths, strict=True)):
            label = f"{row.name}, {side.name}" if row.name and place == 0 else side.name
            parts.append(_words(left + unit * width / 2, top + 14, label, SOFT))
            parts.append(_image(shown, (left, top + NAME, unit * width, unit * room), unit))
            left += unit * width + BETWEEN
        top += NAME + unit * room
    left = (WIDE - BETWEEN * (len(sides) - 1) - unit * sum(widths)) / 2
    parts.append(_scale_bar(left, top + 8, widths[0] * unit, 2 * pixel / unit))
    top += BAR
    if scale:
        parts.append(_color_bar(top, scale, f"{text.svg}-scale"))
        top += SCALE
    head = f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDE:g}pt" height="{top:.1f}pt"'
    svg = f'{head} viewBox="0 0 {WIDE:g} {top:.1f}" version="1.1">\n' + "\n".join(parts) + "\n</svg>\n"
    return Figure(text.title, svg, text.alt, text.caption)


def seen_alone(mesh: Mesh, sides: list[SightSide]) -> list[Lit]:
    """What `mesh_views` looks at for this mesh: several figures of it share the work, and its scale."""
    return _lit(mesh, sides, pixel_of([mesh]))


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


def pixel_of(meshes: list[Mesh]) -> float:
    """Edge [m] of a looked-at pixel that fits the largest mesh."""
    longest = 0.0
    for mesh in meshes:
        points = mesh.vertices[np.isfinite(mesh.vertices).all(axis=1)]
        longest = max([longest, *(np.ptp(points, axis=0).tolist() if len(points) else [])])
    return longest / (2 * PIXELS) if longest > 0 else 1e-3


def _pictures(rows: Sequence[ViewRow], sides: list[SightSide], pixel: float) -> list[list[_Picture]]:
    """A line of pictures for each row; what several rows show in different colours is looked at once."""
    sights: dict[int, Sequence[Lit]] = {}
    for row in rows:
        if id(row.mesh) not in sights:
            sights[id(row.mesh)] = row.sights or _lit(row.mesh, sides, pixel)
    with ThreadPoolExecutor(DRAWING) as pool:
        lines = [[pool.submit(_picture, row, seen) for seen in sights[id(row.mesh)]] for row in rows]
        return [[drawn.result() for drawn in line] for line in lines]


def _lit(mesh: Mesh, sides: list[SightSide], pixel: float) -> list[Lit]:
    with ThreadPoolExecutor(DRAWING) as pool:
        return list(pool.map(partial(lit, normals=vertex_normals(mesh)), look_around(mesh, sides, pixel)))


def _picture(row: ViewRow, seen: Lit) -> _Picture:
    from PIL import Image  # comes with matplotlib

    rgba = picture(seen, row.colors)
    height, width = rgba.shape[:2]
    if not rgba[..., 3].any():
        return _Picture(width, height)
    buffer = io.BytesIO()
    webp(Image.fromarray(rgba), buffer)
    return _Picture(width, height, base64.b64encode(buffer.getvalue()).decode())


def _image(shown: _Picture, box: tuple[float, float, float, float], unit: float) -> str:
    """A picture that stands on the bottom of its box (left, top, width, height), in the middle."""
    left, top, wide, tall = box
    if not shown.data:
        return _words(left + wide / 2, top + tall / 2, "empty", SOFT)
    width, height = unit * shown.width, unit * shown.height
    place = (
        f'x="{left + (wide - width) / 2:.2f}" y="{top + tall - height:.2f}" width="{width:.2f}" height="{height:.2f}"'
    )
    return f'<image {place} href="data:image/webp;base64,{shown.data}"/>'


def _words(x: float, y: float, text: str, color: str) -> str:
    """Text about the middle x, on the line y."""
    style = f"font: {FONT}px 'DejaVu Sans'; text-anchor: middle; fill: {themed(color)}"
    return f'<text x="{x:.2f}" y="{y:.2f}" style="{style}">{escape(text)}</text>'


def _scale_bar(left: float, y: float, width: float, size: float) -> str:
    """A bar below the first picture, at most 60 % of its width; `size`: what 1/72 inch shows [m]."""
    length = nice_length(0.6 * width * size * 1000)  # [mm]
    end = left + length / 1000 / size
    line = f'<path d="M {left:.2f} {y:.2f} H {end:.2f}" style="stroke: {themed(INK)}; stroke-width: 2.2; fill: none"/>'
    return line + _words((left + end) / 2, y + 13, f"{length:g} mm", INK)


def _color_bar(top: float, scale: Scale, name: str) -> str:
    """What the colours stand for: half as wide as the figure, in its middle; `name` is its id."""
    left, wide = WIDE / 4, WIDE / 2
    colors = np.rint(scale_colors(np.linspace(scale.low, scale.high, 33), scale) * 255).astype(int)
    stops = "".join(f'<stop offset="{n / 32:g}" stop-color="rgb({r},{g},{b})"/>' for n, (r, g, b) in enumerate(colors))
    parts = [f'<linearGradient id="{name}">{stops}</linearGradient>']
    parts.append(f'<rect x="{left:g}" y="{top + 4:.2f}" width="{wide:g}" height="9" fill="url(#{name})"/>')
    step = nice_length((scale.high - scale.low) / 3.5)
    first, last = np.ceil(scale.low / step - 1e-6), np.floor(scale.high / step + 1e-6)
    for value in step * np.arange(first, last + 1) + 0.0:  # which makes 0 of -0
        x = left + wide * (value - scale.low) / max(scale.high - scale.low, 1e-12)
        parts.append(_words(x, top + 25, f"{value:.6g}".replace("-", "\u2212"), SOFT))
    parts.append(_words(WIDE / 2, top + 39, scale.label, SOFT))
    return "".join(parts)
