"""The plate is found and cut away, tilted and bent as an uncalibrated camera shows it."""

import numpy as np
import pytest

from fusion.geometry import pose
from fusion.turntable.axis import Axis
from fusion.turntable.plate import above_plate, plate_height
from fusion.turntable.views import View

CLEAR = 0.004


def plate(tilt, bend, noise=0.0003, seed=0):
    """(n, 3) points of a plate of 30 cm, and its height at (n, 2) places."""

    def height(xy):
        return 0.002 + xy @ tilt + bend * (xy**2).sum(axis=1)

    rng = np.random.default_rng(seed)
    xy = rng.uniform(-0.15, 0.15, (20_000, 2))
    xy = xy[np.linalg.norm(xy, axis=1) < 0.15]
    return np.column_stack([xy, height(xy) + rng.normal(0, noise, len(xy))]), height


def block(top, height, half=0.05, n=60):
    """(n, 3) points and normals of a block whose level top is `top` above the plate's middle."""
    side = np.linspace(-half, half, n)
    x, y = (g.ravel() for g in np.meshgrid(side, side))
    points, normals = [np.column_stack([x, y, np.full(n * n, 0.002 + top)])], [np.tile([0, 0, 1.0], (n * n, 1))]
    for turn in range(4):
        R = pose.about_axis([0, 0, 0], [0, 0, 1], turn * np.pi / 2)[:3, :3]
        foot = np.column_stack([np.full(n * n, half), x, y])
        low = height((foot @ R.T)[:, :2])
        foot[:, 2] = low + (y + half) / (2 * half) * (0.002 + top - low)
        points.append(foot @ R.T)
        normals.append(np.tile(R @ [1.0, 0, 0], (n * n, 1)))
    return np.concatenate(points), np.concatenate(normals)


@pytest.mark.parametrize("top", [0.08, 0.02], ids=["block", "book"])
@pytest.mark.parametrize(
    ("tilt", "bend"), [((0.0, 0.0), 0.0), ((0.02, -0.01), 0.0), ((0.01, 0.01), 0.2), ((0.0, 0.02), -0.2)]
)
def test_the_plate_goes_and_the_object_stays(tilt, bend, top):
    ground, height = plate(np.array(tilt), bend)
    ground = ground[np.abs(ground[:, :2]).max(axis=1) > 0.05]  # hidden below the block
    solid, solid_normals = block(top, height)
    vertices = np.concatenate([ground, solid])
    normals = np.concatenate([np.tile([0, 0, 1.0], (len(ground), 1)), solid_normals]).astype(np.float32)
    kept = above_plate(vertices, normals, CLEAR)
    # noise of 0.3 mm never reaches 4 mm; the fitted surface may be off by half of what is cut
    assert not kept[: len(ground)].any()
    over = vertices[:, 2] - height(vertices[:, :2])
    assert kept[over > CLEAR + 0.002].all()
    assert not kept[len(ground) :][over[len(ground) :] < CLEAR - 0.002].any()


def test_without_a_plate_the_height_alone_decides():
    vertices = np.column_stack([np.zeros((50, 2)), np.linspace(-0.05, 0.1, 50)])
    kept = above_plate(vertices, np.tile(np.float32([1, 0, 0]), (50, 1)), CLEAR)
    assert (kept == (vertices[:, 2] > CLEAR)).all()


def test_the_height_of_a_plate_that_is_seen(owl_scene):
    """The owl's own foot is no plate; a sheet of level points below it is one."""
    views = owl_scene.views()
    axis = owl_scene.axis
    x, y = (g.ravel() for g in np.meshgrid(np.linspace(-0.14, 0.14, 60), np.linspace(-0.14, 0.14, 60)))
    across = axis.across()
    sheet = axis.point + x[:, None] * across[0] + y[:, None] * across[1] - 0.001 * axis.direction
    with_plate = []
    for v in views:
        points, normals = v.map.points.copy(), v.map.normals.copy()
        points.reshape(-1, 3)[: len(sheet)] = sheet
        normals.reshape(-1, 3)[: len(sheet)] = axis.direction
        with_plate.append(View(type(v.map)(v.map.camera, points, normals, v.map.sigma), v.points, v.normals, v.sigma))
    assert plate_height(with_plate, axis) == pytest.approx(-0.001, abs=0.0005)
    # heights count from the axis' point
    higher = Axis(axis.point + 0.02 * axis.direction, axis.direction)
    assert plate_height(with_plate, higher) == pytest.approx(-0.021, abs=0.0005)


def test_no_plate_no_height(owl_scene):
    views = owl_scene.views()
    for v in views:  # the owl without the level covers of its books
        height = owl_scene.axis.distance(v.map.points.reshape(-1, 3))[1].reshape(v.map.points.shape[:2])
        v.map.normals[height < 0.06] = np.nan
    assert plate_height(views, owl_scene.axis) is None
