"""The report of a scan: from what the pipeline knows to one page; what is not known is left out."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.pose import Array
from fusion.geometry.trajectory import Trajectory
from fusion.mesh.drawing.shading import Lit
from fusion.mesh.drawing.sight import sides
from fusion.mesh.mesh import Mesh
from fusion.mesh.shape import shape_of
from fusion.report.kit.page import Figure, Page, Section, write_page
from fusion.report.kit.palette import BLUE, GREY, ORANGE
from fusion.report.kit.tables import settings_table
from fusion.report.kit.viewer import Layer, Path3D, script, value_layer, viewer
from fusion.report.kit.views import ViewRow, mesh_views, seen_alone
from fusion.report.scans.circle import Paths, circle_figure, circle_points, has_axis
from fusion.report.scans.coverage import azimuth_figure, coverage_figure, coverage_scale
from fusion.report.scans.facts import fact_numbers
from fusion.report.scans.frames import frames_figure
from fusion.report.scans.sure import sigma_figure, sigma_of, sigma_scale
from fusion.report.scans.turning import steps_figure
from fusion.report.scans.wobble import wobble_figure
from fusion.results.facts import ScanFacts
from fusion.results.light import Light
from fusion.results.table_motion import TableMotion
from fusion.results.words import mesh_words


@dataclass(frozen=True)
class ScanReport:
    """What a report of a scan may hold; only the mesh is required, empty parts make no section."""

    mesh: Mesh  # the result [m]
    facts: ScanFacts | None = None  # the numbers that the terminal tells too; None: those of the mesh alone
    # title, subtitle: plain text, may hold any file name
    title: str = "Scan"
    subtitle: str = ""
    # trajectory_raw, trajectory: camera poses before and after the turntable post-pass, in the mesh's frame
    trajectory_raw: Trajectory | None = None
    trajectory: Trajectory | None = None
    turntable: TableMotion | None = None  # what it did
    residual: NDArray | None = None  # (n,) per frame [m], NaN where a frame has none
    inlier_share: NDArray | None = None  # (n,) per frame, 0 to 1
    rejected: Mapping[int, str] = field(default_factory=dict)  # frame to reason
    times_seen: NDArray | None = None  # (vertices,) number of frames that saw each vertex
    mesh_raw: Mesh | None = None  # the mesh before the turntable correction, for before and after
    # up, front: (3,) in the mesh's frame; None: from the turntable's axis and the first camera, else -y and -z, which
    # is up and towards the viewer in a camera's frame
    up: Array | None = None
    front: Array | None = None
    verdict: str = ""  # in a line, "" where there is none
    summary: Sequence[Light] = ()  # judged lines, the worst first
    settings: Mapping[str, object] = field(default_factory=dict)  # nested, as in `settings.json`
    warnings: Sequence[tuple[str, str]] = ()  # (severity "ok", "warning" or "bad", sentence)
    fingerprint: Mapping[str, object] | str = field(default_factory=dict)  # what identifies the input
    command: str = ""  # the command line
    comparison: Any = None  # result of a comparison with a reference, or None


def scan_report(path: Path, report: ScanReport) -> None:
    """Write `report.html` of a scan."""
    up, front = orientation(report)
    around = sides(up, front)
    sights = seen_alone(report.mesh, around)
    facts = report.facts or ScanFacts(shape_of(report.mesh, around[0].up))
    print_ = report.fingerprint
    page = Page(
        title=report.title,
        subtitle=report.subtitle,
        verdict=report.verdict,
        summary=report.summary,
        numbers=fact_numbers(facts),
        sections=[
            _mesh_section(report, facts, sights),
            _viewer_section(report, up, front),
            _sure_section(report.mesh, sights),
            _turntable_section(report, facts, sights),
            _frames_section(report),
            _coverage_section(report, sights),
            *_comparison_sections(report, sights),
        ],
        warnings=[Light(level, "", sentence) for level, sentence in report.warnings],
        settings=report.settings,
        fingerprint={"fingerprint": print_} if isinstance(print_, str) and print_ else print_ or {},
        command=report.command,
        script=script(),
    )
    write_page(path, page)


def orientation(report: ScanReport) -> tuple[Array, Array]:
    """(up, front) of the mesh, each (3,): what was stated, else from the turntable and the first camera."""
    up, front = np.array([0.0, -1.0, 0.0]), np.array([0.0, 0.0, -1.0])
    if report.turntable and has_axis(report.turntable):
        up = report.turntable.axis_direction
    points = report.mesh.vertices[np.isfinite(report.mesh.vertices).all(axis=1)]
    first = _poses(report)
    if first is not None and len(points):
        front = first.centres[first.valid][0] - points.mean(axis=0)
    return (up if report.up is None else np.asarray(report.up, float)), (
        front if report.front is None else np.asarray(report.front, float)
    )


def _poses(report: ScanReport) -> Trajectory | None:
    """The best trajectory that holds a pose."""
    return next((t for t in (report.trajectory, report.trajectory_raw) if t is not None and t.valid.any()), None)


def _mesh_section(report: ScanReport, facts: ScanFacts, sights: Sequence[Lit]) -> Section:
    mesh = report.mesh
    title = mesh_words(facts.shape)
    alt = f"The mesh from front, left, back, right and top: {title}."
    rows = [ViewRow(mesh, name="shape", sights=sights)]
    if mesh.colors is not None and len(mesh.colors) == len(mesh.vertices):
        rows.insert(0, ViewRow(mesh, mesh.colors / 255.0, "colour", sights))
    caption = "Parallel projection, all views at one scale. Dark: the inside, seen through a hole."
    around = [sight.side for sight in sights]
    return Section("The mesh", figures=(mesh_views(rows, around, Figure(title, "views", alt, caption)),))


def _viewer_section(report: ScanReport, up: Array, front: Array) -> Section:
    mesh = report.mesh
    layers = [Layer("Shape")]
    if mesh.colors is not None and len(mesh.colors) == len(mesh.vertices):
        layers.insert(0, Layer("Colour", colors=mesh.colors))
    sigma, seen = sigma_of(mesh), _seen(report)
    if sigma is not None:
        layers.append(value_layer("How sure", 1000 * sigma, sigma_scale(sigma)))
    if seen is not None:
        scale = coverage_scale(seen)
        layers.append(value_layer("Coverage", seen, scale))
    paths = [("cameras, raw", ORANGE, report.trajectory_raw), ("cameras, corrected", BLUE, report.trajectory)]
    lines = [Path3D(name, t.centres, color) for name, color, t in paths if t is not None and t.valid.any()]
    best = _poses(report)
    if best is not None and report.turntable and has_axis(report.turntable):
        lines.append(Path3D("fitted circle", circle_points(best, report.turntable), GREY))
    return viewer(mesh, layers, up, front, tuple(lines))


def _sure_section(mesh: Mesh, sights: Sequence[Lit]) -> Section:
    sigma = sigma_of(mesh)
    return Section("How sure", figures=() if sigma is None else (sigma_figure(mesh, sigma, sights),))


def _turntable_section(report: ScanReport, facts: ScanFacts, sights: Sequence[Lit]) -> Section:
    """What the table did; folded, what the correction changed."""
    figures, folded = [], []
    table = report.turntable
    if table is not None and len(table.angles_rad):
        figures.append(steps_figure(table, facts.table))
    if table is not None and has_axis(table):
        paths = Paths(report.trajectory_raw, report.trajectory, table)
        if paths.named():
            folded.append(circle_figure(paths))
        if report.trajectory_raw is not None:
            folded.append(wobble_figure(report.trajectory_raw, table))
    if report.mesh_raw is not None:
        text = Figure("The mesh before and after the turntable correction", "beforeaftermesh", "Two rows of views.")
        some = [sights[k] for k in (0, 1, 4)]
        rows = [ViewRow(report.mesh_raw, name="before"), ViewRow(report.mesh, name="after", sights=some)]
        folded.append(mesh_views(rows, [sight.side for sight in some], text))
    return Section("Turntable", figures=tuple(figures), folded=tuple(folded))


def _frames_section(report: ScanReport) -> Section:
    if report.residual is None and report.inlier_share is None and not report.rejected:
        return Section("Frames")
    reasons = {f"frame {frame}": reason for frame, reason in sorted(report.rejected.items())}
    table = "<h3>Rejected frames</h3>" + settings_table(reasons) if reasons else ""
    if report.residual is None and report.inlier_share is None:
        return Section("Frames", html=table)
    figure = frames_figure(report.residual, report.inlier_share, report.rejected)
    return Section("Frames", figures=(figure,), html=table)


def _seen(report: ScanReport) -> NDArray | None:
    """Coverage (n,) as floats, when it belongs to this mesh."""
    if report.times_seen is None or len(report.times_seen) != len(report.mesh.vertices) or not len(report.times_seen):
        return None
    return np.asarray(report.times_seen, float)


def _coverage_section(report: ScanReport, sights: Sequence[Lit]) -> Section:
    figures = []
    seen = _seen(report)
    if seen is not None:
        figures.append(coverage_figure(report.mesh, seen, sights))
    best = _poses(report)
    if best is not None and report.turntable and has_axis(report.turntable):
        (_, _, centres), *_ = Paths(None, best, report.turntable).named()
        figures.append(azimuth_figure(centres))
    return Section("Coverage", figures=tuple(figures))


def _comparison_sections(report: ScanReport, sights: Sequence[Lit]) -> list[Section]:
    if report.comparison is None:
        return []
    from fusion.report.comparisons.comparison import comparison_section

    return [comparison_section(report.comparison, report.mesh, sights)]
