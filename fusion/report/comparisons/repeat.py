"""The page of scans that were repeated: how far they spread and where, and one table of planes, spheres and scans."""

from pathlib import Path

import numpy as np

from fusion.geometry.pose import Array
from fusion.mesh.drawing.sight import sides
from fusion.mesh.mesh import Mesh
from fusion.repeatability.repeat import Repeat
from fusion.repeatability.spread import SPREAD
from fusion.report.kit.page import Figure, Number, Page, Section, write_page
from fusion.report.kit.tables import numbers_table, paragraph
from fusion.report.kit.viewer import Layer, script, value_layer, viewer
from fusion.report.kit.views import Scale, ViewRow, mesh_views, scale_colors
from fusion.report.scans.sure import sigma_scale
from fusion.results.repeat import judge_repeat, scaled

UP, FRONT = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])
CAPTION = (
    "Standard deviation of the scans about their mean, along the normal, where two or more show the surface. "
    "Grey: fewer. The poses were fitted to each other: what a scan gets wrong as a whole is not in it."
)


def repeat_report(path: Path, found: Repeat, command: str, settings: dict[str, object]) -> None:
    """Write `report.html`."""
    mean, spread = found.mean, np.asarray(found.mean.scalars[SPREAD], float)
    known = bool(np.isfinite(spread).any())
    layers = [value_layer("Spread", 1000 * spread, _scale(spread))] if known else []
    page = Page(
        title=f"{len(found.names)} scans of one object",
        subtitle=", ".join(found.names),
        summary=judge_repeat(found).lights,
        numbers=_numbers(found),
        sections=[
            Section("Spread", figures=(_picture(mean, spread, found.repeatability.s),) if known else ()),
            viewer(mean, [*layers, Layer("Shape")], UP, FRONT),
            Section("Planes and spheres", _LEAD, html=_features(found)),
            Section("Scans", html=_scans(found)),
        ],
        settings=settings,
        command=command,
        script=script(),
    )
    write_page(path, page)


_LEAD = (
    "Terms of VDI/VDE 2634: forms by least squares with a free radius, three of a thousand points left out. Flatness "
    "and probing error form are the width of the band that holds the points."
)


def _scale(spread: Array) -> Scale:
    scale = sigma_scale(spread)
    return Scale(scale.cmap, scale.low, scale.high, "standard deviation between the scans [mm]")


def _picture(mean: Mesh, spread: Array, s: float) -> Figure:
    scale = _scale(spread)
    title = f"The scans repeat to {1e3 * s:.2f} mm (one standard deviation, over the whole surface)"
    row = ViewRow(mean, scale_colors(1000 * spread, scale))
    return mesh_views([row], sides(UP, FRONT), Figure(title, "spread", title + ".", CAPTION), scale)


def _numbers(found: Repeat) -> list[Number]:
    within, across = found.repeatability, found.reproducibility
    std = f"+- {1e3 * within.s_std:.3f} mm, from leaving out one scan" if np.isfinite(within.s_std) else ""
    numbers = [
        Number("Repeatability s_r", f"{1e3 * within.s:.3f}", "mm", std),
        Number("Limit r", f"{2.8e3 * within.s:.3f}", "mm", "two scans differ by more in 5 % of the cases"),
        Number("95 % spread by less than", f"{1e3 * within.p95:.3f}", "mm"),
    ]
    if across is not None:
        note = f"between {across.conditions} conditions {1e3 * across.between:.3f} mm"
        numbers.append(Number("Reproducibility s_R", f"{1e3 * across.s:.3f}", "mm", note))
    return numbers


def _features(found: Repeat) -> str:
    if not found.features.quantities:
        return paragraph("No planes and no spheres were found on this object.")
    rows = []
    for quantity in found.features.quantities:
        mean, std, unit = scaled(quantity)
        error = "-" if quantity.error is None else f"{1e3 * quantity.error:+.3f}"
        spread = f"{std:.3f}" if np.isfinite(std) else "-"  # one scan shows it
        count = f"{int(np.isfinite(quantity.values).sum())}"
        rows.append([f"{quantity.name}, {quantity.term} [{unit}]", f"{mean:.3f}", spread, error, count])
    return numbers_table(["what", "mean", "std", "error", "scans"], rows)


def _scans(found: Repeat) -> str:
    rows = []
    for row in found.offsets():
        told = (row.mean_m, row.rms_m, row.off_others_m, row.others_apart_m)
        numbers = ["-" if metres is None else f"{1e3 * metres:.3f}" for metres in told]
        rows.append([row.name, row.alignment, *numbers, f"{100 * row.missing_share:.1f}"])
    heads = ["scan", "alignment", "mean off [mm]", "rms off [mm]", "off the others [mm]", "others apart [mm]"]
    return numbers_table([*heads, "not shown [%]"], rows)
