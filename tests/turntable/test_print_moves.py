"""A printed ball near the axis: its depth hardly changes as it turns, its print tells that it is no background."""

import numpy as np
import pytest

from fusion.errors import TrackingError
from fusion.geometry import pose
from fusion.geometry.camera import Camera
from fusion.simulation.demo.demo import looking_at
from fusion.simulation.rendering.render import RayCaster
from fusion.simulation.scene.shapes import box, joined
from fusion.turntable.turning.moving import find_moving
from fusion.turntable.turning.print_moves import bent_beyond, outline_of, print_moves

CAMERA = Camera(320, 240, 330.0, 330.0, 159.5, 119.5)
T_WORLD_CAMERA = looking_at(np.array([0.5, 0.0, 0.25]), np.array([0.0, 0.0, 0.07]))
RADIUS, ASIDE, FRAMES = 0.07, 0.008, 20


def sigma(depth):
    return np.full_like(depth, 0.0007)


def patches(points):
    """Brightness of places: fields of about 10 mm."""
    cell = np.floor((points + 0.9001) / 0.01).astype(int)
    return ((cell @ [7, 13, 29] + cell[..., 0] * cell[..., 2] * 3) * 37) % 170 + 40.0


def made(aside, plate=None):
    """Depths, brightness of each frame with a printed ball, on a plate that turns with it, and which pixels show it."""
    wall = box((-0.25, -1.0, -0.5), (-0.2, 1.0, 1.0), (200, 200, 200))
    top = 0.0 if plate is None else -0.03
    table = box((-0.2, -0.5, -0.05), (0.4, 0.5, top), (120, 90, 60))
    carrier = None if plate is None else RayCaster(plate)
    behind = RayCaster(joined([wall, table])).view(CAMERA, T_WORLD_CAMERA).depth
    rays = np.concatenate([CAMERA.rays(), np.ones((*CAMERA.shape, 1))], axis=-1)
    random, depths, images, shown = np.random.default_rng(2), [], [], []
    for k in range(FRAMES):
        turn = pose.about_axis([0, 0, 0], [0, 0, 1], np.deg2rad(18.0 * k))
        T = pose.inverse(turn @ pose.pose(np.eye(3), [aside, 0, RADIUS])) @ T_WORLD_CAMERA
        along, start = rays @ T[:3, :3].T, T[:3, 3]
        a, b = (along**2).sum(axis=-1), along @ start
        with np.errstate(invalid="ignore"):
            ball = (-b - np.sqrt(b**2 - a * (start @ start - RADIUS**2))) / a
        below, on_plate = behind, np.zeros(CAMERA.shape, bool)
        if carrier is not None:
            own = carrier.view(CAMERA, pose.inverse(turn) @ T_WORLD_CAMERA).depth
            on_plate = np.isfinite(own)
            below = np.where(on_plate, own, behind)
        with np.errstate(invalid="ignore"):
            first = ball < below
        depth = np.where(first, ball, below)
        there = rays @ T_WORLD_CAMERA[:3, :3].T * below[..., None] + T_WORLD_CAMERA[:3, 3]
        there = np.where(on_plate[..., None], pose.transform(pose.inverse(turn), there), there)
        gray = np.where(first, patches(along * np.nan_to_num(ball)[..., None] + start), patches(there))
        depths.append((depth + random.normal(0, 0.0007, depth.shape)).astype(np.float32))
        images.append(gray)
        shown.append(first)
    return np.stack(depths), np.stack(images), np.stack(shown)


@pytest.fixture(scope="module")
def scene():
    return made(ASIDE)


def pictures(gray, seed=0):
    """(h, w, 3) each, with noise and an exposure of its own."""
    random = np.random.default_rng(seed)
    seen = [g * random.uniform(0.8, 1.2) + random.normal(0, 3, g.shape) for g in gray]
    return [np.repeat(s[..., None], 3, axis=-1).clip(0, 255).astype(np.uint8) for s in seen]


def asked(depths, images, outline):
    far = np.nanquantile(depths, 0.9, axis=0).astype(np.float32)
    return print_moves(depths, images, (far, np.full(CAMERA.shape, np.float32(0.006))), outline)


def test_from_a_part_of_its_rim_the_whole_ball_is_found(scene):
    """A triangulating camera sees nothing beside it on one side: what moves by depth is a crescent on the other."""
    depths, gray, shown = scene
    crescent = shown.any(axis=0) & ~np.roll(shown.all(axis=0), -12, axis=1)
    crescent[:, : CAMERA.width // 2] = False
    always = shown.all(axis=0)
    assert (crescent & always).sum() < 0.3 * always.sum()
    found = asked(depths, pictures(gray), crescent)
    assert (found & always).sum() > 0.97 * always.sum()
    assert not (found & ~shown.any(axis=0)).any()


def test_the_front_of_a_ball_that_stands_still_in_depth_is_no_background():
    depths, gray, shown = made(0.003)
    without = find_moving(depths, CAMERA, sigma)
    assert (without.still & shown.all(axis=0)).sum() > 0.5 * shown.all(axis=0).sum(), "or this asks for nothing"
    found = find_moving(depths, CAMERA, sigma, pictures(gray))
    before = (depths < found.wall) & ~found.still
    assert (before & shown).sum() > 0.96 * shown.sum()
    assert (before & ~shown).mean() < 0.01


def test_a_ball_on_a_plate_that_moves_much_is_no_background():
    """Little of what moves stands still: the ball's upper half was left out, which nothing moves but its print."""
    depths, gray, shown = made(0.0, box((-0.04, -0.04, -0.012), (0.2, 0.04, 0.0), (120, 90, 60)))
    ball, (high, middle) = shown.all(axis=0), (above(2 * RADIUS), above(RADIUS))
    without = find_moving(depths, CAMERA, sigma)
    assert without.still[ball].mean() > 0.5, "or this asks for nothing"
    found = find_moving(depths, CAMERA, sigma, pictures(gray))
    assert found.still[ball].mean() < 0.1
    assert found.low[1] < high[1] + 0.01 < middle[1]  # y looks down


def test_a_printed_plate_and_a_shadow_on_the_wall_are_nothing_bent():
    """Of a box on its printed plate these would take what stands behind away, and nothing of the box is lost."""
    rays = CAMERA.rays()
    plate = (1 / (1.2 + 2.0 * rays[..., 1])).astype(np.float32)
    usual = (
        plate + np.random.default_rng(4).normal(0, 0.001, plate.shape).astype(np.float32),
        np.full_like(plate, 0.006),
    )
    moves, outline = np.zeros(plate.shape, bool), np.zeros(plate.shape, bool)
    moves[100:200, 60:260], outline[90:150, 80:240] = True, True
    reach = float(plate[moves].min()), float(plate[moves].max())
    beyond = (moves & ~outline).sum()
    assert bent_beyond(moves, usual, outline, reach).sum() < 0.02 * beyond
    usual[0][moves & ~outline] += 1.0
    assert not bent_beyond(moves, usual, outline, reach).any()
    ball = 0.75 - np.sqrt(np.maximum(0.0049 - (rays[..., 0] * 0.75) ** 2 - (rays[..., 1] * 0.75) ** 2, 0))
    moves = np.hypot(rays[..., 0], rays[..., 1]) < 0.085
    outline = rays[..., 1] > 0.02
    found = bent_beyond(moves, (ball.astype(np.float32), usual[1]), outline, (0.6, 0.8))
    assert found.sum() > 0.5 * (moves & ~outline).sum()
    assert not bent_beyond(moves, usual, np.ones_like(moves), reach).any()


def above(height):
    """A point of the axis, in the camera's frame [m]."""
    return T_WORLD_CAMERA[:3, :3].T @ (np.array([0.0, 0.0, height]) - T_WORLD_CAMERA[:3, 3])


def test_shadows_and_a_ball_of_one_colour_are_nothing_that_moves(scene):
    """A hard shadow wanders over all that stands still."""
    depths, gray, shown = scene
    plain = np.where(shown, 150.0, gray)
    column = np.arange(CAMERA.width)
    for k in range(FRAMES):
        dark = np.abs(column - 20 - 14 * k) < 12
        plain[k] *= np.where(dark & ~shown[k], 0.5, 1.0)
    found = asked(depths, pictures(plain), shown.any(axis=0))
    assert found.mean() < 0.002


def test_too_few_pictures_and_an_empty_outline_say_nothing(scene):
    depths, gray, shown = scene
    usual = np.median(depths, axis=0), np.full(CAMERA.shape, np.float32(0.006))
    few = [*pictures(gray[:3]), *[None] * (FRAMES - 3)]
    assert not print_moves(depths, few, usual, shown[0]).any()
    nowhere = outline_of(np.zeros((0, 3)), CAMERA)
    assert not nowhere.any() and not print_moves(depths, pictures(gray), usual, nowhere).any()


def test_a_ball_in_the_very_middle_is_found_by_its_print():
    """No depth moves, not even at its rim."""
    depths, gray, shown = made(0.0)
    ball = shown.all(axis=0)
    found = find_moving(depths, CAMERA, sigma, pictures(gray))
    middle = T_WORLD_CAMERA[:3, :3].T @ (np.array([0.0, 0.0, RADIUS]) - T_WORLD_CAMERA[:3, 3])
    assert np.abs(found.low - (middle - RADIUS)).max() < 0.01
    assert np.abs(found.high - (middle + RADIUS))[:2].max() < 0.01  # its far side is hidden
    assert found.still[ball].mean() < 0.1
    with pytest.raises(TrackingError, match="nothing turns"):
        find_moving(depths, CAMERA, sigma)
    with pytest.raises(TrackingError, match="nothing turns"):
        find_moving(depths, CAMERA, sigma, pictures(np.where(shown, 150.0, gray)))
