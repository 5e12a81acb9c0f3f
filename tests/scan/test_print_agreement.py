"""Print between frames that a motion lays on each other: right turns agree, slipped ones do not, none is none."""

import warnings
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from made_up_scan import good_scan, with_evidence

from fusion.geometry import pose
from fusion.geometry.camera import Camera
from fusion.geometry.depth import point_map
from fusion.scan.judging.print_agreement import PrintAgreement, print_agreement
from fusion.scan.judging.print_pairs import compared, printed
from fusion.simulation.demo.demo import looking_at
from fusion.turntable.views import Region

CAMERA = Camera(200, 160, 300.0, 300.0, 99.5, 79.5)
T_WORLD_CAMERA = looking_at(np.array([0.45, 0.0, 0.25]), np.array([0.0, 0.0, 0.06]))
RADIUS, EVERYWHERE = 0.08, Region(np.full(3, -9.0), np.full(3, 9.0))
TURNS = np.deg2rad(15.0) * np.arange(24)
SLIPPED = {
    "right": TURNS,
    "half of them by 40 deg": TURNS + np.deg2rad(40) * (np.arange(24) >= 12),
    "one by 15 deg": TURNS + np.deg2rad(15) * (np.arange(24) == 7),
    "each step by a quarter": 1.25 * TURNS,
    "none turns": 0 * TURNS,
}


def patches(points):
    """Brightness of places on the ball: fields of about 10 mm."""
    cell = np.floor((points + 0.3001) / 0.01).astype(int)
    return ((cell @ [7, 13, 29] + cell[..., 0] * cell[..., 2] * 3 + cell[..., 1] * cell[..., 2] * 5) * 37) % 170 + 40.0


def one_side(points):
    return np.where(points[..., 0] > 0, patches(points), 120.0)


def plain(points):
    return np.full(points.shape[:-1], 150.0)


def stood(turn, shift=(0.0, 0.0)):
    """The camera in the ball's frame; shift: of the ball on the table [m]."""
    T_world_ball = pose.about_axis([0, 0, 0], [0, 0, 1], turn)
    T_world_ball[:3, 3] = *shift, 0.06
    return pose.inverse(T_world_ball) @ T_WORLD_CAMERA


def ball(turn, paint, random, shift=(0.0, 0.0)):
    """A frame of a ball that turns about its own middle: its shape tells nothing of the turn."""
    T = stood(turn, shift)
    rays = np.concatenate([CAMERA.rays(), np.ones((*CAMERA.shape, 1))], axis=-1) @ T[:3, :3].T
    a, b = (rays**2).sum(axis=-1), rays @ T[:3, 3]
    with np.errstate(invalid="ignore"):
        depth = (-b - np.sqrt(b**2 - a * (T[:3, 3] @ T[:3, 3] - RADIUS**2))) / a
    gray = np.nan_to_num(paint(T[:3, 3] + rays * np.nan_to_num(depth)[..., None])) * random.uniform(0.7, 1.2)
    image = (gray[..., None] + random.normal(0, 3, (*depth.shape, 3))).clip(0, 255).astype(np.uint8)
    depth = (depth + random.normal(0, 0.0006, depth.shape)).astype(np.float32)
    return SimpleNamespace(
        surface=point_map(depth, CAMERA, 0.0006), depth=depth, color=image, weight=np.ones_like(depth)
    )


@pytest.fixture(scope="module")
def frames():
    random = np.random.default_rng(0)
    return {paint: [ball(turn, paint, random) for turn in TURNS] for paint in (patches, one_side, plain)}


def asked(frames, angles):
    return print_agreement(frames, EVERYWHERE, np.stack([stood(a) for a in angles]), angles)


@pytest.mark.parametrize("angles", SLIPPED.values(), ids=SLIPPED.keys())
def test_print_tells_right_turns_from_those_that_shape_allows(frames, angles):
    found = asked(frames[patches], angles)
    if angles is TURNS:
        assert found.against == 0 and found.loose == 0 and found.agree.mean() > 0.95
    else:
        assert max(found.against, found.loose) > 0.03


def test_a_side_without_print_speaks_neither_for_nor_against(frames):
    found = asked(frames[one_side], TURNS)
    assert found.against == 0 and found.loose == 0
    assert 0.2 < found.agree.mean() < 0.9  # the blank side is not asked


@pytest.mark.parametrize("angles", [TURNS, 0 * TURNS], ids=["right", "wrong"])
def test_without_print_nothing_is_said(frames, angles):
    found = asked(frames[plain], angles)
    assert np.isnan(found.loose)
    scan = with_evidence(good_scan(), print=found)
    assert not [x for x in scan.judgement.lights if x.subject == "Print"]


def lamp(frame, beside=(0.6, -0.6, -0.5)):
    """Brightness under a lamp that stands beside the camera, of a matt surface: (h, w), 0.2 to 1."""
    normals = np.nan_to_num(frame.surface.points.astype(float)) - stood_middle()
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    return 0.2 + 0.8 * np.clip(normals @ (np.array(beside) / np.linalg.norm(beside)), 0, None)


def stood_middle():
    """The ball's middle before the camera: it stands still as the ball turns."""
    return pose.transform(pose.inverse(stood(0.0)), np.zeros((1, 3)))[0]


def under_a_lamp(frame):
    color = (frame.color * lamp(frame)[..., None]).clip(0, 255).astype(np.uint8)
    return SimpleNamespace(surface=frame.surface, depth=frame.depth, color=color, weight=frame.weight)


@pytest.mark.parametrize("angles", [TURNS, 0 * TURNS], ids=["right", "wrong"])
def test_what_a_lamp_makes_of_the_shape_is_no_print(frames, angles):
    """It stands still as the ball turns: taken for print it would speak for a ball that does not turn."""
    assert np.isnan(asked([under_a_lamp(frame) for frame in frames[plain]], angles).loose)


@pytest.mark.parametrize("angles", SLIPPED.values(), ids=SLIPPED.keys())
def test_print_tells_right_turns_under_a_lamp_too(frames, angles):
    found = asked([under_a_lamp(frame) for frame in frames[patches]], angles)
    if angles is TURNS:
        assert found.against == 0 and found.loose == 0
    else:
        assert max(found.against, found.loose) > 0.03


def test_frames_without_colours_or_without_a_place_are_not_asked(frames):
    some = [replace_color(frame) for frame in frames[patches]]
    assert asked(some, TURNS) is None
    nowhere = np.where(np.arange(24) < 3, np.nan, TURNS)
    found = asked(frames[patches], nowhere)
    assert found.count == 21 and found.against == 0


def replace_color(frame):
    return SimpleNamespace(surface=frame.surface, depth=frame.depth, color=None)


def test_two_frames_that_share_nothing_say_nothing(frames):
    one, other = (printed(frames[patches][k], EVERYWHERE, stood(TURNS[k])) for k in (0, 12))
    assert np.isnan(compared(one, other).alike)


AGREEING = PrintAgreement(
    np.array([(k, k + 1) for k in range(40)]), np.full(40, 0.9), np.full(40, 0.5), np.full(40, 0.1), 41
)


@pytest.mark.parametrize(("wrong", "level"), [(0, "ok"), (1, "ok"), (3, "warning"), (5, "bad")])
def test_pairs_that_differ_are_told(wrong, level):
    """Two more edges around hold what a wrong pair would let go."""
    edges = np.concatenate([AGREEING.edges, [(0, 40)], [(k, k + 2) for k in range(39)]])
    alike = np.where(np.arange(len(edges)) < wrong, 0.0, 0.9)
    found = PrintAgreement(edges, alike, np.full(len(edges), 0.5), np.full(len(edges), 0.1), 41)
    assert found.loose == 0 and found.against == pytest.approx(wrong / len(edges))
    (light,) = [x for x in with_evidence(good_scan(), print=found).judgement.lights if x.subject == "Print"]
    assert light.level == level


def test_a_frame_without_any_agreeing_pair_is_loose():
    """Its pairs are too unsure to differ, and yet it is not held."""
    alone = replace(
        AGREEING, alike=np.where(np.arange(40) == 0, 0.1, 0.9), chance=np.where(np.arange(40) == 0, 0.3, 0.1)
    )
    assert alone.against == 0 and alone.loose == pytest.approx(1 / 41)
    halves = replace(AGREEING, alike=np.where(np.arange(40) == 19, 0.1, 0.9), chance=np.full(40, 0.2))
    assert halves.against == 0 and halves.loose == pytest.approx(20 / 41)
    (light,) = [x for x in with_evidence(good_scan(), print=halves).judgement.lights if x.subject == "Print"]
    assert light.level == "bad" and "49%" in light.reason


def test_few_large_fields_tell_as_much_as_their_number_does():
    """Of about ten fields a correlation of 0.9 is far from chance, though chance makes 0.3: it cannot exceed 1."""
    coarse = replace(AGREEING, alike=np.full(40, 0.88), own=np.full(40, 0.55), chance=np.full(40, 0.3))
    assert coarse.agree.all() and coarse.loose == 0
    assert not replace(coarse, alike=np.full(40, 0.7)).agree.any()


@pytest.mark.parametrize("most", [1.0, 1 + 1e-9])
def test_the_same_picture_twice_agrees_wholly(most):
    """Rounding may leave a little more than 1; of frames made twice the inverse tangent has no end."""
    same = replace(AGREEING, alike=np.full(40, most), own=np.full(40, most))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert same.agree.all() and not same.differ.any() and same.loose == 0
        assert replace(same, alike=np.full(40, -most)).differ.all()


def test_print_that_is_seen_slanted_does_not_differ():
    """Alike by half of what a print is with itself: neither one nor the other is sure."""
    half = replace(AGREEING, alike=np.full(40, 0.25), own=np.full(40, 0.5), chance=np.full(40, 0.1))
    assert not half.agree.any() and not half.differ.any()
    assert replace(half, alike=np.full(40, 0.1)).differ.all()


def test_pairs_that_share_nothing_have_no_print_to_hold_views_by():
    apart = replace(AGREEING, alike=np.where(np.arange(40) == 0, np.nan, 0.9))
    assert apart.loose == 0


@pytest.mark.parametrize("step", [None, 0.17])
def test_with_told_angles_only_print_that_differs_counts(step):
    """What a log or a step says holds views together too."""
    told = replace(
        good_scan(), told=np.deg2rad(10.0) * np.arange(36), settings=replace(good_scan().settings, step=step)
    )
    edges = np.array([(i, j) for half in (range(6), range(6, 12)) for i in half for j in half if i < j])
    ones = np.ones(len(edges))
    loose = PrintAgreement(edges, 0.8 * ones, 0.9 * ones, 0.1 * ones, 12)
    differing = replace(loose, alike=np.where(np.arange(len(edges)) % 5 == 0, 0.0, 0.8))
    for found, level in ((loose, "ok"), (differing, "bad")):
        scan = with_evidence(told, print=found)
        (light,) = [x for x in scan.judgement.lights if x.subject == "Print"]
        assert light.level == level
    assert ("log" if step is None else "step") in light.do
