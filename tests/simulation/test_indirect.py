"""One bounce in a corner of two walls, against an integral over the surface of the other wall."""

from dataclasses import replace

import numpy as np
import pytest

from fusion.geometry.camera import Camera, crop
from fusion.mesh.mesh import Mesh
from fusion.simulation.rendering.indirect import FAINT, Bounce
from fusion.simulation.rendering.render import Channels, render
from fusion.simulation.scene.shapes import joined

CAMERA = Camera(96, 72, 80.0, 80.0, 47.3, 35.6)
DEPTH, HALF, LONG = 2.0, 0.5, 0.8  # [m] of the corner; half height and length of the walls
ALONG = np.array([np.sqrt(0.5), 0.0, -np.sqrt(0.5)])  # of the right wall, from the corner towards the camera
NORMAL = np.array([-np.sqrt(0.5), 0.0, -np.sqrt(0.5)])
MIRROR = np.array([-1.0, 1.0, 1.0])  # the left wall is the right one mirrored
FINE = Channels(indirect=Bounce(cell_px=3))


def wall(side: int, reflectance: float) -> Mesh:
    """The right (1) or left (-1) wall."""
    mirror = MIRROR if side < 0 else np.ones(3)
    corner = np.array([0, 0, DEPTH])
    vertices = [
        corner + s * LONG * ALONG + t * HALF * np.array([0, 1, 0]) for s, t in ((0, -1), (0, 1), (1, 1), (1, -1))
    ]
    faces = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
    return Mesh(np.array(vertices) * mirror, faces, scalars={"reflectance": np.full(4, reflectance, np.float32)})


def corner(right: float, left: float) -> Mesh:
    return joined([wall(1, right), wall(-1, left)])


def integral(point: np.ndarray, reflectance: float) -> tuple[float, float]:
    """Ratio and mean extra path at a point (3,) of the left wall, from all of the right wall, midpoint rule."""
    n = 300
    s, t = (np.arange(n) + 0.5) / n * LONG, ((np.arange(n) + 0.5) / n * 2 - 1) * HALF
    other = (s[:, None, None] * ALONG + t[None, :, None] * np.array([0.0, 1, 0]) + [0, 0, DEPTH]).reshape(-1, 3)
    way = point - other
    d, r_a, r_b = np.linalg.norm(way, axis=1), np.linalg.norm(point), np.linalg.norm(other, axis=1)
    irradiance = -(other @ NORMAL) / r_b**3  # cos / r^2 under a lamp of intensity 1
    gain = (way @ NORMAL) * -(way @ (NORMAL * MIRROR)) / d**4 * (LONG / n) * (2 * HALF / n)
    light = reflectance / np.pi * irradiance * gain
    direct = -(point @ (NORMAL * MIRROR)) / r_a**3
    return light.sum() / direct, (light * (r_b + d - r_a)).sum() / light.sum() / 2


def test_a_corner_is_as_bright_as_the_integral_says():
    view = render(corner(0.8, 0.3), CAMERA, np.eye(4), FINE)
    points = CAMERA.points(view.depth)
    for v, u in ((35, 20), (35, 30), (36, 40), (20, 35), (50, 28)):
        assert np.isfinite(view.depth[v, u]) and points[v, u, 0] < 0
        ratio, path = integral(points[v, u].astype(float), 0.8)
        assert ratio > 0.02
        # patches of 3 px, 7 of which are between the corner and the nearest of these pixels
        assert view.indirect.ratio[v, u] == pytest.approx(ratio, rel=0.05)
        assert view.indirect.path[v, u] == pytest.approx(path, rel=0.05)


def test_the_light_follows_the_other_walls_reflectance_alone():
    full, other = (render(corner(*r), CAMERA, np.eye(4), FINE).indirect for r in ((0.8, 0.8), (0.8, 0.2)))
    left = np.s_[20:50, 10:40]
    assert np.allclose(full.ratio[left], other.ratio[left], rtol=1e-4)
    half = render(corner(0.4, 0.2), CAMERA, np.eye(4), FINE).indirect
    assert np.allclose(2 * half.ratio[left], other.ratio[left], rtol=1e-4)
    black = render(corner(0.0, 0.8), CAMERA, np.eye(4), FINE).indirect
    assert not black.ratio[left].any() and not black.path[left].any()


def test_a_single_plane_sends_no_light_to_itself():
    view = render(wall(1, 0.8), CAMERA, np.eye(4), FINE)
    assert not view.indirect.ratio.any() and not view.indirect.path.any()


def test_what_stands_between_the_walls_holds_the_light_back():
    y, z = np.array([0, 1.0, 0]), np.array([0, 0, 1.0])
    card = Mesh(  # in the plane x = 0, which the camera sees edge-on: no ray meets it
        np.array([-y + 0.3 * z, y + 0.3 * z, y + DEPTH * z, -y + DEPTH * z]), np.array([[0, 1, 2], [0, 2, 3]], np.int32)
    )
    mesh = joined([wall(1, 0.8), wall(-1, 0.8), card])
    through = render(mesh, CAMERA, np.eye(4), replace(FINE, indirect=Bounce(3, shadows=False))).indirect.ratio
    held = render(mesh, CAMERA, np.eye(4), FINE).indirect.ratio
    assert through.max() > 0.1
    assert (held <= FAINT * through).all()  # what is left came from sources too faint to be looked at


def test_coarse_cells_give_nearly_the_same():
    fine, coarse = (
        render(corner(0.8, 0.8), CAMERA, np.eye(4), Channels(indirect=Bounce(cell))).indirect for cell in (2, 6)
    )
    inside = np.s_[16:56, 8:40]
    assert np.abs(coarse.ratio - fine.ratio)[inside].max() < 0.1 * fine.ratio[inside].max()


def test_nothing_in_sight_gives_no_light():
    view = render(Mesh(np.zeros((0, 3))), CAMERA, np.eye(4), FINE)
    assert not view.indirect.ratio.any() and not view.indirect.path.any()


def test_a_wall_beside_the_image_shines_into_it():
    """The lamp lights more than the camera sees."""
    half = crop(CAMERA, (slice(0, CAMERA.height), slice(0, 48)))  # it ends at the crease
    view = render(corner(0.8, 0.8), half, np.eye(4), Channels(indirect=Bounce(3, beyond=1.0)))
    points = half.points(view.depth)
    assert np.nanmax(points[..., 0]) < 0.02
    for v, u in ((35, 20), (35, 30), (20, 35)):
        ratio, path = integral(points[v, u].astype(float), 0.8)
        assert view.indirect.ratio[v, u] == pytest.approx(ratio, rel=0.05)
        assert view.indirect.path[v, u] == pytest.approx(path, rel=0.05)
    dark = render(corner(0.8, 0.8), half, np.eye(4), Channels(indirect=Bounce(3, beyond=0.0))).indirect
    assert not dark.ratio[:, :40].any()
