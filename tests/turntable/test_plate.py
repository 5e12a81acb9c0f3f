"""The plate is found: round or of any shape, with a table below it or none."""

import numpy as np
import pytest
from scipy import ndimage

from fusion.geometry import pose
from fusion.geometry.camera import Camera
from fusion.geometry.depth import point_map
from fusion.simulation.demo.demo import looking_at
from fusion.simulation.rendering.render import RayCaster
from fusion.simulation.scene.shapes import box, disc, joined
from fusion.simulation.scene.turntable import Turntable
from fusion.turntable.axis import Axis
from fusion.turntable.table.plate import find_plate, has_a_rim, size_of
from fusion.turntable.turning.moving import find_moving
from fusion.turntable.views import Region, usable, view

SMALL = Camera(160, 120, 190.0, 191.0, 80.3, 59.1, principle="itof")


GREY = (180, 180, 180)
TABLE = box((-1.0, -1.0, -0.32), (0.5, 1.0, -0.3), GREY)  # what the camera sees behind and below what turns
CLOSE = box((-1.0, -1.0, -0.06), (0.5, 1.0, -0.04), GREY)  # a table close below the plate, level and all round as it is
SHORT = box((-0.35, -1.0, -0.06), (0.5, 1.0, -0.04), GREY)  # the same with a far edge that is seen
# an object on a hidden foot: a stick that is thinner than what stands on it
POLE = box((-0.01, -0.01, -0.1), (0.01, 0.01, 0.0), GREY)
BODY = box((-0.05, -0.04, 0.0), (0.03, 0.04, 0.12), GREY)
STEP = box((0.03, -0.04, 0.0), (0.1, 0.04, 0.02), GREY)  # a low level part on one side
BOOK = box((-0.1, -0.065, 0.0), (0.1, 0.065, 0.02), GREY)
COVERED = disc(0.125, -0.012, 0.0, lambda p: np.full((len(p), 3), 180))  # by the book for the larger part
PLATE = disc(0.15, -0.012, 0.0, lambda p: np.full((len(p), 3), 180))


def seen(moving, still=None, frames=12, ragged=0.0):
    """Views of what turns before what stands still, as the pipeline cuts them, and the true axis.

    `ragged`: the share of values that is lost two pixels deep at the end of what is seen.
    """
    T_world_camera = looking_at(np.array([0.62, 0.05, 0.40]), np.array([0.0, 0.0, 0.05]))
    table = Turntable(degrees_per_frame=360 / frames, frames=frames)
    caster = RayCaster(joined(moving))
    depths = np.stack(
        [caster.view(SMALL, T).depth for T in table.T_object_camera(T_world_camera, table.commanded_deg())]
    )
    if still is not None:
        depths = np.fmin(depths, RayCaster(still).view(SMALL, T_world_camera).depth)
    known = np.isfinite(depths)
    rims = known & ~ndimage.binary_erosion(known, np.ones((1, 3, 3)), iterations=2)
    depths[rims & (np.random.default_rng(0).random(depths.shape) < ragged)] = np.nan
    moved = find_moving(np.nan_to_num(depths, nan=2.0), SMALL, lambda z: np.full_like(z, 0.001))
    T_camera_world = pose.inverse(T_world_camera)
    region = Region(moved.low, moved.high, moved.still).grown(0.015)
    maps = [point_map(d, SMALL, 0.001) for d in depths]
    views = [view(m, usable(m, region)) for m in maps]
    return views, Axis(T_camera_world[:3, 3], T_camera_world[:3, 2])


@pytest.mark.parametrize("still", [TABLE, CLOSE, None], ids=["table", "close table", "nothing behind"])
@pytest.mark.parametrize("moving", [(BODY, PLATE), (BODY, STEP, PLATE), (BOOK, COVERED)], ids=["body", "step", "book"])
def test_the_height_of_a_plate_that_is_seen(moving, still):
    """Also where a book covers more of the plate than is seen of it: its cover is level too, and turns."""
    views, axis = seen(moving, still)
    # a pixel is 4 mm: edges round the plate's surface off
    assert find_plate(views, axis).height == pytest.approx(0.0, abs=0.002)
    # heights count from the axis' point
    higher = Axis(axis.point + 0.02 * axis.direction, axis.direction)
    assert find_plate(views, higher).height == pytest.approx(-0.02, abs=0.002)


def test_a_rim_that_flickers_by_a_pixel_is_no_turning_corner():
    """A plate that is little wider than what stands on it was left in the mesh."""
    views, axis = seen((BOOK, COVERED), ragged=0.5)
    assert find_plate(views, axis).height == pytest.approx(0.0, abs=0.002)


def test_a_plate_is_found_by_an_axis_that_is_only_guessed():
    views, axis = seen((BODY, PLATE), TABLE)
    guess = axis.moved(np.array([np.deg2rad(2), np.deg2rad(-2), 0.004, 0.004]))
    # 2 deg tilt the plate by 5 mm at its rim
    assert find_plate(views, guess).height == pytest.approx(0.0, abs=0.005)


@pytest.mark.parametrize("still", [TABLE, None], ids=["table", "nothing behind"])
@pytest.mark.parametrize(
    "moving", [(BODY, STEP, POLE), (BOOK, POLE), (STEP, BODY, BOOK, POLE)], ids=["step", "book", "both"]
)
def test_a_level_part_of_the_object_is_no_plate(moving, still):
    views, axis = seen(moving, still)
    assert find_plate(views, axis) is None


def test_no_plate_no_height(owl_scene):
    views = owl_scene.views()
    for v in views:  # the owl without the level covers of its books
        height = owl_scene.axis.distance(v.map.points.reshape(-1, 3))[1].reshape(v.map.points.shape[:2])
        v.map.normals[height < 0.06] = np.nan
    assert find_plate(views, owl_scene.axis) is None


def test_the_table_below_is_not_the_plate_though_more_of_it_is_seen(monkeypatch):
    """A plate has a rim past which one looks; a table goes on."""
    views, axis = seen((BODY, PLATE), CLOSE)
    size = size_of(views, axis)
    assert has_a_rim(views, axis, 0.0, size) and not has_a_rim(views, axis, -0.04, size)
    monkeypatch.setattr("fusion.turntable.table.plate.level_heights", lambda *_: [-0.04, 0.0])
    assert find_plate(views, axis).height == 0.0


def test_the_far_edge_of_a_table_is_no_rim_of_a_plate():
    """One looks past it, but it is not round about the axis."""
    views, axis = seen((BODY, PLATE), SHORT)
    size = size_of(views, axis)
    assert has_a_rim(views, axis, 0.0, size) and not has_a_rim(views, axis, -0.04, size)


SQUARE = box((-0.13, -0.11, -0.012), (0.11, 0.12, 0.0), GREY)
ELL = joined([box((-0.14, -0.12, -0.012), (0.12, 0.03, 0.0), GREY), box((-0.06, 0.0, -0.012), (0.12, 0.13, 0.0), GREY)])
SLOTTED = joined(
    [box((-0.13, 0.06, -0.012), (0.13, 0.13, 0.0), GREY), box((-0.13, -0.12, -0.012), (0.13, 0.03, 0.0), GREY)]
)
HIGHER = box((-1.0, -1.0, -0.037), (0.5, 1.0, -0.027), GREY)  # a table 15 mm below these plates
BRICK = box((-0.1, -0.08, -0.06), (0.1, 0.08, 0.0), GREY)  # as high as it may stand, and no slab
LEDGE = box((-0.03, -0.12, -0.012), (0.12, 0.02, 0.0), GREY)  # on two sides


def motions(frames=12):
    """What brings the object from where it is in the first view to where it is in each."""
    T_world_camera = looking_at(np.array([0.62, 0.05, 0.40]), np.array([0.0, 0.0, 0.05]))
    table = Turntable(degrees_per_frame=360 / frames, frames=frames)
    back = table.T_object_camera(T_world_camera, table.commanded_deg())
    return pose.inverse(back) @ back[0]


@pytest.mark.parametrize("still", [CLOSE, HIGHER, SHORT], ids=["close table", "closer table", "small table"])
@pytest.mark.parametrize("shape", [SQUARE, ELL, SLOTTED], ids=["square", "L", "slotted"])
@pytest.mark.parametrize("body", [(BODY,), (BODY, STEP)], ids=["body", "step"])
def test_a_plate_of_any_shape_is_found_above_its_table(body, shape, still):
    views, axis = seen((*body, shape), still)
    found = find_plate(views, axis, motions())
    assert found is not None and found.height == pytest.approx(0.0, abs=0.002)


@pytest.mark.parametrize("still", [TABLE, None], ids=["table", "nothing behind"])
@pytest.mark.parametrize(
    "moving", [(BODY, STEP, POLE), (BOOK, POLE), (STEP, BODY, BOOK, POLE)], ids=["step", "book", "both"]
)
def test_a_book_on_a_pole_is_no_plate_though_it_turns_as_one(moving, still):
    assert find_plate(*seen(moving, still), motions()) is None


@pytest.mark.parametrize("moving", [(BODY, BRICK), (BODY, LEDGE)], ids=["brick", "ledge"])
def test_what_is_no_slab_all_round_stays_part_of_the_object(moving):
    low = -0.06 if moving[1] is BRICK else -0.012
    still = box((-1.0, -1.0, low - 0.02), (0.5, 1.0, low), GREY)
    found = find_plate(*seen(moving, still), motions())
    assert found is None or found.table is None


@pytest.mark.parametrize("shape", [SQUARE, ELL], ids=["square", "L"])
def test_a_plate_on_a_foot_is_one_however_high_it_stands(shape):
    """It stands higher than it could be thick, and one looks under it; a brick as high is looked at from the side."""
    foot, floor = box((-0.02, -0.02, -0.075), (0.02, 0.02, 0.0), GREY), -0.075
    still = box((-1.0, -1.0, floor - 0.02), (0.5, 1.0, floor), GREY)
    found = find_plate(*seen((BODY, shape, foot), still), motions())
    assert found is not None and found.height == pytest.approx(0.0, abs=0.002)
    thick = find_plate(*seen((BODY, box((-0.13, -0.11, floor), (0.11, 0.12, 0.0), GREY)), still), motions())
    assert thick is None or thick.table is None


@pytest.mark.parametrize("thick", [0.02, 0.05])
def test_how_thick_a_plate_may_be_is_told_in_its_widths(thick):
    slab = box((-0.13, -0.11, -thick), (0.11, 0.12, 0.0), GREY)
    still = box((-1.0, -1.0, -0.1), (0.5, 1.0, -thick), GREY)
    found = find_plate(*seen((BODY, slab), still), motions())
    assert found is not None and found.table is not None
    assert found.thickness == pytest.approx(thick / 0.27, rel=0.15)  # from border to border and corner to corner


def test_a_plate_on_a_foot_is_no_thicker_than_one_looks_under_it():
    foot, still = box((-0.02, -0.02, -0.06), (0.02, 0.02, 0.0), GREY), box((-1.0, -1.0, -0.08), (0.5, 1.0, -0.06), GREY)
    found = find_plate(*seen((BODY, SLOTTED, foot), still), motions())
    assert found is not None and found.table is not None
    assert found.thickness == pytest.approx(2 / 3 * 0.06 / 0.28, rel=0.1)


def test_level_specks_of_a_wall_are_no_slab():
    """Noise tilts a few pixels of a pile's sides until they lie level: it was cut off at that height."""
    still = box((-1.0, -1.0, -0.02), (0.5, 1.0, 0.0), GREY)
    views, axis = seen((box((-0.13, -0.11, 0.0), (0.13, 0.11, 0.15), GREY),), still)
    rng, specks = np.random.default_rng(1), 0
    for one in views:
        above = axis.distance(one.map.points.reshape(-1, 3).astype(float))[1].reshape(SMALL.shape)
        beside = np.abs(one.map.normals @ axis.direction) < 0.3
        side = np.flatnonzero((np.abs(above - 0.04) < 0.004) & beside)
        some = rng.choice(side, min(len(side), 25), replace=False)
        one.map.normals.reshape(-1, 3)[some] = axis.direction
        specks += len(some)
    assert specks > 200
    found = find_plate(views, axis, motions())
    assert found is None or found.table is None


def test_a_round_plate_is_found_as_one_with_the_motions_too():
    found = find_plate(*seen((BODY, PLATE), CLOSE), motions())
    assert found is not None and found.table is None and found.height == pytest.approx(0.0, abs=0.002)


def test_no_slab_turns_by_angles_that_are_wrong():
    views, axis = seen((BODY, SQUARE), CLOSE)
    found = find_plate(views, axis, np.concatenate([motions()[6:], motions()[:6]])[::-1])
    assert found is None or found.table is None
