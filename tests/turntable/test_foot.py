"""The level surface under the object, from what was seen behind it."""

import numpy as np

from fusion.simulation.demo.demo import looking_at
from fusion.turntable.guess.start import axis_through
from fusion.turntable.table.foot import foot_normal

T = looking_at(np.array([0.5, 0.0, 0.35]), np.array([0.0, 0.0, 0.06]))  # world from camera
UP = T[:3, :3].T @ [0, 0, 1]


def to_camera(points):
    return (points - T[:3, 3]) @ T[:3, :3]


def ground(random, count=4000):
    """The table around and a wall 15 cm behind, as the camera sees them beside the object."""
    table = np.column_stack([random.uniform(-0.15, 0.2, count), random.uniform(-0.2, 0.2, count), np.zeros(count)])
    wall = np.column_stack([np.full(count, -0.15), random.uniform(-0.2, 0.2, count), random.uniform(0, 0.15, count)])
    points = np.concatenate([table, wall])
    return to_camera(points + random.normal(0, 0.0005, points.shape))


def ball(random, radius=0.07, count=3000):
    """What is seen of a ball: nothing below the height where the sight touches it."""
    normals = random.normal(size=(count, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    points = normals * radius + [0, 0, radius]
    sight = T[:3, 3] - points
    return to_camera(points[np.sum(sight * normals, axis=1) > 0.2 * np.linalg.norm(sight, axis=1)])


def test_the_table_under_a_ball_whose_lower_half_is_hidden():
    random = np.random.default_rng(0)
    found = foot_normal(ground(random), ball(random))
    assert np.rad2deg(np.arccos(found @ UP)) < 0.5


def test_a_wall_alone_is_no_foot():
    random = np.random.default_rng(1)
    wall = ground(random)[4000:]
    assert foot_normal(wall, ball(random)) is None


def test_too_little_behind_is_no_foot():
    random = np.random.default_rng(2)
    assert foot_normal(ground(random, 20), ball(random)) is None


def test_an_axis_goes_through_the_middle_of_a_ball():
    points, middle = ball(np.random.default_rng(3)), to_camera(np.array([0, 0, 0.07]))
    assert axis_through(UP, points).distance(middle[None])[0][0] < 0.006


def test_what_hangs_above_the_table_does_not_stand_on_it():
    random = np.random.default_rng(0)
    assert foot_normal(ground(random), ball(random) + 0.12 * UP) is None
