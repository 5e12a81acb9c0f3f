"""A mesh is cut exactly where a function of its vertices is zero."""

import numpy as np
import pytest
import trimesh

from fusion.mesh.cleanup import border_edges
from fusion.mesh.clipping import clipped
from fusion.mesh.comparison.surface_samples import face_areas
from fusion.mesh.mesh import Mesh

RADIUS = 0.05


def ball() -> Mesh:
    made = trimesh.creation.icosphere(5, RADIUS)
    vertices = np.array(made.vertices)
    heat = vertices[:, 2].astype(np.float32)
    return Mesh(
        vertices, np.asarray(made.faces, np.int32), (vertices / RADIUS).astype(np.float32), None, {"heat": heat}
    )


@pytest.mark.parametrize("height", [-0.03, 0.0, 0.0123, 0.045])
def test_a_ball_becomes_a_cap(height):
    mesh = ball()
    cap = clipped(mesh, mesh.vertices[:, 2] - height)
    # of the triangles that stand for the ball 0.1 % is missing
    assert face_areas(cap).sum() == pytest.approx(2 * np.pi * RADIUS * (RADIUS - height), rel=2e-3)
    border = cap.vertices[np.unique(border_edges(cap))]
    assert np.abs(border[:, 2] - height).max() < 1e-6 and cap.vertices[:, 2].min() > height - 1e-9
    assert cap.scalars["heat"] == pytest.approx(cap.vertices[:, 2], abs=1e-6)
    assert np.linalg.norm(cap.normals, axis=1) == pytest.approx(1.0, abs=1e-6)
    a, b, c = (cap.vertices[k] for k in cap.faces.T)
    assert (np.einsum("ij,ij->i", np.cross(b - a, c - a), a + b + c) > -1e-15).all()  # none is turned over


def test_both_halves_are_the_whole():
    mesh = ball()
    level = mesh.vertices @ [0.3, -0.5, 0.8] - 0.01
    halves = [clipped(mesh, way * level) for way in (1, -1)]
    assert sum(face_areas(half).sum() for half in halves) == pytest.approx(face_areas(mesh).sum(), rel=1e-5)


def test_all_or_nothing():
    mesh = ball()
    assert clipped(mesh, np.ones(len(mesh.vertices))) is mesh
    assert not len(clipped(mesh, -np.ones(len(mesh.vertices))).faces)
