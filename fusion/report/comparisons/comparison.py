"""The report of a comparison: how far a mesh stands from its reference, where, and how often."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.pose import Array
from fusion.mesh.comparison.statistics import OVER, knowable
from fusion.mesh.drawing.shading import Lit
from fusion.mesh.drawing.sight import sides
from fusion.mesh.mesh import Mesh
from fusion.report.comparisons.distance import distance_scale, distance_views, histogram_figure, shares
from fusion.report.kit.page import Figure, Number, Page, Section, write_page
from fusion.report.kit.tables import numbers_table
from fusion.report.kit.viewer import Layer, script, value_layer, viewer
from fusion.report.kit.views import ViewRow, mesh_views, pixel_of, seen_alone
from fusion.report.scans.sure import OVER_SCALE, over_sigma_figure
from fusion.results.comparison import field_of, judge_comparison, millimetres, number_of, share_within
from fusion.results.light import Light

_ROWS = [
    ("mean_signed", "mean, signed"), ("mean", "mean of the size"), ("median", "median of the size"), ("rms", "rms"),
    ("std", "standard deviation"), ("p95", "95 % are below"), ("max", "largest"),
]  # fmt: skip
LARGER = 1.2  # than the mesh: a reference that is shown in pixels of its own size


@dataclass(frozen=True)
class Circumstances:
    """What a comparison report says around its numbers: title, command, settings, input, warnings, orientation."""

    title: str = "Comparison"
    subtitle: str = ""
    command: str = ""
    settings: Mapping[str, object] = field(default_factory=dict)
    fingerprint: Mapping[str, object] = field(default_factory=dict)
    warnings: Sequence[tuple[str, str]] = ()  # (severity "ok", "warning" or "bad", sentence)
    # up, front: (3,) in the mesh's frame; front points from the object to the eye
    up: Sequence[float] | Array = (0.0, 0.0, 1.0)
    front: Sequence[float] | Array = (0.0, -1.0, 0.0)


def comparison_report(
    path: Path, comparison: Any, mesh: Mesh, reference: Mesh | None = None, about: Circumstances | None = None
) -> None:
    """Write `report.html` of a comparison.

    Args:
        comparison: the fields of `comparison.json`, as a mapping or as attributes; `histogram` (counts, edges [m])
            is used where there is one.
        mesh: the compared mesh with `scalars["signed_distance"]` [m] per vertex.
        reference: what it was compared with, in the mesh's frame, or None.
    """
    about = about or Circumstances()
    up, front = np.asarray(about.up, float), np.asarray(about.front, float)
    around = sides(up, front)
    sights = seen_alone(mesh, around)
    pictures = [ViewRow(mesh, name="mesh", sights=sights)]
    if reference is not None:
        # at one scale: pixels that suit the mesh would be too many for a reference that is much larger
        pictures = [replace(pictures[0], sights=sights if pixel_of([reference]) < LARGER * pixel_of([mesh]) else None)]
        pictures.append(ViewRow(reference, name="reference"))
    text = Figure("The mesh and its reference" if reference else "The mesh", "pair", "Views from five sides.")
    page = Page(
        title=about.title,
        subtitle=about.subtitle,
        summary=judge_comparison(comparison).lights,
        numbers=_numbers(comparison),
        sections=[
            comparison_section(comparison, mesh, sights),
            viewer(mesh, _layers(mesh), up, front),
            Section("Both shapes", figures=(mesh_views(pictures, around, text),)),
        ],
        warnings=[Light(severity, "", sentence) for severity, sentence in about.warnings],
        settings=about.settings,
        fingerprint=about.fingerprint,
        command=about.command,
        script=script(),
    )
    write_page(path, page)


def comparison_section(comparison: Any, mesh: Mesh, sights: Sequence[Lit]) -> Section:
    """Distance map, histogram and the table of both directions."""
    figures = []
    distance = _distance(mesh)
    within = _within(comparison) or (shares(distance) if distance is not None else {})
    if distance is not None and np.isfinite(distance).any():
        figures.append(distance_views(mesh, distance, sights, within))
    known = knowable(mesh)
    if known is not None:
        figures.append(over_sigma_figure(mesh, known, sights))
    counts, edges = _histogram(comparison, distance)
    if len(counts):
        median = float(np.nanmedian(distance)) if distance is not None and np.isfinite(distance).any() else np.nan
        figures.append(histogram_figure(counts, edges, within, median))
    return Section("Distances", figures=tuple(figures), html=_table(comparison))


def _numbers(comparison: Any) -> list[Number]:
    near, far = (field_of(comparison, name) or {} for name in ("accuracy", "completeness"))
    numbers = []
    for name, block in (("accuracy", near), ("completeness", far)):
        if block:
            numbers.append(Number(f"Rms, {name}", millimetres(number_of(block, "rms"))[:-3], "mm"))
            numbers.append(Number(f"Within 2 mm, {name}", f"{share_within(block, 0.002) * 100:.1f}", "%"))
    scores = field_of(comparison, "fscore") or {}
    numbers += [Number(f"F-score at {float(k) * 1000:g} mm", f"{float(v):.3f}") for k, v in scores.items()]
    return numbers


def _table(comparison: Any) -> str:
    blocks = [field_of(comparison, name) or {} for name in ("accuracy", "completeness")]
    if not any(blocks):
        return ""
    rows = [[f"{label} [mm]", *(millimetres(number_of(block, key))[:-3] for block in blocks)] for key, label in _ROWS]
    rows += [
        [f"within {limit * 1000:g} mm [%]", *(f"{share_within(block, limit) * 100:.1f}" for block in blocks)]
        for limit in (0.001, 0.002, 0.005)
    ]
    return numbers_table(["distance", "mesh to reference", "reference to mesh"], rows)


def _layers(mesh: Mesh) -> list[Layer]:
    distance = _distance(mesh)
    layers = [Layer("Shape")]
    if mesh.colors is not None and len(mesh.colors) == len(mesh.vertices):
        layers.append(Layer("Colour", colors=mesh.colors))
    if distance is None or not np.isfinite(distance).any():
        return layers
    scale = distance_scale(distance)
    over = [value_layer("Over sigma", mesh.scalars[OVER], OVER_SCALE)] if knowable(mesh) is not None else []
    return [value_layer("Distance", distance * 1000, scale), *over, *layers]


def _distance(mesh: Mesh) -> NDArray | None:
    """(n,) signed distance [m], when the mesh carries one per vertex."""
    values = mesh.scalars.get("signed_distance")
    return None if values is None or len(values) != len(mesh.vertices) else np.asarray(values, float)


def _histogram(comparison: Any, distance: NDArray | None) -> tuple[NDArray, NDArray]:
    """(counts, edges [m]): the comparison's own, else from the vertices; the outermost bins hold what lies beyond."""
    stated = field_of(comparison, "histogram")
    if stated is not None:
        pair = (
            [field_of(stated, name) for name in ("counts", "edges")] if not isinstance(stated, tuple) else list(stated)
        )
        if len(pair) == 2 and all(part is not None for part in pair):
            return np.asarray(pair[0], float), np.asarray(pair[1], float)
    known = distance[np.isfinite(distance)] if distance is not None else np.zeros(0)
    if not len(known):
        return np.zeros(0), np.zeros(1)
    half = max(float(np.percentile(np.abs(known), 99)), 1e-5)
    return np.histogram(np.clip(known, -half, half), bins=81, range=(-half, half))


def _within(comparison: Any) -> dict[float, float]:
    """Share by limit [m] of the mesh's distances, as the comparison states it."""
    within = field_of(field_of(comparison, "accuracy") or {}, "within") or {}
    return {float(limit): float("nan") if share is None else float(share) for limit, share in within.items()}
