"""Colours and style of every figure, and the way from matplotlib to inline SVG that follows light and dark pages."""

import base64
import io
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from threading import RLock
from typing import TYPE_CHECKING, Any

import matplotlib

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# M. Okabe, K. Ito: Color Universal Design (2008): told apart with every common colour blindness
BLUE, ORANGE, GREEN, RED, PURPLE, SKY = "#0072b2", "#e69f00", "#009e73", "#d55e00", "#cc79a7", "#56b4e9"
GREY = "#8b94a3"

# these exact colours become the page's own in the SVG, so that text and grid follow light and dark
INK, SOFT, GRID = "#1c2330", "#5b6575", "#d8dde5"
_THEMED = {INK: "ink", SOFT: "soft", GRID: "grid"}

PIXELS = 160  # an inch, of pictures in figures
SEQUENTIAL, DIVERGING = "viridis", "RdBu_r"

STYLE: Any = {
    "figure.facecolor": "none",
    "axes.facecolor": "none",
    "savefig.facecolor": "none",
    "font.family": "DejaVu Sans",  # ships with matplotlib, and is wider than what browsers put in its place
    "font.size": 9.5,
    "text.color": INK,
    "text.parse_math": False,  # a dollar sign in a file name is no formula
    "axes.titlesize": 10,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.titlepad": 8,
    "axes.labelcolor": SOFT,
    "axes.edgecolor": GRID,
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": GRID,
    "grid.linewidth": 0.6,
    "xtick.color": GRID,
    "ytick.color": GRID,
    "xtick.labelcolor": SOFT,
    "ytick.labelcolor": SOFT,
    "legend.frameon": False,
    "legend.fontsize": 9,
    "lines.linewidth": 1.6,
    "svg.fonttype": "none",  # text stays text: small, sharp, can be searched
    "image.composite_image": False,
}


# matplotlib has one style for the whole process: two threads that set it back in the wrong order would leave ours
_drawing = RLock()


@contextmanager
def styled(more: Mapping[str, object] | None = None) -> Iterator[None]:
    """Everything drawn inside the block has the house style, and more settings; one thread draws at a time."""
    with _drawing, matplotlib.rc_context(STYLE | dict(more or {})):
        yield


def new_figure(width: float, height: float) -> "Figure":
    """An empty figure [inch] without a window; call inside `styled()`."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout="constrained")


def to_svg(figure: "Figure", name: str, photos: bool = False) -> str:
    """Inline SVG of a figure; `name` makes its ids unique on the page (letters, digits and dashes).

    `photos` are pictures to look at and not to measure in: they are kept as WebP, a sixth of the size.
    """
    from matplotlib.backends.backend_svg import FigureCanvasSVG

    buffer = io.BytesIO()
    with styled({"svg.hashsalt": name}):
        figure.dpi = PIXELS
        # what `savefig` does after it has drawn everything once for nothing
        FigureCanvasSVG(figure).print_svg(buffer, metadata={"Date": None, "Creator": None})
    svg = buffer.getvalue().decode()
    svg = svg[svg.index("<svg") :]
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg, flags=re.S)
    if photos:
        svg = re.sub(r"data:image/png;base64,([^\"]*)", _webp, svg)
    svg = re.sub(r'(<image\b[^>]*?) id="[^"]*"', r"\1", svg)  # from its content: twice for the same picture
    svg = re.sub(r'\bid="', f'id="{name}-', svg)
    svg = re.sub(r'(href="#|url\(#)', rf"\g<1>{name}-", svg)
    for color in _THEMED:
        svg = re.sub(rf"(fill|stroke): {color}", rf"\g<1>: {themed(color)}", svg)
    return svg


def _webp(png: re.Match[str]) -> str:
    """A picture in an SVG, from PNG to WebP."""
    from PIL import Image  # comes with matplotlib

    out = io.BytesIO()
    webp(Image.open(io.BytesIO(base64.b64decode(png[1]))), out)
    return "data:image/webp;base64," + base64.b64encode(out.getvalue()).decode()


def webp(image: Any, out: io.BytesIO) -> None:
    """Write a picture (of PIL) as WebP."""
    # measured on a scan's views: 3.8 MB as PNG, 2.4 without loss, 0.5 at quality 90, where no difference is seen;
    # looking longer for a smaller file (method 4) takes twice as long for 5 %
    image.save(out, "WEBP", quality=90, method=2)


def themed(color: str) -> str:
    """One of the page's own colours as a style says it; others as they are."""
    return f"var(--{_THEMED[color]}, {color})" if color in _THEMED else color
