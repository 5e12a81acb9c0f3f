"""A motion of which nothing is told: hands turn by uneven steps and move the object; print holds what shape lets go."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from fusion.errors import TrackingError
from fusion.geometry import pose
from fusion.geometry.camera import Camera
from fusion.geometry.depth import point_map
from fusion.simulation.demo.demo import looking_at
from fusion.turntable.all_views.joint import State
from fusion.turntable.axis import Axis, Turns
from fusion.turntable.guess.alone import find_alone, found_again, held_through
from fusion.turntable.guess.everywhere import Heard, listen
from fusion.turntable.motion import estimate_motion
from fusion.turntable.pairs.edges import stack, thinned_view
from fusion.turntable.table.foot import plate_among
from fusion.turntable.views import Region, view

CAMERA = Camera(160, 120, 220.0, 220.0, 79.5, 59.5)
T_WORLD_CAMERA = looking_at(np.array([0.45, 0.0, 0.28]), np.array([0.0, 0.0, 0.06]))
HALF = np.array([0.03, 0.055, 0.075])  # a box that is neither square nor round


def printed(points):
    """Brightness of places on the box: fields of 12 mm, another on every side."""
    cell = np.floor((points + 0.3001) / 0.012).astype(int)
    return (
        (cell[..., 0] * 7 + cell[..., 1] * 13 + cell[..., 2] * 29 + cell[..., 0] * cell[..., 2] * 3) * 37
    ) % 200 + 30


def seen(turn, shift, random, color, noise=0.0006):
    """One view of the box, its middle at the origin but for a shift (2,) on the table [m]."""
    surface, shown, image = looked(turn, shift, random, noise)
    return view(surface, shown, image if color else None)


def looked(turn, shift, random, noise=0.0006):
    """Surface, pixels that show it, and colours of one view of the box."""
    T_world_box = pose.about_axis([0, 0, 0], [0, 0, 1], turn)
    T_world_box[:3, 3] += [*shift, 0.06]
    T = pose.inverse(T_world_box) @ T_WORLD_CAMERA
    rays = np.concatenate([CAMERA.rays(), np.ones((*CAMERA.shape, 1))], axis=-1) @ T[:3, :3].T
    with np.errstate(divide="ignore", invalid="ignore"):
        a, b = (-HALF - T[:3, 3]) / rays, (HALF - T[:3, 3]) / rays
    near, far = np.minimum(a, b).max(axis=-1), np.maximum(a, b).min(axis=-1)
    depth = np.where((near < far) & (near > 0), near, np.nan)
    gray = np.nan_to_num(printed(T[:3, 3] + rays * np.nan_to_num(depth)[..., None] * 0.9999))
    surface = point_map((depth + random.normal(0, noise, depth.shape)).astype(np.float32), CAMERA, noise)
    image = (gray[..., None] * np.ones(3) * random.uniform(0.7, 1.2)).clip(0, 255).astype(np.uint8)
    return surface, np.isfinite(surface.normals[..., 0]) & (surface.incidence < np.deg2rad(75)), image


def ball(turn, random, off=0.0, shift=(0, 0)):
    """One view of a printed ball of 60 mm before the same camera; it turns about its own middle, or so far off it, and
    is moved by a shift (2,) on the table [m]."""
    T_world_ball = pose.about_axis([0, 0, 0], [0, 0, 1], turn) @ pose.pose(np.eye(3), [off, 0, 0.06])
    T_world_ball[:2, 3] += shift
    T = pose.inverse(T_world_ball) @ T_WORLD_CAMERA
    rays = np.concatenate([CAMERA.rays(), np.ones((*CAMERA.shape, 1))], axis=-1) @ T[:3, :3].T
    a, b = (rays**2).sum(axis=-1), rays @ T[:3, 3]
    with np.errstate(invalid="ignore"):
        depth = (-b - np.sqrt(b**2 - a * (T[:3, 3] @ T[:3, 3] - 0.06**2))) / a
    gray = np.nan_to_num(printed(T[:3, 3] + rays * np.nan_to_num(depth)[..., None]))
    surface = point_map((depth + random.normal(0, 0.0006, depth.shape)).astype(np.float32), CAMERA, 0.0006)
    shown = np.isfinite(surface.normals[..., 0]) & (surface.incidence < np.deg2rad(75))
    image = (gray[..., None] * np.ones(3) * random.uniform(0.7, 1.2)).clip(0, 255).astype(np.uint8)
    return view(surface, shown, image)


def scanned(steps, wander, seed=0, color=True, noise=0.0006):
    random = np.random.default_rng(seed)
    turns = np.concatenate([[0.0], np.cumsum(np.deg2rad(steps))])
    shifts = random.normal(0, wander, (len(turns), 2))
    return turns, shifts, [seen(a, s, random, color, noise) for a, s in zip(turns, shifts, strict=True)]


REGION = Region(np.full(3, -1.0), np.ones(3))
UNEVEN = [22, 41, 15, 30, 12, 38, 25, 18, 44, 28, 35, 20, 33]  # 361 degrees


@pytest.mark.slow  # a minute on a busy machine: every pair of views at turns all round
@pytest.mark.parametrize("sign", [1, -1])
def test_uneven_steps_of_a_hand_and_where_it_moved_the_box(sign):
    turns, shifts, views = scanned(sign * np.array(UNEVEN), 0.006)
    found = find_alone(views, REGION)
    error = np.rad2deg(found.state.angles - found.state.angles[0] - turns)
    assert np.abs(error - error.mean()).max() < 0.6  # noise of 0.6 mm over 110 mm, few pixels
    assert found.wanders
    moved = (found.state.shifts @ found.state.axis.across() @ T_WORLD_CAMERA[:3, :3].T)[:, :2]
    # the axis may stand anywhere: another place of it is a shift that turns with the object
    c, s = np.cos(turns), np.sin(turns)
    free = np.zeros((2 * len(turns), 4))
    free[0::2], free[1::2] = np.column_stack([c, -s, 1 + 0 * c, 0 * c]), np.column_stack([s, c, 0 * c, 1 + 0 * c])
    rest = (moved - shifts).ravel()
    rest = rest - free @ np.linalg.lstsq(free, rest, rcond=None)[0]
    assert np.sqrt(np.mean(rest**2)) < 0.0006  # of 6 mm; half a pixel is 1 mm


@pytest.mark.slow
def test_a_hand_that_moves_little_is_a_hand_all_the_same():
    """1.5 mm in each direction, where a view's noise is 0.6 mm: less than what once counted for a firm axis."""
    turns, _, views = scanned(UNEVEN, 0.0015)
    found = find_alone(views, REGION)
    error = np.rad2deg(found.state.angles - found.state.angles[0] - turns)
    assert found.wanders and np.abs(error - error.mean()).max() < 0.5


@pytest.mark.parametrize(("wander", "noise", "low", "high"), [(0, 6e-4, 0, 3), (0, 2e-3, 0, 3), (3e-4, 6e-4, 15, 400)])
def test_shifts_explain_what_a_hand_did_and_no_noise(wander, noise, low, high):
    """A hand that moves the box by half a point's noise is told from a firm axis by all pairs of views together."""
    turns, _, views = scanned(UNEVEN, wander, noise=noise)
    T = pose.inverse(T_WORLD_CAMERA)
    start = State(Axis(T[:3, 3], T[:3, 2]), turns, np.zeros((len(turns), 2)))
    found = found_again(views, start)
    assert low < found.explained < high
    assert found.wanders == (wander > 0)


@pytest.mark.parametrize("late", [0, 1])
def test_colours_of_another_moment_have_no_say(late):
    """The image of the view before: by print the box slides as steps differ, by shape it stands on its axis."""
    random = np.random.default_rng(0)
    turns = np.concatenate([[0.0], np.cumsum(np.deg2rad(random.normal(15, 3, 24)))])
    all_ = [looked(turn, (0, 0), random) for turn in turns]
    views = [view(*all_[k][:2], all_[max(k - late, 0)][2]) for k in range(len(all_))]
    T = pose.inverse(T_WORLD_CAMERA)
    found = found_again(views, State(Axis(T[:3, 3], T[:3, 2]), turns, np.zeros((len(turns), 2))))
    error = np.rad2deg(found.state.angles - found.state.angles[0] - turns)
    assert found.print_contradicts == bool(late) and not found.wanders
    assert np.abs(error - error.mean()).max() < 0.4


@pytest.mark.slow
def test_a_firm_axis_is_told_from_a_hand():
    turns, _, views = scanned(UNEVEN, 0.0)
    found = find_alone(views, REGION)
    error = np.rad2deg(found.state.angles - found.state.angles[0] - turns)
    assert not found.wanders and np.abs(error - error.mean()).max() < 0.4


@pytest.mark.slow
def test_noise_of_four_millimetres_is_no_lack_of_an_axis():
    turns, _, views = scanned(UNEVEN, 0.0, noise=0.004)
    found = find_alone(views, REGION)
    error = np.rad2deg(found.state.angles - found.state.angles[0] - turns)
    assert np.abs(error - error.mean()).max() < 2.0 and np.median(found.joint.misfit) < 0.3


@pytest.mark.parametrize("step", [1, 3])
def test_neighbours_are_those_among_the_views_that_are_compared(step):
    """Of many frames some are compared; prints of a ball agree between neighbours, however far apart the frames are."""
    keys = step * np.arange(6)
    edges = [(int(keys[a]), int(keys[b])) for a in range(6) for b in range(a + 1, 6)]
    near = np.array([b - a == step for a, b in edges])
    at = SimpleNamespace(alike=np.where(near, 0.9, 0.0))
    heard = Heard(edges, SimpleNamespace(turns=np.where(near, 0.3, 2.0), at=at), np.full(len(edges), 0.9))
    assert heard.printed() == 1.0 and heard.apart(edges[1]) == 2
    assert (heard.said(1.0).worth[near] > 1).all()


def test_print_tells_the_turn_of_a_ball_that_a_hand_moved():
    """Turned about the axis alone its views would miss each other by many pixels of print, at every turn."""
    random, T = np.random.default_rng(3), pose.inverse(T_WORLD_CAMERA)
    turns = np.concatenate([[0.0], np.cumsum(np.deg2rad(UNEVEN))])
    views = [ball(turn, random, 0.01, random.normal(0, 0.006, 2)) for turn in turns]
    edges = [(k, k + 1) for k in range(len(UNEVEN))]
    heard = listen(stack([thinned_view(v, 800) for v in views]), Axis(T[:3, 3], T[:3, 2]), edges)
    worth, pair = heard.worth(heard.printed()), np.array(heard.edges)[:, 0]
    best = [int(np.flatnonzero(pair == k)[np.argmax(worth[pair == k])]) for k in range(len(UNEVEN))]
    # the nearest neighbour of a candidate is 20 degrees off, a pixel on the ball 2
    assert np.abs(np.rad2deg(heard.found.turns[best]) - UNEVEN).max() < 2.0


@pytest.mark.slow
def test_print_holds_a_ball_that_shape_lets_slip():
    random, steps = np.random.default_rng(5), [15, 22, 12, 18, 25, 14, 20, 16, 24, 19]
    turns = np.concatenate([[0.0], np.cumsum(np.deg2rad(steps))])
    found = find_alone([ball(turn, random) for turn in turns], REGION)
    error = np.rad2deg(found.state.angles - found.state.angles[0] - turns)
    assert np.abs(error - error.mean()).max() < 1.0  # a pixel on it is 2 degrees
    assert found.lens is not None and not found.wanders


@pytest.mark.parametrize(
    ("color", "lean"), [(True, 0.005), (True, 0.4), (False, 0.0)], ids=["print", "print from afar", "none"]
)
def test_print_holds_a_ball_of_which_a_log_tells_the_turns(color, lean):
    """Shape tells of its axis as little as of its turn, and may find one that leans by 20 degrees."""
    random, turns = np.random.default_rng(6), np.deg2rad(20.0) * np.arange(18)
    views = [ball(turn, random) for turn in turns]
    views = views if color else [v.plain() for v in views]
    T = pose.inverse(T_WORLD_CAMERA)
    axis = Axis(T[:3, 3] + 0.06 * T[:3, 2], T[:3, 2])  # through the ball's middle
    found = held_through(views, Turns(axis.moved(np.array([lean, 0.0, 0.002, -0.002])), turns))
    assert (found is not None) == color
    if found is not None:
        assert axis.distance(found.state.axis.nearest_to(T[:3, 3]).point[None])[0][0] < 0.0005
        assert np.rad2deg(np.arccos(found.state.axis.direction @ axis.direction)) < 0.3  # a pixel is 2
        assert np.rad2deg(np.std(found.state.angles - turns)) < 0.5


@pytest.mark.parametrize("step", [20.0, 18.5], ids=["right", "7 % wrong"])
def test_print_tells_which_way_a_ball_turned_whose_shape_says_nothing(step):
    """A log's sign is unknown, and shape may have taken the other way."""
    random, turns = np.random.default_rng(8), np.deg2rad(20.0) * np.arange(18)
    T = pose.inverse(T_WORLD_CAMERA)
    axis = Axis(T[:3, 3] + 0.06 * T[:3, 2], T[:3, 2])
    found = held_through([ball(turn, random) for turn in turns], Turns(axis, -turns * step / 20.0))
    assert found is not None and np.rad2deg(np.std(found.state.angles - turns)) < 0.5


def test_shape_holds_a_box_of_which_a_log_tells_the_turns():
    turns, _, views = scanned([20.0] * 17, 0.0)
    T = pose.inverse(T_WORLD_CAMERA)
    assert held_through(views, Turns(Axis(T[:3, 3], T[:3, 2]), turns)) is None


def test_the_motion_of_a_printed_ball_with_a_log_is_that_of_its_print():
    random, turns = np.random.default_rng(7), np.deg2rad(20.0) * np.arange(18)
    middle = pose.transform(pose.inverse(T_WORLD_CAMERA), np.array([0.0, 0.0, 0.06]))
    found = estimate_motion([ball(turn, random, 0.01) for turn in turns], Region(middle - 0.1, middle + 0.1), turns)
    assert found.held and np.rad2deg(np.std(found.angles - turns)) < 0.5


def test_what_turns_about_no_axis_is_told():
    """Views of a box at places of which no turn about one axis tells."""
    random = np.random.default_rng(1)
    views = []
    for _ in range(5):
        depth = np.full(CAMERA.shape, np.nan, np.float32)
        u, v = random.integers(5, 60, 2)
        depth[v : v + 40, u : u + 40] = random.uniform(0.3, 0.9) + random.uniform(0, 0.05, (40, 40))
        surface = point_map(depth, CAMERA, 0.001)
        views.append(view(surface, np.isfinite(depth) & np.isfinite(surface.normals[..., 0])))
    with pytest.raises(TrackingError, match="do not fit a turn about one axis"):
        find_alone(views, REGION)


@pytest.mark.slow
def test_a_known_motion_is_found_again_where_it_was_pulled():
    turns, _, views = scanned(UNEVEN, 0.0)
    first = find_alone(views, REGION).state
    pulled = replace(first, angles=first.angles + np.deg2rad(1.5) * (np.arange(len(turns)) > 9))
    found = found_again(views, pulled)
    error = np.rad2deg(found.state.angles - found.state.angles[0] - turns)
    assert np.abs(error - error.mean()).max() < 0.4 and not found.wanders


def far_off(turn, at, random, plate=0.17):
    """One view of the box (no print) that stands at (2,) [m] off the axis on a turning plate, which is seen too."""
    T = pose.inverse(pose.about_axis([0, 0, 0], [0, 0, 1], turn)) @ T_WORLD_CAMERA
    rays = np.concatenate([CAMERA.rays(), np.ones((*CAMERA.shape, 1))], axis=-1) @ T[:3, :3].T
    middle = np.array([*at, HALF[2]])
    with np.errstate(divide="ignore", invalid="ignore"):
        a, b = (middle - HALF - T[:3, 3]) / rays, (middle + HALF - T[:3, 3]) / rays
        ground = -T[2, 3] / rays[..., 2]
    near, far = np.minimum(a, b).max(axis=-1), np.maximum(a, b).min(axis=-1)
    box = np.where((near < far) & (near > 0), near, np.inf)
    level = T[:3, 3] + rays * ground[..., None]
    flat = np.where((ground > 0) & (np.hypot(level[..., 0], level[..., 1]) < plate), ground, np.inf)
    depth = np.minimum(box, flat)
    depth[np.isinf(depth)] = np.nan
    surface = point_map((depth + random.normal(0, 0.0006, depth.shape)).astype(np.float32), CAMERA, 0.0006)
    return view(surface, np.isfinite(surface.normals[..., 0]) & (surface.incidence < np.deg2rad(75)), None)


@pytest.mark.parametrize("at", [(0.06, 0.03), (-0.02, 0.08)])
def test_an_object_far_off_the_axis_on_a_plate_that_counts_as_turning(at):
    random = np.random.default_rng(8)
    turns = np.deg2rad(15.0) * np.arange(25)
    views = [far_off(turn, at, random) for turn in turns]
    point, normal = plate_among(views)
    up = T_WORLD_CAMERA[:3, :3].T @ [0, 0, 1]
    assert np.rad2deg(np.arccos(min(1.0, normal @ up))) < 0.5
    assert pose.transform(T_WORLD_CAMERA, point)[2] == pytest.approx(0.0, abs=0.001)
    found = find_alone(views, Region(np.full(3, -9.0), np.full(3, 9.0))).state
    off = np.rad2deg(found.angles * np.sign(found.angles[-1]) - turns)
    assert np.abs(off - np.median(off)).max() < 1.5
    assert found.axis.direction @ up > np.cos(np.deg2rad(1.0))


def test_faces_of_a_box_that_turns_are_no_plate():
    random = np.random.default_rng(9)
    views = [seen(turn, (0, 0), random, color=False) for turn in np.deg2rad(20.0) * np.arange(18)]
    assert plate_among(views) is None
