"""Draws the pictures of the effect pages: small, calm, and the same bytes every time."""

import io
import re
from collections import Counter
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.ticker import LogLocator, MultipleLocator, NullLocator

from fusion.sensor.effect import Effect
from fusion.sensor.parameter import Parameter, parameters
from tools.documentation.effect_pages.panel import LABELS, Panel, Picture

COLOR = {"bias": "#1d6996", "noise": "#d9731a", "dropout": "#a0336e", "light": "#b38600"}
MAPS = {
    "bias": ["#8a3b12", "#e6a15c", "#f7f7f7", "#6aa6c8", "#12476b"],
    "dropout": ["#ffffff", COLOR["dropout"]],
    "light": ["#3a3527", "#c79a2b", "#fff8dc"],
}
NUMBER = re.compile(r"-?\d+\.\d{3,}")
INK, FAINT, FADED = "#3b4252", "#8a93a3", 0.45
STYLE: dict[Any, Any] = {
    "svg.hashsalt": "effects",
    "svg.fonttype": "none",  # text stays text: small files, and it can be searched
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans", "Verdana", "Arial"],
    "font.size": 8.5,
    "axes.edgecolor": FAINT,
    "axes.labelcolor": INK,
    "axes.linewidth": 0.7,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.titlelocation": "left",
    "axes.titlesize": 8.5,
    "axes.titlecolor": INK,
    "grid.color": "#e4e8ee",
    "grid.linewidth": 0.7,
    "xtick.color": FAINT,
    "ytick.color": FAINT,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "legend.frameon": False,
    "legend.fontsize": 8.0,
    "text.color": INK,
    "lines.solid_capstyle": "round",
}
HEIGHT, WIDTHS = 2.9, {1: 4.6, 2: 7.4, 3: 9.6}  # [in]


def svg(kind: type[Effect], picture: Picture) -> bytes:
    """The picture of an effect as SVG."""
    with mpl.rc_context(STYLE):
        buffer = io.BytesIO()
        # no date and no version, so that the same laws give the same bytes
        _figure(kind, picture).savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    return _slim(buffer.getvalue().decode()).encode()


def _slim(text: str) -> str:
    """SVG of a third the size: hundredths of a point, shared styles, no comments, metadata or indentation."""
    text = re.sub(r"<!--.*?-->|<metadata>.*?</metadata>| transform=\"rotate\(-0[^\"]*\"", "", text, flags=re.DOTALL)
    text = re.sub(r"<[^>]*>", lambda tag: NUMBER.sub(_hundredths, tag[0]), text)
    styles = Counter(re.findall(r' style="([^"]*)"', text))
    often = [style for style, count in styles.items() if count > 2]
    for number, style in enumerate(often):
        text = text.replace(f' style="{style}"', f' class="c{number}"')
    rules = "".join(f".c{number}{{{style}}}\n" for number, style in enumerate(often))
    text = text.replace("</style>", f"\n{rules}</style>", 1)
    return "\n".join(line.strip() for line in text.splitlines() if line.strip()) + "\n"


def _hundredths(number: re.Match[str]) -> str:
    return f"{float(number[0]):.2f}".rstrip("0").rstrip(".")


def _figure(kind: type[Effect], picture: Picture) -> Figure:
    count = sum(1 + (panel.window is not None) for panel in picture.panels)
    figure = Figure((WIDTHS[count], HEIGHT), layout="constrained", facecolor="white")
    axes = iter(np.atleast_1d(figure.subplots(1, count)))
    for panel in picture.panels:
        full, half = (np.asarray(panel.law(picture.effect(kind, panel, f)), float) for f in (1.0, 0.5))
        if panel.window is not None:
            middle = full.shape[0] // 2
            _image(figure, next(axes), panel, full)
            full, half = full[middle], half[middle]
        ax = next(axes)
        _curves(ax, panel, (full, half))
        if panel.values:
            _legend(ax, kind, picture, panel)
    _legend(figure, kind, picture, picture.panels[0])
    return figure


def _curves(ax: Any, panel: Panel, curves: tuple[Any, Any]) -> None:
    label, factor = panel.label or LABELS[panel.channel]
    full, half = (factor * np.where(np.isfinite(y) & ~(panel.edge & (panel.x == 0)), y, np.nan) for y in curves)
    color, style = COLOR[panel.channel], {"drawstyle": "steps-mid" if panel.steps else "default"}
    points = {"marker": "o", "ms": 3, "mew": 0} if len(panel.x) < 20 else {}
    ax.plot(panel.x, half, color=color, lw=1.3, alpha=FADED, **style, **points)
    ax.plot(panel.x, full, color=color, lw=1.7, **style, **points)
    ax.set(xlabel=panel.x_label, ylabel=label, xlim=(panel.x[0], panel.x[-1]))
    if panel.log:
        ax.set_xscale("log")
        ax.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        ax.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
        ax.xaxis.set_minor_formatter(lambda value, _: "")
        ax.xaxis.set_minor_locator(NullLocator())
    elif panel.x[-1] == 360:
        ax.xaxis.set_major_locator(MultipleLocator(90))
    _limits(ax, np.concatenate([full, half]))
    if panel.edge:
        ax.axvspan(panel.x[0], 0.0, color="#f1f3f6", lw=0, zorder=0)
        for place, side in ((0.02, "near side"), (0.98, "far side")):
            ax.text(place, 0.8, side, transform=ax.transAxes, ha="left" if place < 0.5 else "right", color=FAINT)
    ax.set_title("along the dashed line" if panel.window is not None else panel.note, color=FAINT)


def _limits(ax: Any, values: Any) -> None:
    """Zero is always in sight, with a thin line when it is inside."""
    low, high = min(np.nanmin(values), 0.0), max(np.nanmax(values), 0.0)
    room = 0.07 * (high - low)
    ax.set_ylim(low - room * (low < 0), high + room)
    if low < 0:
        ax.axhline(0.0, color=FAINT, lw=0.8, zorder=1)


def _image(figure: Figure, ax: Any, panel: Panel, values: Any) -> None:
    assert panel.window is not None
    label, factor = panel.label or LABELS[panel.channel]
    values = factor * values
    most = np.nanpercentile(np.abs(values), 99.5)
    low, high = {"bias": (-most, most), "dropout": (0.0, 100.0)}.get(panel.channel, (values.min(), values.max()))
    colors = LinearSegmentedColormap.from_list("own", MAPS[panel.channel])
    rows, columns = (np.arange(size)[part] for size, part in zip((480, 640), panel.window, strict=True))
    half = (columns[1] - columns[0]) / 2
    extent = (columns[0] - half, columns[-1] + half, rows[-1] + half, rows[0] - half)
    shown = ax.imshow(values, cmap=colors, vmin=low, vmax=high, extent=extent, interpolation="none")
    if panel.outline:
        left, top, right, bottom = panel.outline
        ax.add_patch(Rectangle((left, top), right - left, bottom - top, fill=False, edgecolor=FAINT, lw=0.9))
    ax.axhline(rows[len(rows) // 2], color=INK, lw=0.8, ls=(0, (4, 3)))
    ax.set(xticks=[], yticks=[], xlim=extent[:2], ylim=extent[2:])
    ax.grid(False)
    ax.spines[:].set_visible(True)
    ax.set_title(panel.note, color=FAINT)
    bar = figure.colorbar(shown, ax=ax, location="right", shrink=0.75, pad=0.02, aspect=22)
    bar.outline.set_visible(False)
    bar.ax.tick_params(length=2)
    bar.ax.set_title(label[label.index("[") + 1 : -1], fontsize=8.0, color=FAINT, loc="left")


def _legend(where: Any, kind: type[Effect], picture: Picture, panel: Panel) -> None:
    """Below the whole figure, or inside axes with values of their own."""
    channels = {own.channel for own in picture.panels}
    color = COLOR[panel.channel] if len(channels) == 1 or panel.values else INK
    lines = [Line2D([], [], color=color, lw=1.7), Line2D([], [], color=color, lw=1.3, alpha=FADED)]
    place = "best" if panel.values else "outside lower left"
    where.legend(lines, _names(kind, picture, panel), loc=place, ncols=1 if panel.values else 2, handlelength=1.6)


def _names(kind: type[Effect], picture: Picture, panel: Panel) -> tuple[str, str]:
    """What the two curves are: the value where one parameter is halved."""
    if len(picture.halved) != 1 or picture.make is not None:
        return "typical values", "half of them"
    about = parameters(kind)[picture.halved[0]]
    value = panel.values.get(about.name, about.typical)
    return f"{about.label} {_value(about, value)}", _value(about, value / 2)


def _value(about: Parameter, value: float) -> str:
    """A value with its unit; small lengths and times in mm, ms and us."""
    unit = about.unit
    if unit in ("m", "s") and abs(value) < 0.1:
        value, unit = (1000 * value, "m" + unit) if abs(value) >= 1e-4 or unit == "m" else (1e6 * value, "us")
    number = f"{value:.4g}" if abs(value) < 1e4 else f"{value:,.0f}".replace(",", " ")
    return number if unit == "1" else f"{number} {unit}"
