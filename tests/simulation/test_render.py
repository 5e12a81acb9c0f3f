"""The ray caster against shapes whose depth is known in closed form."""

import numpy as np
import pytest

from fusion.geometry.camera import Camera
from fusion.geometry.pose import about_axis, inverse, pose
from fusion.mesh.mesh import Mesh
from fusion.simulation.rendering.render import RayCaster, render
from fusion.simulation.scene.shapes import box, joined, sheet

CAMERA = Camera(64, 48, 60.0, 61.0, 30.7, 24.2, distortion=(0.08, -0.1, 0.001, -0.002, 0.02))
X, Y, Z = np.eye(3)


def wall(distance: float) -> Mesh:
    return sheet(-4 * X - 4 * Y + distance * Z, 8 * X, 8 * Y, lambda p: 100 + 10 * p[:, :1] + np.zeros((len(p), 3)))


def test_a_frontal_wall_has_one_depth_and_the_rays_own_incidence():
    view = render(wall(2.0), CAMERA, np.eye(4))
    assert np.abs(view.depth - 2.0).max() < 1e-5  # single precision of the ray caster
    expected = np.arctan(np.hypot(*np.moveaxis(CAMERA.rays(), 2, 0)))
    assert np.abs(view.incidence - expected).max() < 1e-3  # arccos of a single near 1
    assert np.allclose(view.normals, [0, 0, -1], atol=1e-5)


def test_points_of_the_image_lie_on_a_tilted_plane_and_project_back():
    T_world_camera = about_axis([0.1, 0, 2], [1, 2, 0.5], 0.5)
    view = render(wall(2.0), CAMERA, T_world_camera)
    points = CAMERA.points(view.depth).reshape(-1, 3)
    seen = np.isfinite(points[:, 2])
    world = points[seen] @ T_world_camera[:3, :3].T + T_world_camera[:3, 3]
    assert np.abs(world[:, 2] - 2.0).max() < 2e-5  # single precision at 4 m
    v, u = np.mgrid[0:48, 0:64]
    pixels = np.column_stack([u.ravel(), v.ravel()])[seen]
    # a tenth of the half pixel that a corner-based pixel convention would show
    assert np.abs(CAMERA.project(points[seen]) - pixels).max() < 0.05


def test_colour_is_interpolated_between_vertices():
    view = render(wall(2.0), CAMERA, np.eye(4))
    x = CAMERA.points(view.depth)[..., 0]
    # one count: vertex colours and the result are rounded to whole counts
    assert np.abs(view.color[..., 0] - (100 + 10 * x)).max() <= 1.5


def test_the_nearer_of_two_views_wins():
    block = box((-0.2, -0.2, 0.9), (0.2, 0.2, 1.1), (200, 10, 10))
    front, back = render(block, CAMERA, np.eye(4)), render(wall(2.0), CAMERA, np.eye(4))
    near = np.isfinite(front.depth)
    together = render(joined([block, wall(2.0)]), CAMERA, np.eye(4))
    assert np.array_equal(together.depth, np.where(near, front.depth, back.depth))
    assert np.array_equal(together.color, np.where(near[..., None], front.color, back.color))
    assert together.depth[24, 31] == pytest.approx(0.9, abs=1e-6)


def test_nothing_in_sight_is_missing_and_black():
    behind = pose(np.eye(3), [0, 0, 5])
    for mesh in (wall(2.0), Mesh(np.zeros((0, 3)))):
        view = RayCaster(mesh).view(CAMERA, behind)
        assert np.isnan(view.depth).all() and np.isnan(view.incidence).all() and not view.color.any()


def test_moving_camera_and_mesh_together_changes_nothing():
    T = about_axis([0.3, -0.1, 0.5], [0.2, 1, -0.4], 1.1)
    block = box((-0.2, -0.3, 0.9), (0.25, 0.2, 1.1), (200, 10, 10))
    moved = Mesh(block.vertices @ T[:3, :3].T + T[:3, 3], block.faces, colors=block.colors)
    first, second = render(block, CAMERA, np.eye(4)), render(moved, CAMERA, T)
    same = np.isfinite(first.depth) & np.isfinite(second.depth)
    assert same.sum() > 100
    assert np.abs(first.depth - second.depth)[same].max() < 1e-4  # a silhouette ray may graze another face
    assert np.allclose(inverse(T) @ T, np.eye(4))


def test_reflectance_is_the_grey_of_the_colours_or_a_value_of_its_own():
    view = render(wall(2.0), CAMERA, np.eye(4))
    x = CAMERA.points(view.depth)[..., 0]
    # colours are rounded to whole counts
    assert np.abs(view.reflectance - (100 + 10 * x) / 255).max() < 1.5 / 255
    own = Mesh(wall(2.0).vertices, wall(2.0).faces, scalars={"reflectance": 0.1 * wall(2.0).vertices[:, 0]})
    assert np.abs(render(own, CAMERA, np.eye(4)).reflectance - 0.1 * x).max() < 1e-5
    coloured = box((-0.5, -0.5, 0.9), (0.5, 0.5, 1.1), (255, 0, 0))
    assert np.nanmax(np.abs(render(coloured, CAMERA, np.eye(4)).reflectance - 1 / 3)) < 1e-6


def test_a_sphere_through_a_lens_has_depth_normals_and_incidence_of_the_formula():
    centre, radius = np.array([0.05, -0.03, 1.2]), 0.4
    azimuth, polar = np.meshgrid(np.linspace(0, 2 * np.pi, 401)[:-1], np.linspace(0, np.pi, 201), indexing="ij")
    unit = np.dstack([np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), np.cos(polar)]).reshape(-1, 3)
    i, j = (grid.ravel() for grid in np.meshgrid(np.arange(400), np.arange(200), indexing="ij"))
    a, b = i * 201 + j, (i + 1) % 400 * 201 + j
    faces = np.concatenate([np.column_stack([a, a + 1, b + 1]), np.column_stack([a, b + 1, b])]).astype(np.int32)
    view = render(Mesh(centre + radius * unit, faces, unit.astype(np.float32)), CAMERA, np.eye(4))
    rays = np.dstack([CAMERA.rays(), np.ones(CAMERA.shape)]).astype(float)
    square, along = (rays**2).sum(axis=2), rays @ centre
    root = along**2 - square * (centre @ centre - radius**2)
    inside = root > 0.01  # away from the outline, where the polyhedron ends earlier
    depth = (along - np.sqrt(np.where(inside, root, 0))) / square
    assert inside.sum() > 500
    # facets with diagonals of 9 mm lie up to L^2 / 8 R = 25 um below the sphere, along slanted rays more
    assert np.abs(view.depth - depth)[inside].max() < 1e-4
    normals = (rays * depth[..., None] - centre) / radius
    assert np.abs(view.normals - normals)[inside].max() < 3e-4  # 80 um off in depth, of 0.4 m
    cosine = -(normals * rays).sum(axis=2) / np.sqrt(square)
    assert np.abs(np.cos(view.incidence) - cosine)[inside].max() < 3e-4
