"""How well a model fits: chi2 per recording before and after, and leftovers against pure noise."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.stats import norm

from fusion.report.kit.page import Figure
from fusion.report.kit.palette import BLUE, GREY, INK, ORANGE, new_figure, styled, to_svg

Array = NDArray[np.floating]

WIDEST = 5.0  # standard deviations shown


def recordings_figure(recordings: Sequence[tuple[str, float, float]], changed: bool, text: Figure) -> Figure:
    """Chi2 per degree of freedom of each recording (name, before, after) as bars, with 1 = noise alone marked."""
    names, before, after = zip(*recordings, strict=True)
    place = np.arange(len(names))
    with styled():
        figure = new_figure(11.0, 3.2)
        ax = figure.subplots()
        width = 0.4 if changed else 0.7
        if changed:
            ax.bar(place - 0.2, before, width, color=ORANGE, label="model as given")
        ax.bar(place + (0.2 if changed else 0), after, width, color=BLUE, label="model extended" if changed else "")
        ax.axhline(1, color=INK, linewidth=1, linestyle=(0, (4, 3)), label="noise alone")
        if max(before) > 20:
            ax.set_yscale("log")
            ax.yaxis.set_major_formatter(lambda value, _: f"{value:g}")  # powers of ten would be formulas
            ax.yaxis.set_minor_formatter(lambda value, _: "")
        ax.set_xticks(place, names, rotation=0 if len(names) <= 12 else 60)
        ax.grid(axis="x", visible=False)
        ax.set_ylabel("chi2 per degree of freedom")
        ax.legend(loc="upper left", bbox_to_anchor=(1, 1))
        return Figure(text.title, to_svg(figure, text.svg), text.alt, text.caption)


def noise_figure(white: Array, text: Figure) -> Figure:
    """Histogram of residuals (n,) in standard deviations against the normal curve."""
    edges = np.linspace(-WIDEST, WIDEST, 51)
    counts = np.histogram(np.clip(white, -WIDEST, WIDEST), edges)[0]
    with styled():
        figure = new_figure(11.0, 3.2)
        ax = figure.subplots()
        ax.bar(edges[:-1], counts, np.diff(edges), align="edge", color=GREY, alpha=0.7, label="recorded")
        ax.plot(x := np.linspace(-WIDEST, WIDEST, 201), norm.pdf(x) * len(white) * (edges[1] - edges[0]),
                color=BLUE, label="noise alone")  # fmt: skip
        ax.set_xlabel("residual of a tile in standard deviations of what is known")
        ax.set_ylabel("tiles")
        ax.legend(loc="upper right")
        return Figure(text.title, to_svg(figure, text.svg), text.alt, text.caption)
