"""Edges of rendered squares, whose outline is known exactly."""

import numpy as np
import pytest

from fusion.geometry.camera import Camera
from fusion.geometry.pose import about_axis
from fusion.mesh.mesh import Mesh
from fusion.sensor.edges.nearest import REACH_PX
from fusion.simulation.rendering.render import Channels, RayCaster, render
from fusion.simulation.scene.shapes import joined

CAMERA = Camera(96, 80, 90.0, 91.0, 47.3, 40.2)
EDGES = Channels(edges=True)


def square(half: float, z: float, angle: float = 0.0, grey: int = 200) -> Mesh:
    """A frontal square about the optical axis [m], turned in its plane [rad]."""
    c, s = half * np.cos(angle), half * np.sin(angle)
    corners = np.array([[c - s, s + c, z], [-c - s, c - s, z], [-c + s, -s - c, z], [c + s, -c + s, z]])
    return Mesh(corners, np.array([[0, 1, 2], [0, 2, 3]], np.int32), colors=np.full((4, 3), grey, np.uint8))


def outline(camera: Camera, half: float, z: float, angle: float) -> tuple[np.ndarray, np.ndarray]:
    """Signed distance [px] of every pixel to the four sides (h, w, 4), positive inside, and their outward angle."""
    corners = camera.project(square(half, z, angle).vertices)
    v, u = np.mgrid[0 : camera.height, 0 : camera.width]
    pixels, middle = np.dstack([u, v]).astype(float), corners.mean(axis=0)
    inside, outward = [], []
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        normal = np.array([b[1] - a[1], a[0] - b[0]]) / np.linalg.norm(b - a)
        normal *= np.sign(normal @ (a - middle))
        inside.append((a - pixels) @ normal)
        outward.append(np.arctan2(normal[1], normal[0]))
    return np.stack(inside, axis=2), np.array(outward)


@pytest.mark.parametrize("angle", [0.0, 0.2, 0.62, np.pi / 4])
def test_distance_and_side_of_a_slanted_square(angle):
    view = render(joined([square(0.3, 1.0, angle), square(4, 2.0, grey=100)]), CAMERA, np.eye(4), EDGES)
    inside, outward = outline(CAMERA, 0.3, 1.0, angle)
    nearest, side = inside.min(axis=2), inside.argmin(axis=2)
    second = np.sort(inside, axis=2)[..., 1]
    away_from_corners = second > REACH_PX
    near = away_from_corners & (np.abs(nearest) < REACH_PX - 0.1)
    assert near.sum() > 500
    # bisected to 1/64 px, half of which is left
    assert np.abs(view.edges.distance - np.abs(nearest))[near].max() < 0.03
    far = np.abs(nearest) > REACH_PX + 0.1
    assert np.isinf(view.edges.distance[far & (second > 0)]).all()
    clear = near & (np.abs(nearest) > 0.05)
    assert np.allclose(view.edges.jump[clear], np.where(nearest > 0, 1.0, -1.0)[clear], atol=1e-5)
    off = view.edges.direction - np.where(nearest > 0, outward[side], outward[side] + np.pi)
    # 1/64 px at the ends of a line piece turn a direction most close to the edge
    assert np.abs(np.angle(np.exp(1j * off)))[near & (np.abs(nearest) > 1)].max() < 0.1


def test_light_across_an_edge_follows_reflectance_and_distance():
    view = render(joined([square(0.3, 1.0), square(4, 2.0, grey=100)]), CAMERA, np.eye(4), EDGES)
    # half the reflectance and twice the distance; neighbours differ by 1 px of incidence and of range
    inside = view.edges.jump > 0
    outside = view.edges.jump < 0
    close = view.edges.distance < 2
    assert view.edges.light[inside & close] == pytest.approx(0.125, rel=0.1)
    assert view.edges.light[outside & close] == pytest.approx(8.0, rel=0.1)
    assert (view.edges.light[np.isinf(view.edges.distance)] == 1).all()


def test_where_the_surface_ends_is_an_edge_without_jump_and_light():
    view = render(square(0.3, 1.0, 0.2), CAMERA, np.eye(4), EDGES)
    inside, _ = outline(CAMERA, 0.3, 1.0, 0.2)
    near = (np.abs(inside.min(axis=2)) < 3) & (np.sort(inside, axis=2)[..., 1] > REACH_PX)
    assert np.abs(view.edges.distance - np.abs(inside.min(axis=2)))[near].max() < 0.03
    assert not view.edges.jump.any() and not view.edges.light[near].any()


def test_with_lens_distortion_the_edge_is_where_its_points_project():
    lens = Camera(96, 80, 90.0, 91.0, 47.3, 40.2, distortion=(0.1, -0.05, 0.001, -0.002, 0.01))
    view = render(joined([square(0.3, 1.0, 0.2), square(4, 2.0)]), lens, np.eye(4), EDGES)
    corners = square(0.3, 1.0, 0.2).vertices
    share = np.linspace(0.1, 0.9, 800)[:, None]
    side = lens.project((1 - share) * corners[0] + share * corners[1])
    for u, v in np.rint(side[200:600:20]).astype(int):
        true = np.hypot(*(side - [u, v]).T).min()
        assert view.edges.distance[v, u] == pytest.approx(true, abs=0.03)


def test_slopes_and_creases_are_no_edges():
    steep = about_axis([0, 0, 2], [0, 1, 0], np.deg2rad(80))
    wall = square(20, 2.0)
    tilted = Mesh(wall.vertices @ steep[:3, :3].T + steep[:3, 3], wall.faces)
    corner = Mesh(  # two walls that meet in the optical axis at right angles, seen along their bisector
        np.array([[0, -3, 2.0], [0, 3, 2], [3, -3, -1], [3, 3, -1], [-3, -3, -1], [-3, 3, -1]]),
        np.array([[0, 1, 2], [2, 1, 3], [0, 4, 1], [4, 5, 1]], np.int32),
    )
    for mesh in (tilted, corner):
        view = render(mesh, CAMERA, np.eye(4), EDGES)
        seen = np.isfinite(view.depth)
        assert seen.mean() > 0.4
        holes = np.isinf(view.edges.distance) | (view.edges.jump == 0)
        assert holes.all()
        if seen.all():
            assert np.isinf(view.edges.distance).all()


def test_a_step_of_two_centimetres_on_a_slope_is_one():
    turn = about_axis([0, 0, 1], [0, 1, 0], np.deg2rad(50))
    meshes = [square(0.2, 0.98), square(4, 1.0)]
    meshes = [Mesh(m.vertices @ turn[:3, :3].T + turn[:3, 3], m.faces) for m in meshes]
    view = render(joined(meshes), CAMERA, np.eye(4), EDGES)
    front = RayCaster(meshes[0]).view(CAMERA, np.eye(4)).depth
    on = np.isfinite(front)
    middle = on & ~np.isnan(np.roll(front, 2, 1)) & np.isnan(np.roll(front, -2, 1))
    rows = slice(35, 45)
    assert (view.edges.distance[rows][middle[rows]] < 2.1).all()
    assert (view.edges.jump[rows][middle[rows]] > 0.01).all()


def test_a_thin_rod_has_two_edges():
    rod = Mesh(
        np.array([[-0.008, -2, 1.0], [0.008, -2, 1], [0.008, 2, 1], [-0.008, 2, 1]]),
        np.array([[0, 1, 2], [0, 2, 3]], np.int32),
    )
    view = render(joined([rod, square(4, 2.0)]), CAMERA, np.eye(4), EDGES)
    column = CAMERA.project(np.array([[-0.008, 0, 1], [0.008, 0, 1]]))[:, 0]
    u = np.arange(CAMERA.width)
    expected = np.abs(u[:, None] - column).min(axis=1)
    near = expected < 7
    assert np.abs(view.edges.distance[40] - expected)[near].max() < 0.03
    on = (u > column[0]) & (u < column[1])
    assert on.any() and (view.edges.jump[40][on] > 0.9).all() and (view.edges.jump[40][near & ~on] < -0.9).all()


def test_the_outline_of_a_ball_is_a_circle_and_its_curvature_no_edge():
    camera, radius, away = Camera(160, 120, 150.0, 150.0, 79.6, 60.2), 0.3, 1.2
    azimuth, polar = np.meshgrid(np.linspace(0, 2 * np.pi, 301)[:-1], np.linspace(0, np.pi, 151), indexing="ij")
    unit = np.dstack([np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), np.cos(polar)]).reshape(-1, 3)
    i, j = (grid.ravel() for grid in np.meshgrid(np.arange(300), np.arange(150), indexing="ij"))
    a, b = i * 151 + j, (i + 1) % 300 * 151 + j
    faces = np.concatenate([np.column_stack([a, a + 1, b + 1]), np.column_stack([a, b + 1, b])]).astype(np.int32)
    ball = Mesh(radius * unit + [0, 0, away], faces)
    view = render(joined([ball, square(4, 2.0)]), camera, np.eye(4), EDGES)
    v, u = np.mgrid[0:120, 0:160]
    # rays touch the ball in a cone of the angle asin(R / z) about the axis
    outside = np.hypot(u - camera.cx, v - camera.cy) - 150.0 * radius / np.sqrt(away**2 - radius**2)
    near = np.abs(outside) < REACH_PX - 0.1
    # 300 sides: the polygon's sagitta is 40 * 0.02^2 / 8 = 0.002 px; pieces of a pixel of an arc add 1 / 8 r
    assert np.abs(view.edges.distance[near] - np.abs(outside[near])).max() < 0.03
    assert np.isinf(view.edges.distance[np.abs(outside) > REACH_PX + 0.1]).all()
    clear = near & (np.abs(outside) > 0.05)
    assert np.array_equal(view.edges.jump[clear] > 0.5, outside[clear] < 0)
    assert np.array_equal(view.edges.jump[clear] < -0.5, outside[clear] > 0)


@pytest.mark.parametrize("beside", [0.7, 3.2])
def test_an_edge_beside_the_image_is_one_beside_its_pixels(beside):
    """A camera that stands a little elsewhere has it in its picture."""
    half = (CAMERA.width - 1 + beside - CAMERA.cx) / CAMERA.fx
    view = render(joined([square(half, 1.0), square(4, 2.0, grey=100)]), CAMERA, np.eye(4), EDGES)
    at = np.s_[20:60, -4:]
    assert np.allclose(view.edges.distance[at], beside + np.arange(3, -1, -1), atol=0.03)
    assert np.allclose(view.edges.jump[at], 1.0) and np.allclose(view.edges.direction[at], 0.0, atol=0.01)
    assert view.edges.distance.shape == CAMERA.shape and view.camera is CAMERA
