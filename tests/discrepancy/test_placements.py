"""Recordings of one placement are one measurement: found by what they share, not by their folders."""

from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from made_up_walls import FRAMES, look_at, sensor_of

from fusion.discrepancy.observe.placements import joined, repeats_of

WALL = (1.4, -30, 15)
NOISE_M = 0.002


@dataclass(frozen=True)
class Stage:
    """As much of a stage as placements ask for."""

    place: int
    shape: str
    recording: object
    sigma_m: float = 0.001
    sigma_rad: float = 0.001
    mesh_sigma_m: float = 0.0


def recorded(place: int, frozen, seed: int):
    """A block at one wall, whose surface as it was seen has an error that stands still."""
    rng = np.random.default_rng([seed, place])
    block = look_at(sensor_of("itof"), place, WALL, seed)
    frames = block.view.depth + frozen + rng.normal(0, NOISE_M, (FRAMES, *block.mean.shape))
    stage = Stage(place, f"wall {place}", SimpleNamespace(path=Path(f"rec_{place:02d}")))
    return replace(block, stage=stage, mean=frames.mean(axis=0), std=frames.std(axis=0, ddof=1))


def speckle(seed: int, size: float = 0.003):
    return np.random.default_rng(seed).normal(0, size, (80, 112))


def test_a_scene_recorded_again_is_one_placement():
    blocks = joined([recorded(0, speckle(1), 5), recorded(1, speckle(2), 5), recorded(2, speckle(1), 6)])
    assert [block.place for block in blocks] == [0, 1, 0]
    assert blocks[2].stage.shape == "wall 0"
    assert repeats_of(blocks) == [["rec_00", "rec_02"]]


def test_few_squares_differ_by_chance_and_are_one_placement_all_the_same():
    """Of twelve squares the median alone is half as much again in a quarter of pairs."""
    rng, surface = np.random.default_rng(7), speckle(1)
    known = np.zeros(surface.shape, bool)
    known[:48, :64] = True
    block = look_at(sensor_of("itof"), 0, WALL, 5)

    def again(place):
        frames = block.view.depth + surface + rng.normal(0, NOISE_M, (3, *surface.shape))
        stage = Stage(place, "wall", SimpleNamespace(path=Path(f"rec_{place:02d}")))
        mean, std = (np.where(known, image, np.nan) for image in (frames.mean(axis=0), frames.std(axis=0, ddof=1)))
        return replace(block, stage=stage, mean=mean, std=std, count=np.full(surface.shape, 3, np.int32))

    told = sum(bool(repeats_of(joined([again(0), again(1)]))) for _ in range(200))
    assert told >= 196


@pytest.mark.parametrize("moved", [0.0005, -0.001])
def test_a_camera_put_up_again_is_another_placement(moved):
    blocks = [recorded(0, speckle(1), 5), recorded(1, speckle(1) + moved, 6)]
    assert joined(blocks) == blocks and not repeats_of(blocks)


def test_another_stated_pose_is_another_placement():
    T = np.eye(4)
    T[0, 3] = 1e-4
    blocks = [recorded(0, speckle(1), 5), replace(recorded(1, speckle(1), 6), T_world_camera=T)]
    assert [block.place for block in joined(blocks)] == [0, 1]


def test_series_are_left_alone():
    blocks = [recorded(0, speckle(1), 5), recorded(0, speckle(1), 6), recorded(1, speckle(1), 7)]
    assert [block.place for block in joined(blocks)] == [0, 0, 1]
