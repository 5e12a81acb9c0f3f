"""The ray caster against shapes whose depth is known in closed form."""

import numpy as np
import pytest

from fusion.geometry.camera import Camera
from fusion.geometry.pose import about_axis, inverse, pose
from fusion.mesh.mesh import Mesh
from fusion.simulation.render import RayCaster, nearest, render
from fusion.simulation.shapes import box, joined, sheet

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
    apart = nearest(render(block, CAMERA, np.eye(4)), render(wall(2.0), CAMERA, np.eye(4)))
    together = render(joined([block, wall(2.0)]), CAMERA, np.eye(4))
    assert np.array_equal(apart.depth, together.depth)
    assert np.array_equal(apart.color, together.color)
    assert apart.depth[24, 31] == pytest.approx(0.9, abs=1e-6)


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
