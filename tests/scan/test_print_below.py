"""Marks on a sheet below the object tell how it turned, whatever the object's shape."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from fusion.geometry.camera import Camera
from fusion.geometry.pose import exp
from fusion.recording.recording import Frame, Recording
from fusion.scan.finding.attempt import attempt
from fusion.scan.finding.pair_fit import Asked
from fusion.scan.settings import ScanSettings
from fusion.sensor.presets import default_sensor
from fusion.turntable.below.ground import ground_below
from fusion.turntable.below.marks import marked
from fusion.turntable.below.meeting import meetings
from fusion.turntable.below.told import told_below

CAMERA = Camera(320, 240, 300.0, 300.0, 159.5, 119.5)
# a sheet 0.5 m before the camera, which looks down by 40 degrees: columns are its two sides and its upright
SHEET = exp([np.deg2rad(130), 0, 0, 0, 0, 0])[:3, :3]
MIDDLE = np.array([0.0, 0.02, 0.5])
RADIUS, HEIGHT = 0.035, 0.08  # [m] of a plain cylinder on it
ANGLES = np.deg2rad([0, 50, 110, 195, 240, 300])
DOTS = np.random.default_rng(3).uniform(-0.11, 0.11, (40, 2))
RASTER = np.stack(np.meshgrid(np.arange(-4, 5), np.arange(-4, 5)), axis=-1).reshape(-1, 2) * 0.025


def frame(angle, dots, rng, aside=0.0):
    """Depth (240, 320) [m] and colour of the cylinder, `aside` [m] off the axis, on a sheet turned so far [rad]."""
    rays = np.concatenate([CAMERA.rays(), np.ones((*CAMERA.shape, 1))], axis=2) @ SHEET
    eye = -MIDDLE @ SHEET
    z = -eye[2] / rays[..., 2]
    at = eye + z[..., None] * rays
    c, s = np.cos(angle), np.sin(angle)
    # the sheet turns right-handed about its upright: where it was before
    before = np.stack([c * at[..., 0] + s * at[..., 1], -s * at[..., 0] + c * at[..., 1]], axis=-1)
    dark = np.zeros(CAMERA.shape, bool)
    for dot in dots:
        dark |= np.linalg.norm(before - dot, axis=-1) < 0.004
    a, middle = (rays[..., :2] ** 2).sum(axis=-1), aside * np.array([c, s])
    to = eye[:2] - middle
    b = (rays[..., :2] * to).sum(axis=-1)
    with np.errstate(invalid="ignore"):
        side = (-b - np.sqrt(b**2 - a * (to @ to - RADIUS**2))) / a
        hit = np.isfinite(side) & (np.abs(eye[2] + side * rays[..., 2] - HEIGHT / 2) < HEIGHT / 2)
    lid = (HEIGHT - eye[2]) / rays[..., 2]
    top = np.linalg.norm((eye + lid[..., None] * rays)[..., :2] - middle, axis=-1) < RADIUS
    depth = np.where(top, lid, np.where(hit, side, z)) + rng.normal(0, 0.0005, CAMERA.shape)
    gray = np.where(top | hit, 120, np.where(dark, 60, 200)) + rng.normal(0, 2, CAMERA.shape)
    return depth.astype(np.float32), np.repeat(np.clip(gray, 1, 255).astype(np.uint8)[..., None], 3, axis=2)


def looked_at(angles, dots):
    """The marks of what is below the cylinder."""
    rng = np.random.default_rng(0)
    depths, colors = zip(*(frame(angle, dots, rng) for angle in angles), strict=True)
    around = np.linspace(0, 2 * np.pi, 60)
    rim = [np.stack([RADIUS * np.cos(around), RADIUS * np.sin(around), 0 * around + h], 1) for h in (0, HEIGHT)]
    points = MIDDLE + np.concatenate(rim) @ SHEET.T
    ground = ground_below((MIDDLE, SHEET[:, 2]), points, CAMERA)
    return marked(ground, CAMERA, list(range(len(angles))), np.stack(depths), np.stack(colors))


@pytest.fixture(scope="module")
def dotted():
    return looked_at(ANGLES, DOTS)


def test_views_meet_at_the_true_turn(dotted):
    for i, j in pairwise(range(len(ANGLES))):
        best = meetings(dotted.marks[i], dotted.marks[j], dotted.ground)[0]
        off = (best.turn - ANGLES[j] + ANGLES[i] + np.pi) % (2 * np.pi) - np.pi
        # half a pixel of the camera, 0.8 mm, at some ten dots 0.1 m from the middle
        assert abs(off) < np.deg2rad(0.4)
        assert best.sure > 0.5  # a chance below a thousandth that so many dots meet by themselves


def test_all_views_agree_with_the_turns(dotted):
    told = told_below(dotted, [dotted.marks[i] for i in range(len(ANGLES))])
    agreed = told.agreeing(ANGLES, np.arange(len(ANGLES)))
    assert {view for edge in agreed.edges for view in edge} == set(range(len(ANGLES)))
    for (i, j), T in zip(agreed.edges, agreed.poses, strict=True):
        upright, turn = SHEET[:, 2], ANGLES[j] - ANGLES[i]
        c, s = np.cos(turn), np.sin(turn)
        arm = np.cross(upright, SHEET[:, 0])
        np.testing.assert_allclose(T[:3, :3] @ SHEET[:, 0], c * SHEET[:, 0] + s * arm, atol=np.deg2rad(0.5))
        # the middle of the sheet stays where it is, to half a pixel
        np.testing.assert_allclose(T[:3, :3] @ MIDDLE + T[:3, 3], MIDDLE, atol=0.0008)


def test_a_raster_leaves_several_turns_open_and_the_true_one_among_them():
    found = looked_at(ANGLES, RASTER)
    turns = [m.turn for m in meetings(found.marks[0], found.marks[1], found.ground)]
    assert min(abs((t - ANGLES[1] + np.pi) % (2 * np.pi) - np.pi) for t in turns) < np.deg2rad(0.6)
    assert len(turns) > 1


@pytest.mark.parametrize("dots", [DOTS[:0], DOTS], ids=["nothing printed", "a sheet that stands still"])
def test_what_does_not_turn_tells_nothing(dots):
    found = looked_at(ANGLES * (len(dots) == 0), dots)
    assert found is None or told_below(found, list(found.marks.values())) is None


def test_a_plain_cylinder_on_dots_is_turned_as_the_dots_are():
    """Its shape says little of its turns, and there is no print on it."""
    rng = np.random.default_rng(5)
    seen = [frame(angle, DOTS, rng, aside=0.02) for angle in ANGLES]
    recording = Recording(
        Path("sheet"), "native", CAMERA, np.arange(6) / 10, lambda i: Frame(i, i / 10, seen[i][0], color=seen[i][1])
    )
    found = attempt(Asked(recording, default_sensor(CAMERA), ScanSettings())).fit.motion
    assert found.axis.direction @ SHEET[:, 2] > np.cos(np.deg2rad(1.0))
    off = (found.angles - ANGLES + np.pi) % (2 * np.pi) - np.pi
    # of a pair of views they tell it to 0.4 deg
    assert np.abs(off).max() < np.deg2rad(0.5)
