"""What stands behind the object is known wherever it was seen, and the object itself is never taken for it."""

import numpy as np
import pytest

from fusion.geometry import pose
from fusion.geometry.camera import Camera
from fusion.simulation.demo.demo import looking_at
from fusion.simulation.rendering.render import RayCaster
from fusion.simulation.scene.shapes import box, joined
from fusion.turntable.axis import Axis
from fusion.turntable.turning.moving import find_moving, find_wall
from fusion.turntable.turning.still_background import standing
from fusion.turntable.views import Region

CAMERA = Camera(320, 240, 300.0, 300.0, 159.5, 119.5)
T_WORLD_CAMERA = looking_at(np.array([0.5, 0.0, 0.12]), np.array([0.0, 0.0, 0.1]))
LOW, HIGH = (-0.03, -0.06, 0.0), (0.03, 0.06, 0.2)  # turns about z: its corners go round at 0.067 m
FRAMES = 20


def sigma(depth):
    return np.full_like(depth, 0.001)


@pytest.fixture(scope="module")
def scene():
    """Depth images of a box turned before a wall 20 mm behind its circle, and which pixels show the box."""
    wall = box((-0.15, -1.0, -0.5), (-0.087, 1.0, 1.0), (200, 200, 200))
    table = box((-0.09, -0.5, -0.05), (0.4, 0.5, 0.0), (120, 90, 60))
    random, depths, shown = np.random.default_rng(1), [], []
    still = RayCaster(joined([wall, table])).view(CAMERA, T_WORLD_CAMERA).depth
    for k in range(FRAMES):
        block = box(LOW, HIGH, (180, 60, 60))
        turn = pose.about_axis([0, 0, 0], [0, 0, 1], np.deg2rad(18.5 * k))
        turned = type(block)(pose.transform(turn, block.vertices), block.faces, colors=block.colors)
        depth = RayCaster(joined([wall, table, turned])).view(CAMERA, T_WORLD_CAMERA).depth
        shown.append(depth < still - 0.012)  # twice the least difference: at its foot it is as far as the table
        depths.append((depth + random.normal(0, 0.0007, depth.shape)).astype(np.float32))
    return np.stack(depths), np.stack(shown)


def test_the_box_before_a_near_wall_is_told_from_it(scene):
    depths, shown = scene
    found = find_moving(depths, CAMERA, sigma)
    before = ~(depths >= found.wall)
    # its faces too that always hide what is behind them, but for the border in the middle where they touch the table
    assert (before & shown).sum() > 0.98 * shown.sum()
    assert (before & ~shown)[:, :200].mean() < 0.01
    near = pose.transform(T_WORLD_CAMERA, found.points)
    assert np.percentile(near[:, 0], 0.5) > -0.075  # the wall begins at -0.087


def test_an_arm_that_passes_now_and_then_leaves_the_corner_behind_it_known(scene):
    depths, _ = scene
    corner = np.s_[150:175, 20:60]  # where the wall stands on the table no plane goes on
    passed = depths.copy()
    passed[::6, corner[0], corner[1]] -= 0.2
    wall = find_moving(passed, CAMERA, sigma).wall[corner]
    middle = np.median(depths, axis=0)[corner]
    assert (wall < middle).mean() > 0.95 and (wall > middle - 0.03).all()


def test_a_box_that_holds_the_wall_still_tells_it(scene):
    depths, shown = scene
    wall = find_wall(depths, CAMERA, sigma, (np.array([-0.2, -0.15, 0.3]), np.array([0.2, 0.2, 0.75])))
    before = ~(depths >= wall)
    assert (before & shown).sum() > 0.98 * shown.sum() and (before & ~shown)[:, :200].mean() < 0.01
    assert find_wall(depths[:1].repeat(8, axis=0), CAMERA, sigma, (np.full(3, -1.0), np.full(3, 1.0))) is None


def test_only_what_would_stand_in_the_way_when_turned_stands():
    """Before a plate and a post that turn with the object nothing is lost; the wall behind is none of it."""
    plate = box((-0.5, -0.5, -0.05), (0.5, 0.5, 0.0), (120, 90, 60))
    angle = np.linspace(0, 2 * np.pi, 60, endpoint=False)
    places = 0.03 * np.column_stack([np.cos(angle), np.sin(angle)])
    posts = [box((x - 0.01, y - 0.01, 0.0), (x + 0.01, y + 0.01, 0.1), (9, 9, 9)) for x, y in places]
    wall = box((-0.15, -1.0, -0.5), (-0.087, 1.0, 1.0), (200, 200, 200))
    depth = RayCaster(joined([plate, wall, *posts])).view(CAMERA, T_WORLD_CAMERA).depth.astype(np.float32)
    world = pose.transform(T_WORLD_CAMERA, CAMERA.points(depth).reshape(-1, 3).astype(float)).reshape(*depth.shape, 3)
    T = pose.inverse(T_WORLD_CAMERA)
    axis = Axis(T[:3, 3], T[:3, 2])
    found = standing(depth, CAMERA, axis, 0.12)
    radius = np.hypot(world[..., 0], world[..., 1])
    on_wall = (world[..., 0] < -0.086) & (world[..., 0] > -0.088) & (world[..., 2] > 0.03) & (radius < 0.115)
    # turned, parts of it leave the image or fall beside the post
    assert on_wall.any() and found[on_wall].mean() > 0.85
    assert found[(radius < 0.05) & (world[..., 2] > 0.001)].mean() < 0.02
    assert found[(world[..., 2] < 0.001) & (radius < 0.08)].mean() < 0.05


def test_a_region_is_cut_with_its_images():
    wall = np.arange(12, dtype=np.float32).reshape(3, 4)
    region = Region(np.zeros(3), np.ones(3), wall > 5, wall).cut(np.s_[1:3, 2:])
    assert np.array_equal(region.wall, wall[1:3, 2:]) and region.still.shape == (2, 2)
