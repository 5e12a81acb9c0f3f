"""Reports of scans and comparisons from complete, partial and broken data."""

import re
from dataclasses import replace

import numpy as np
import pytest
from made_up import UP, bumpy_sphere, made_up_comparison, made_up_scan

from fusion.geometry.camera import Camera
from fusion.geometry.trajectory import Trajectory
from fusion.mesh.drawing.sight import look, sides
from fusion.mesh.mesh import Mesh
from fusion.report.comparisons.comparison import comparison_report
from fusion.report.comparisons.distance import distance_scale, shares
from fusion.report.kit.viewer import thinned
from fusion.report.kit.views import nice_length
from fusion.report.scans.scan import ScanReport, scan_report
from fusion.report.scans.seen import times_seen
from fusion.results.comparison import judge_comparison
from fusion.results.table_motion import TableMotion

EMPTY = Mesh(np.zeros((0, 3)))


@pytest.fixture(autouse=True)
def small_pictures(monkeypatch):
    """What is tested here does not depend on the size of the pictures, and small ones are quick."""
    monkeypatch.setattr("fusion.report.kit.views.PIXELS", 40)


def headings(path) -> list[str]:
    return re.findall(r"<h2>(.*?)</h2>", path.read_text(encoding="utf-8"))


@pytest.mark.slow
def test_sections_appear_only_with_their_data(tmp_path):
    small = bumpy_sphere(2)
    scan_report(tmp_path / "bare.html", ScanReport(small))
    assert headings(tmp_path / "bare.html") == ["Summary", "The mesh", "Turn it yourself", "How it was made"]
    full = replace(made_up_scan(), mesh=small, times_seen=np.ones(len(small.vertices)), mesh_raw=None)
    scan_report(tmp_path / "full.html", replace(full, comparison=made_up_comparison()))
    assert headings(tmp_path / "full.html") == [
        "Summary", "Warnings", "The mesh", "Turn it yourself", "Turntable", "Frames", "Coverage", "Distances",
        "How it was made",
    ]  # fmt: skip
    page = (tmp_path / "full.html").read_text(encoding="utf-8")
    assert page.count("getContext(") == 1  # the 3D view's script stands once
    assert page.count('role="img"') == page.count('aria-label="', page.index("<main")) - 1  # all and the 3D view
    assert list(tmp_path.glob(".partial-*")) == []


def turned(point, angles):
    return TableMotion(axis_point=point, axis_direction=np.array([0, 0, 1.0]), angles_rad=angles)


NOWHERE = Trajectory(np.arange(3.0), np.full((3, 4, 4), np.nan))
BROKEN = {
    "empty mesh": {"mesh": EMPTY},
    "mesh of NaN": {"mesh": Mesh(np.full((3, 3), np.nan), np.array([[0, 1, 2]], np.int32))},
    "one vertex": {"mesh": Mesh(np.ones((1, 3)))},
    "point cloud": {"mesh": Mesh(bumpy_sphere(2).vertices)},
    "flat": {"mesh": Mesh(np.array([[0, 0, 1], [1, 0, 1], [0, 0, 2.0]]), np.array([[0, 1, 2]], np.int32))},
    "residuals all NaN": {"residual": np.full(25, np.nan), "inlier_share": np.full(25, np.nan)},
    "no residuals": {"residual": np.zeros(0), "inlier_share": np.zeros(0), "rejected": {}},
    "no pose": {"trajectory": NOWHERE, "trajectory_raw": NOWHERE},
    "axis of NaN": {"turntable": turned(np.full(3, np.nan), np.array([np.nan, 0.1]))},
    "turntable without parts": {"turntable": turned(np.zeros(3), np.zeros(0))},
    "everything rejected": {"rejected": {i: f"no overlap {i}" for i in range(25)}},
    "coverage of another mesh": {"times_seen": np.ones(3)},
}


@pytest.mark.slow
@pytest.mark.parametrize("change", BROKEN.values(), ids=BROKEN)
def test_broken_data_still_makes_a_page(tmp_path, change):
    report = replace(made_up_scan(), mesh=bumpy_sphere(1), mesh_raw=None, times_seen=None)
    if change.keys() & {"mesh", "times_seen"}:  # plots take their time, and these do not look at the mesh
        report = replace(report, turntable=None, residual=None, inlier_share=None, rejected={})
    report = replace(report, **change)
    scan_report(tmp_path / "report.html", report)
    assert "How it was made" in headings(tmp_path / "report.html")


@pytest.mark.slow
def test_a_single_frame_makes_a_page(tmp_path):
    scan_report(
        tmp_path / "report.html", replace(made_up_scan(1), mesh=bumpy_sphere(1), mesh_raw=None, times_seen=None)
    )
    assert "Frames" in headings(tmp_path / "report.html")


@pytest.mark.slow
@pytest.mark.parametrize(
    "mesh", [EMPTY, Mesh(bumpy_sphere(1).vertices), bumpy_sphere(1)], ids=["empty", "cloud", "ball"]
)
def test_comparison_pages(tmp_path, mesh):
    comparison_report(tmp_path / "c.html", made_up_comparison(), mesh)
    comparison_report(tmp_path / "d.html", {}, mesh, EMPTY)
    assert "Distances" in headings(tmp_path / "c.html")


def test_summary_judges_by_the_numbers():
    comparison = made_up_comparison()
    assert {line.level for line in judge_comparison(comparison).lights} == {"ok"}
    comparison["accuracy"] = comparison["accuracy"] | {"rms": 0.02}
    assert next(line.level for line in judge_comparison(comparison).lights if line.subject == "Accuracy") == "bad"


def test_summary_tells_how_well_the_scale_is_known():
    comparison = made_up_comparison() | {"scale": 1.01, "scale_interval": (1.005, 1.015)}
    assert any("1.00500 to 1.01500" in line.reason for line in judge_comparison(comparison).lights)
    for unknown in (None, (0.0, None)):  # nothing was fitted; nothing is known (comparison.json has no infinity)
        assert judge_comparison(comparison | {"scale_interval": unknown})


def test_looking_keeps_lengths_and_nearness():
    mesh = bumpy_sphere(3, holed=False)
    for side in sides(UP, np.array([0, 0, -1.0])):
        sight = look(mesh, side, 0.001)
        width = np.ptp(np.flatnonzero(sight.hit.any(axis=0))) + 1
        # one pixel at each end may be missed by the rays through pixel centres
        assert abs(width * 0.001 - np.ptp(mesh.vertices @ side.right)) < 0.0025
        seen = mesh.vertices[sight.corners].mean(axis=(0, 1))
        # over a ball's disc its near half stands two thirds of the radius before the middle, bumps of 8 % aside
        assert (seen - mesh.vertices.mean(axis=0)) @ side.towards == pytest.approx(0.2 / 3, rel=0.05)


def test_thinning_stays_on_the_surface():
    mesh = bumpy_sphere(5, holed=False)
    small, nearest = thinned(mesh, 2000)
    assert len(small.faces) <= 2000 and len(nearest) == len(small.vertices)
    # a sphere of 2000 triangles has edges of about 11 mm, whose vertices leave a curved surface by well under 2 mm
    assert np.linalg.norm(mesh.vertices[nearest] - small.vertices, axis=1).max() < 0.003


def test_seen_vertices_face_the_camera():
    mesh = bumpy_sphere(3, holed=False)
    once = Trajectory(np.zeros(1), np.eye(4)[None])
    camera = Camera(320, 240, 300, 300, 159.5, 119.5)
    counts = times_seen(mesh, Trajectory(np.zeros(2), np.stack([np.eye(4)] * 2)), camera)
    assert (counts == 2 * times_seen(mesh, once, camera)).all()
    towards = -(mesh.vertices - mesh.vertices.mean(axis=0)) @ (mesh.vertices.mean(axis=0))
    assert (counts[towards < -0.03] == 0).all()  # the far side
    assert (counts[towards > 0.06] > 0).all()  # what looks straight at the camera
    assert times_seen(EMPTY, once, camera).shape == (0,)


def test_scales_are_round_and_shares_right():
    assert [nice_length(x) for x in (0.7, 1.0, 4.9, 5.0, 99, 0, np.nan)] == [0.5, 1, 2, 5, 50, 1, 1]
    scale = distance_scale(np.linspace(-0.003, 0.003, 1001))
    assert scale.low == -scale.high and 2.85 <= scale.high <= 5
    assert shares(np.array([0.0005, -0.0015, 0.004, np.nan])) == {0.001: 1 / 3, 0.002: 2 / 3, 0.005: 1.0}
