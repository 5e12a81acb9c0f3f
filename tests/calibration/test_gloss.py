"""What a board mirrors: a plate that fills the lobe is seen whole, and a law beside it is not bent."""

from dataclasses import replace

import numpy as np
import pytest

from fusion.calibration.depth.calibration import calibrate_walls
from fusion.calibration.depth.known import Start
from fusion.calibration.depth.laws.choice import established
from fusion.calibration.depth.laws.selection import FittedLaw
from fusion.calibration.depth.walls.gloss import LOBE, Surfaces, gloss_map, mirrored, surfaces
from fusion.calibration.depth.walls.plane import WallPlane
from fusion.calibration.depth.walls.wall import Means, wall_of
from fusion.geometry.camera import Camera
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import LIGHT_SPEED, stretch

CAMERA = Camera(96, 72, 110.0, 110.0, 47.5, 35.5, principle="itof", sensor="T", serial="1")
FREQUENCY = 40e6
BOARD = np.array([0.0, 0.0, 1.0])
SLANTED = np.array([1.0, 0.0, -1.0]) / np.sqrt(2)  # mirrors the line of sight to +x


def plate(half: float, away: float, light: float) -> Surfaces:
    """A square plate at the end of the mirrored line of sight, facing the board."""
    side = np.linspace(-half, half, 201)
    y, z = (a.ravel() for a in np.meshgrid(side, side))
    n = len(y)
    place = BOARD + np.column_stack([np.full(n, away), y, z])
    area = np.full(n, (side[1] - side[0]) ** 2)
    return Surfaces(place, np.tile([-1.0, 0.0, 0.0], (n, 1)), area, np.full(n, light))


def test_a_plate_that_fills_the_lobe_adds_its_light_as_a_phasor():
    away, light, own = 0.5, 3000.0, 1000.0
    seen = plate(5 * away * np.tan(LOBE), away, light)
    longer = (np.hypot(away, 1.0) + away - 1.0) / 2  # the middle of the plate
    ideal = LIGHT_SPEED / (4 * np.pi * FREQUENCY) * light / own * np.sin(4 * np.pi * FREQUENCY / LIGHT_SPEED * longer)
    found = mirrored(BOARD, SLANTED, own, seen, (FREQUENCY,))
    # the plate's rim is farther than its middle, by 5 % of the way within the lobe
    assert found == pytest.approx(ideal, rel=0.06)


def test_light_behind_the_board_or_off_the_mirror_direction_adds_nothing():
    seen = plate(0.1, 0.5, 3000.0)
    other = replace(seen, place=seen.place * [-1, 1, 1])
    assert mirrored(BOARD, SLANTED, 1000.0, other, (FREQUENCY,)) == 0.0
    aside = replace(seen, place=seen.place + np.array([0.0, 1.5, 0.0]))
    assert abs(mirrored(BOARD, SLANTED, 1000.0, aside, (FREQUENCY,))) < 1e-6


def test_surfaces_of_a_wall_have_its_place_normal_and_area():
    plane = WallPlane(1.2, 0.1, -0.05)
    depth = plane.depth(CAMERA)
    depth[:, :10] = np.nan
    found = surfaces(depth, np.full(CAMERA.shape, 500.0), CAMERA)
    normal = -np.array([plane.a, plane.b, 1.0])
    normal /= np.linalg.norm(normal)
    assert np.all(found.light == 500.0)
    assert np.median(np.abs(found.normal @ normal - 1)) < 1e-4
    corners = CAMERA.points(plane.depth(CAMERA))[[0, 0, -1], [0, -1, 0]]
    whole = np.linalg.norm(np.cross(corners[1] - corners[0], corners[2] - corners[0]))
    # 10 of 96 columns are missing, and 5 that blur and gradient take; every fourth pixel stands for four either way
    assert found.area.sum() == pytest.approx(whole * 81 / 95, rel=0.08)


def test_the_map_holds_one_number_for_each_square():
    squares = np.full((4, 6), -1)
    squares[:2, :3], squares[2:, 3:] = 0, 1
    ir = np.where(squares == 0, 100.0, 1000.0)
    found = gloss_map(squares, (np.array([BOARD, BOARD]), -SLANTED), ir, plate(0.2, 0.5, 3000.0))
    assert np.all(found[squares < 0] == 0)
    assert np.ptp(found[squares == 0]) == 0
    # the same light on a square ten times darker
    assert found[0, 0] == pytest.approx(10 * found[3, 5])


def test_the_law_beside_a_glossy_board_is_not_bent():
    """An offset of 5 mm and a share of 6 %, whose light grows with the distance: without the gloss that is a scale."""
    rng = np.random.default_rng(3)
    ideal, walls = Sensor(principle="itof"), []
    for i, z in enumerate(np.linspace(0.6, 1.6, 12)):
        plane = WallPlane(float(z), 0.05 * (i % 3 - 1), 0.03)
        gloss = np.zeros(CAMERA.shape)
        gloss[:, CAMERA.width // 2 :] = 0.2 * z**2 * (i % 2)
        measured = plane.depth(CAMERA) + (0.005 + 0.06 * gloss) / stretch(CAMERA) + rng.normal(0, 1e-4, CAMERA.shape)
        means = Means(100, measured, np.full(CAMERA.shape, 1e-3), None)
        wall = wall_of(means, CAMERA, ideal, (f"wall {i}", float(z) + rng.normal(0, 1e-4), 1e-4))
        # the plane as a board's corners would give it: gloss tilts the one through the depth
        there = replace(wall.plane, a=plane.a, b=plane.b)
        walls.append(replace(wall, plane=there, tilt_std=1e-4, gloss=gloss, mask=np.ones(CAMERA.shape, bool)))
    found = calibrate_walls(walls, Start(CAMERA, ideal, ideal, None, "T", "1", ()), surface=False)
    numbers = found.fitted.numbers
    assert found.best.candidate.name == "offset + the board's gloss"
    assert numbers.value["gloss"] == pytest.approx(0.06, abs=4 * numbers.std["gloss"])
    assert numbers.value["offset"] == pytest.approx(0.005, abs=4 * numbers.std["offset"])
    assert [effect.name for effect in found.sensor.effects] == ["depth_offset"]
    assert found.best.error < 0.2 * found.before.error


def test_a_board_mirrors_no_less_than_nothing():
    law = FittedLaw(("offset", "gloss"), np.array([0.005, 0.06]), np.diag([1e-6, 1e-4]), 1.0)
    assert established(law)
    assert not established(replace(law, numbers=law.numbers * [1, -1]))
