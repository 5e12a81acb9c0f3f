"""Several bodies in one picture, how they move, and two pictures as one."""

from dataclasses import fields, is_dataclass

import numpy as np
import pytest

from fusion.geometry.camera import Camera
from fusion.geometry.pose import about_axis, inverse, pose, transform
from fusion.mesh.mesh import Mesh
from fusion.simulation.rendering.casting import Body
from fusion.simulation.rendering.indirect import Bounce
from fusion.simulation.rendering.motion import twist_between
from fusion.simulation.rendering.render import Channels, RayCaster, render, view_of
from fusion.simulation.scene.shapes import box, joined, sheet

CAMERA = Camera(80, 60, 75.0, 76.0, 38.7, 30.2, distortion=(0.08, -0.1, 0.001, -0.002, 0.02))
ALL = Channels(edges=True, lit=-0.075, motion=True, indirect=Bounce(6))
X, Y, Z = np.eye(3)


def wall() -> Mesh:
    return sheet(-4 * X - 4 * Y + 2 * Z, 8 * X, 8 * Y, lambda p: 100 + 10 * p[:, :1] + np.zeros((len(p), 3)))


def block() -> Mesh:
    return box((-0.3, -0.2, 0.9), (0.2, 0.25, 1.1), (200, 100, 10))


def images(view) -> dict[str, np.ndarray]:
    """Every image of a view by name, those of its parts as well."""
    found = {}
    for entry in fields(view):
        value = getattr(view, entry.name)
        if isinstance(value, np.ndarray):
            found[entry.name] = value
        elif is_dataclass(value) and not isinstance(value, Camera):
            found |= {f"{entry.name}.{name}": image for name, image in images(value).items()}
    return found


def test_bodies_are_seen_as_their_joined_mesh():
    T = about_axis([0.1, 0, 1], [1, 2, 0.5], 0.5)
    moved = Mesh(transform(T, block().vertices), block().faces, colors=block().colors)
    one = render(joined([moved, wall()]), CAMERA, np.eye(4), ALL)
    two = view_of((Body(RayCaster(wall())), Body(RayCaster(block()), T)), CAMERA, np.eye(4), ALL)
    # rays in the block's own frame round differently; a ray on its outline may miss it
    for name, image in images(one).items():
        other = images(two)[name]
        both = np.isfinite(image) & np.isfinite(other)
        off = np.abs(image[both].astype(float) - other[both])
        assert np.mean(off > 1e-3 if image.dtype != np.uint8 else off > 1) < 0.01, name
    assert {"edges.jump", "indirect.path", "velocity", "turning", "lit"} <= set(images(two))


def test_the_shadow_of_one_body_falls_on_another():
    both = view_of((Body(RayCaster(wall())), Body(RayCaster(block()))), CAMERA, np.eye(4), Channels(lit=-0.3))
    assert both.lit.min() == 0 and both.baseline == -0.3
    assert render(wall(), CAMERA, np.eye(4), Channels(lit=-0.3)).lit.min() == 1


def test_velocity_is_the_displacement_over_the_time():
    seconds, T_before = 0.04, about_axis([0.1, 0, 1], [1, 2, 0.5], 0.5)
    T_after = pose(about_axis([0, 0, 0], [0.2, 1, -0.3], 0.002)[:3, :3], [0.0005, -0.0002, 0.0009]) @ T_before
    T_world_camera = about_axis([0.3, 0, 0.2], [0, 1, 0.1], 0.2)
    body = Body(RayCaster(block()), T_before, twist_between(T_before, T_after, seconds), turning=True)
    view = view_of((Body(RayCaster(wall())), body), CAMERA, T_world_camera, ALL)
    on = view.turning
    assert 50 < on.sum() < on.size / 2
    points = CAMERA.points(view.depth)[on].astype(float)
    motion = inverse(T_world_camera) @ T_after @ inverse(T_before) @ T_world_camera
    expected = (transform(motion, points) - points) / seconds
    # the motion turns by 2 mrad within the time, so displacement and velocity differ by half of that
    assert np.abs(view.velocity[on] - expected).max() < 2e-3 * np.abs(expected).max()
    assert not view.velocity[~on & np.isfinite(view.depth)].any()
    # the same motion of the camera, the other way
    still = Body(RayCaster(block()), T_before, turning=True)
    other = view_of((still,), CAMERA, T_world_camera, ALL, camera_twist=-body.twist)
    assert np.allclose(other.velocity[on], view.velocity[on], atol=1e-6)


@pytest.mark.parametrize("angle", [0.0, 1e-9, 0.3, 2.0])
def test_a_twist_leads_from_one_pose_to_the_other(angle):
    T_before = about_axis([0.1, 0, 1], [1, 2, 0.5], 0.7)
    T_after = pose(about_axis([0, 0, 0], [0.2, 1, -0.3], angle)[:3, :3], [0.05, -0.02, 0.09]) @ T_before
    twist, steps = twist_between(T_before, T_after, 0.5), 1000
    w, v = twist[:3], twist[3:]
    point, dt = np.array([0.3, -0.2, 0.8]), 0.5 / steps
    for _ in range(steps):  # midpoint rule
        half = point + dt / 2 * (np.cross(w, point) + v)
        point = point + dt * (np.cross(w, half) + v)
    expected = transform(T_after @ inverse(T_before), np.array([0.3, -0.2, 0.8]))
    assert np.allclose(point, expected, atol=1e-5)


def test_no_body_is_an_empty_picture():
    view = view_of((), CAMERA, np.eye(4), ALL)
    assert np.isnan(view.depth).all() and np.isinf(view.edges.distance).all() and (view.lit == 1).all()
    assert not view.turning.any() and np.isnan(view.velocity).all() and not view.color.any()
