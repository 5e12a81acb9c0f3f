"""Signed distances against shapes whose distance is known in closed form."""

import numpy as np
import pytest
import trimesh

from fusion.errors import MeshError
from fusion.mesh.comparison.distances import signed_distances, surface_of
from fusion.mesh.comparison.surface_samples import sample_surface, vertex_normals
from fusion.mesh.mesh import Mesh
from fusion.mesh.vertices import vertices_kept


def as_mesh(shape: trimesh.Trimesh) -> Mesh:
    return Mesh(np.asarray(shape.vertices), np.asarray(shape.faces, np.int32))


def box_distance(points: np.ndarray, half: np.ndarray) -> np.ndarray:
    q = np.abs(points) - half
    return np.linalg.norm(np.maximum(q, 0), axis=1) + np.minimum(q.max(axis=1), 0)


@pytest.mark.parametrize("shift", [0.0, 1000.0])
def test_box_inside_and_outside_also_beside_edges_and_corners(shift):
    half = np.array([0.1, 0.15, 0.2])
    box = as_mesh(trimesh.creation.box(2 * half))
    points = np.random.default_rng(0).uniform(-0.4, 0.4, (5000, 3))
    found = signed_distances(points + shift, Mesh(box.vertices + shift, box.faces))
    # float32 about the middle: 1e-7 of half a metre
    np.testing.assert_allclose(found, box_distance(points, half), atol=2e-7)


def test_sharp_corners_keep_the_sign():
    # at a spike a single face's normal gives the wrong side for some directions; angle-weighted normals do not
    spike = trimesh.creation.cone(radius=0.02, height=0.3, sections=5)
    points = np.array([0, 0, 0.3]) + np.random.default_rng(1).normal(size=(4000, 3)) * 0.05
    outside = points[:, 2] > 0.3  # above the tip
    assert (signed_distances(points[outside], as_mesh(spike)) > 0).all()


def test_an_open_scan_has_signs_and_borders():
    ball = as_mesh(trimesh.creation.icosphere(subdivisions=4, radius=0.1))
    bowl = vertices_kept(ball, ball.vertices[:, 2] <= 0)
    surface = surface_of(bowl)
    found = surface.closest(np.array([[0, 0, -0.11], [0, 0, -0.09], [0.02, 0, -0.05], [0.07, 0.07, 0.09]]))
    assert (np.sign(found.distances[:3]) == [1, -1, -1]).all()  # beyond the border there are no sides
    assert found.on_border.tolist() == [False, False, False, True]


def test_a_closed_mesh_inside_out_is_turned():
    ball = as_mesh(trimesh.creation.icosphere(radius=0.1))
    turned = Mesh(ball.vertices, ball.faces[:, ::-1])
    # flat triangles lie within the ball by a few thousandths of its radius
    assert signed_distances(np.array([[0.2, 0, 0]]), turned)[0] == pytest.approx(0.1, abs=0.001)


def test_a_cloud_is_the_surface_between_its_points():
    ball = as_mesh(trimesh.creation.icosphere(subdivisions=5, radius=0.1))  # 10242 points, 3.5 mm apart
    directions = np.random.default_rng(2).normal(size=(2000, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    radii = np.random.default_rng(3).uniform(0.095, 0.105, 2000)
    for cloud in (Mesh(ball.vertices), Mesh(ball.vertices, normals=vertex_normals(ball).astype(np.float32))):
        found = surface_of(cloud).closest(directions * radii[:, None], directions)
        # the plane at the nearest point leaves the ball by (2 mm)^2 / (2 * 0.1 m) = 0.02 mm; 0.05 with the fit's tilt
        np.testing.assert_allclose(found.distances, radii - 0.1, atol=5e-5)
        assert not found.on_border.any()


def test_samples_are_even_by_area_whatever_the_triangles():
    fine, coarse = trimesh.creation.icosphere(subdivisions=5, radius=0.1), trimesh.creation.box((0.2, 0.2, 0.2))
    coarse.apply_translation((1, 0, 0))
    both = as_mesh(trimesh.util.concatenate([fine, coarse]))
    points = sample_surface(both, 20_000).points
    share = float((points[:, 0] < 0.5).mean())
    # equal slices of the area: the count is right to one point
    assert share == pytest.approx(fine.area / (fine.area + coarse.area), abs=1e-4)
    np.testing.assert_array_equal(points, sample_surface(both, 20_000).points)


def test_nothing_to_measure_against():
    with pytest.raises(MeshError):
        surface_of(Mesh(np.zeros((2, 3))))
    with pytest.raises(MeshError):
        surface_of(Mesh(np.zeros((3, 3)), np.array([[0, 1, 2]], np.int32)))
