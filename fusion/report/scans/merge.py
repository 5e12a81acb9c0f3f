"""The report of a merge: how the passes lie to each other, where both saw, and what came of them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.mesh.drawing.sight import SightSide, sides
from fusion.mesh.mesh import Mesh
from fusion.report.kit.page import Figure, Number, Page, Section, write_page
from fusion.report.kit.tables import numbers_table
from fusion.report.kit.viewer import Layer, script, value_layer, viewer
from fusion.report.kit.views import Scale, ViewRow, mesh_views, nice_length, scale_colors, seen_alone
from fusion.report.scans.facts import fact_numbers
from fusion.results.facts import ScanFacts
from fusion.results.light import Light

UP, FRONT = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])  # the first camera looks along -x


@dataclass(frozen=True)
class MergeReport:
    """What the page shows."""

    mesh: Mesh  # the merged object, z up
    parts: Sequence[tuple[str, Mesh]]  # name and mesh of each pass, where it lies in the merge
    facts: ScanFacts  # of the mesh and the frames
    apart: NDArray  # (n,) how far the passes lie from each other at each vertex [m], NaN where one alone saw it
    content: Mapping[str, Any]  # of `merge.json`
    verdict: str = ""  # in a line
    summary: Sequence[Light] = ()  # judged lines, the worst first
    settings: Mapping[str, object] = field(default_factory=dict)  # nested
    command: str = ""  # the command line


def merge_report(path: Path, report: MergeReport) -> None:
    """Write `report.html` of a merge."""
    around = [*sides(UP, FRONT), SightSide("below", -UP, FRONT)]
    names = ", ".join(name for name, _ in report.parts)
    page = Page(
        title=f"{len(report.parts)} passes merged",
        subtitle=names,
        verdict=report.verdict,
        summary=report.summary,
        numbers=[*fact_numbers(report.facts), *_numbers(report)],
        sections=[
            Section("Before and after", figures=(_before_after(report, around),)),
            Section("Where the passes overlap", figures=(_apart(report, around),), html=_table(report)),
            viewer(report.mesh, _layers(report), UP, FRONT),
        ],
        settings=report.settings,
        command=report.command,
        script=script(),
    )
    write_page(path, page)


def _numbers(report: MergeReport) -> list[Number]:
    content, rms = report.content, report.content["rms_m"]
    out = [Number("Seen by more than one pass", f"{content['seen_twice_share'] * 100:.0f}", "% of the vertices")]
    if rms is not None:
        out.append(Number("Passes apart, where both saw", f"{rms * 1e3:.2f}", "mm rms"))
    return out


def _before_after(report: MergeReport, around: list[SightSide]) -> Figure:
    rows = [ViewRow(mesh, name=name) for name, mesh in report.parts]
    rows.append(ViewRow(report.mesh, name="merged", sights=seen_alone(report.mesh, around)))
    if report.mesh.colors is not None and len(report.mesh.colors):
        rows.append(ViewRow(report.mesh, report.mesh.colors / 255.0, "colour", rows[-1].sights))
    said = report.facts.shape.openings()
    alt = f"Each pass where it lies in the merge, and the merged mesh: {said}."
    caption = "All passes in the frame of the first. Dark: the inside, seen through what a pass could not see."
    return mesh_views(rows, around, Figure(f"The merged mesh: {said}", "beforeafter", alt, caption))


def _scale(apart: NDArray) -> Scale:
    known = apart[np.isfinite(apart)] * 1000
    wanted = float(np.percentile(known, 95)) if len(known) else 1.0
    low = nice_length(max(wanted, 1e-3))
    high = next(step * low for step in (1, 2, 2.5, 5) if step * low >= wanted * (1 - 1e-9))
    return Scale("viridis", 0.0, high, "distance between the passes [mm] (grey: one pass alone saw it)")


def _apart(report: MergeReport, around: list[SightSide]) -> Figure:
    scale = _scale(report.apart)
    rms = report.content["rms_m"]
    title = "No surface was seen twice" if rms is None else f"Where both saw, the passes lie {rms * 1e3:.2f} mm apart"
    text = Figure(title, "apart", f"The merged mesh coloured by the distance between the passes. {title}.")
    return mesh_views([ViewRow(report.mesh, scale_colors(report.apart * 1000.0, scale))], around, text, scale)


def _table(report: MergeReport) -> str:
    rows = []
    for one in report.content["passes"][1:]:
        on = report.content["passes"][one["onto"]]["name"]
        second = "none" if one["second_score"] < -0.99 else f"{one['second_score']:.2f}"
        rows.append(
            [
                f"{one['name']} on {on}",
                f"{one['overlap_share'] * 100:.1f}",
                f"{one['through_share'] * 100:.2f}",
                f"{one['rms_m'] * 1e3:.2f}",
                f"{one['score']:.2f}",
                second,
                "yes" if one["symmetric"] else "no",
            ]
        )
    head = ["pass", "overlap [%]", "looked through [%]", "rms apart [mm]", "score", "next best", "symmetric"]
    return numbers_table(head, rows)


def _layers(report: MergeReport) -> list[Layer]:
    layers = [Layer("Shape")]
    if report.mesh.colors is not None and len(report.mesh.colors):
        layers.insert(0, Layer("Colour", colors=report.mesh.colors))
    if np.isfinite(report.apart).any():
        layers.append(value_layer("Passes apart", report.apart * 1000.0, _scale(report.apart)))
    return layers
