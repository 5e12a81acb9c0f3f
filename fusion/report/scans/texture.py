"""The report of a texture: the textured mesh beside the photographs that it was made of."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.report.kit.page import Figure, Number, Page, Section, write_page
from fusion.report.kit.palette import SOFT, new_figure, styled, to_svg
from fusion.texture.shown import PhotoPair, beside_photographs
from fusion.texture.textured import Textured

SHOWN = 4  # photographs
LONGEST = 800  # [px] of a picture's longer side: more is not seen


@dataclass(frozen=True)
class TextureReport:
    """What the page shows."""

    made: Textured  # the textured mesh
    subtitle: str = ""  # of what
    settings: Mapping[str, object] = field(default_factory=dict)  # nested
    command: str = ""  # the command line


def texture_report(path: Path, report: TextureReport) -> None:
    """Write `report.html` of a texture."""
    made, pairs = report.made, list(beside_photographs(report.made, SHOWN))
    page = Page(
        title="A mesh with its colours",
        subtitle=report.subtitle,
        numbers=_numbers(made),
        sections=[
            Section("Beside photographs", figures=(_beside(pairs),) if pairs else ()),
            Section("The picture on it", folded=(_atlas(made),)),
        ],
        settings=report.settings,
        command=report.command,
    )
    write_page(path, page)


def _numbers(made: Textured) -> list[Number]:
    h, w = made.image.shape[:2]
    return [
        Number("Photographs used", str(made.images)),
        Number("Texel", f"{1e3 * made.texel:.2f}", "mm", f"{w} x {h} of them"),
        Number("Triangles", f"{len(made.mesh.faces):,}", "", f"{1e3 * made.moved[0]:.2f} mm rms off the scan"),
        Number("Seen by no photograph", f"{made.unseen_share:.1%}", "", "in the colours around"),
    ]


def _beside(pairs: Sequence[PhotoPair]) -> Figure:
    frames = ", ".join(str(pair.frame) for pair in pairs)
    title = "The textured mesh from where photographs were taken"
    alt = f"Above, the photographs of frames {frames}; below, the textured mesh from the same places."
    caption = (
        "Above photographs, below the textured mesh from the same places, in the light that stood still while the "
        "object turned. It was made of these photographs too; how well it foretells others: "
        "`python -m tools.reproduce.scans.texture_held_out`. The picture itself holds one colour for a place, without "
        "that light; cast shadows and gloss are in the photographs alone."
    )
    height, width = (max(pair.shown.shape[axis] for pair in pairs) for axis in (0, 1))
    with styled():
        across = 11.0 / max(len(pairs), 2)
        figure = new_figure(across * len(pairs), 2 * across * min(height / width, 1.6) + 0.4)
        grid = figure.subplots(2, len(pairs), squeeze=False)
        for pair, (above, below) in zip(pairs, grid.T, strict=True):
            room = (height, width)
            _show(above, _rgba(pair.photograph, np.ones(pair.shown.shape, bool), room), f"frame {pair.frame}")
            _show(below, _rgba(pair.texture, pair.shown, room), "texture")
        return Figure(title, to_svg(figure, "beside", photos=True), alt, caption)


def _atlas(made: Textured) -> Figure:
    h, w = made.image.shape[:2]
    with styled():
        figure = new_figure(6.5, 6.5 * h / w + 0.2)
        _show(figure.subplots(), _rgba(made.image, np.ones((h, w), bool), (h, w)), "")
        text = "The surface laid flat: the picture of textured.png"
        return Figure(text, to_svg(figure, "atlas", photos=True), text)


def _rgba(colors: NDArray[np.uint8], there: NDArray[np.bool_], room: tuple[int, int]) -> NDArray[np.uint8]:
    """(h, w, 4) a picture amid a room for the largest one, clear where there is nothing, no larger than it is shown."""
    whole = np.zeros((*room, 4), np.uint8)
    v, u = ((most - own) // 2 for most, own in zip(room, there.shape, strict=True))
    part = whole[v : v + there.shape[0], u : u + there.shape[1]]
    part[..., :3], part[..., 3] = colors, np.where(there, 255, 0)
    smaller = LONGEST / max(room)
    if smaller < 1:
        whole = np.asarray(cv2.resize(whole, None, fx=smaller, fy=smaller, interpolation=cv2.INTER_AREA), np.uint8)
    return whole


def _show(ax, rgba: NDArray[np.uint8], label: str) -> None:
    ax.imshow(rgba, interpolation="nearest")
    ax.set_axis_off()
    ax.set_title(label, color=SOFT, fontsize=9.5, fontweight="normal", loc="center")
