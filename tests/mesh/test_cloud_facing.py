"""Normals of a reference that is a point cloud: turned where they all look inwards, doubted where nothing tells."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh

from fusion.mesh.comparison.compare import CompareSettings, compare
from fusion.mesh.comparison.surface_samples import sample_surface
from fusion.mesh.mesh import Mesh
from fusion.mesh.vertices import vertices_kept

STAND = CompareSettings(align=False, samples=10_000)
OUT = 0.0005  # [m] of the scan, beyond the reference


def _ball(radius):
    shape = trimesh.creation.icosphere(5, radius)
    return Mesh(np.array(shape.vertices), np.array(shape.faces, np.int32))


def _cloud(signs=1.0):
    points = sample_surface(_ball(0.05), 20_000)
    return Mesh(points.points, normals=(points.normals * signs).astype(np.float32))


def _inside_out(mesh):
    return replace(mesh, faces=mesh.faces[:, ::-1])


def _part(mesh, below=0.04):
    return vertices_kept(mesh, mesh.vertices[:, 2] < below)


CLOSED, OPEN = _ball(0.05 + OUT), _part(_ball(0.05 + OUT))


@pytest.mark.parametrize("scan", [CLOSED, _inside_out(CLOSED), OPEN], ids=["closed", "inside out", "open"])
def test_normals_that_look_inwards_are_turned(scan):
    found, true = compare(scan, _cloud(-1), STAND), compare(scan, _cloud(), STAND)
    assert true.accuracy.mean_signed == pytest.approx(OUT, abs=3e-5)  # planes between points and flat triangles
    assert found.accuracy == true.accuracy
    assert set(found.notes) - set(true.notes) == {"The reference's normals pointed inwards: turned."}
    np.testing.assert_array_equal(found.reference.normals, _cloud().normals)


@pytest.mark.parametrize("scan", [CLOSED, OPEN, _inside_out(OPEN)], ids=["closed", "open", "inside out"])
def test_normals_that_look_outwards_stay_without_a_word(scan):
    found = compare(scan, _cloud(), STAND)
    assert found.accuracy.mean_signed > 0 and not any("normals" in note for note in found.notes)
    np.testing.assert_array_equal(found.reference.normals, _cloud().normals)


def test_a_room_looks_inwards():
    found = compare(_inside_out(OPEN), _cloud(-1), STAND)
    assert found.accuracy.mean_signed < 0 and not any("normals" in note for note in found.notes)


def test_what_nothing_tells_is_said():
    some = _cloud(np.where(np.arange(20_000) % 3 == 0, -1.0, 1.0)[:, None])
    (told,) = compare(CLOSED, some, STAND).notes
    assert told.startswith("On 33% of the mesh") and "uncertain" in told
    sheet = trimesh.creation.box((0.2, 0.15, 0.01)).subdivide_to_size(0.01)
    sheet = Mesh(np.array(sheet.vertices), np.array(sheet.faces, np.int32))
    top = vertices_kept(sheet, sheet.vertices[:, 2] > 0.0049)
    points = sample_surface(top, 5000)
    found = compare(top, Mesh(points.points, normals=-points.normals.astype(np.float32)), STAND)
    assert any(note.startswith("The reference's normals look the other way") for note in found.notes)
