"""Offset, shares, shortest distance, summary over several recordings."""

import json
from dataclasses import replace

import numpy as np
import pytest
from made_stills import CAMERA, NOISE, frames, recording, stated, wall

from fusion.evaluation.bump import bump_of
from fusion.evaluation.evaluate import EvaluationSettings, evaluate
from fusion.evaluation.near_limit import SurfaceSeen, near_limits
from fusion.evaluation.numbers import numbers
from fusion.evaluation.summary import summary
from fusion.files.json_values import json_text
from fusion.geometry.trajectory import Trajectory
from fusion.sensor.effects.readout.depth_offset import DepthOffset
from fusion.sensor.sensor import Sensor

OFFSET = 0.004  # [m]


def shifted(i: int, depth: np.ndarray) -> np.ndarray:
    return depth + np.float32(OFFSET)


def test_the_offset_of_a_tilted_wall_is_found_and_taken_out():
    made = [recording(frames(12, z, shifted), telemetry=stated(z), name=f"{z}") for z in (0.8, 1.2, 1.6)]
    sensor = Sensor(principle="itof", effects=(DepthOffset(OFFSET),), std={("depth_offset", "offset"): 0.0})
    found = evaluate(made, EvaluationSettings(sensor=sensor))
    for look in found.looks:
        assert look.bias.truth == "distance_m" and look.surface.kind == "plane"
        # 190 px x 12 frames of 2 mm: 0.04 mm; what is stated here is exact
        assert look.bias.offset == pytest.approx(OFFSET, abs=2.5e-4)
        assert look.bias.corrected == pytest.approx(0, abs=2.5e-4)
        assert look.bias.rms < 2 * NOISE / np.sqrt(12)
        assert look.noise.axial == pytest.approx(NOISE, rel=0.1)
    assert found.longest.drift.verdict == "too short to say"


def test_shares_add_up_and_outliers_are_not_holes():
    rng = np.random.default_rng(2)

    def spoil(i: int, depth: np.ndarray) -> np.ndarray:
        chance, out = rng.random(depth.shape), depth.copy()
        out[chance < 0.2] = np.nan
        out[chance > 0.95] += 0.4
        return out

    found = evaluate([recording(frames(20, 1.2, spoil))])
    look = found.looks[0]
    assert np.allclose([look.valid, look.missing, look.outliers], [0.75, 0.2, 0.05], atol=0.01)
    for shares in found.shares.values():
        assert np.allclose(shares.valid + shares.missing + shares.outliers, 1)
    assert set(found.shares) == {"depth", "incidence", "brightness"}
    # outliers are no noise
    assert np.nanmedian(look.still.depth.std) == pytest.approx(NOISE, rel=0.1)


def test_a_stated_distance_without_any_depth_counts_as_no_data():
    none = frames(4, 0.3, lambda i, z: np.full_like(z, np.nan))
    found = evaluate([recording(none, telemetry=stated(0.3)), recording(frames(4, 1.0), telemetry=stated(1.0))])
    assert found.looks[0].missing == 1 and found.looks[1].valid == 1
    near = found.near[0]
    assert near.interval == pytest.approx((0.3, 1.0)) and 0.3 < near.distance < 1.0


def test_the_shortest_distance_is_where_the_share_crosses():
    dark = [SurfaceSeen(z, valid, 300.0) for z, valid in ((0.2, 0.0), (0.3, 1.0), (1.0, 1.0))]
    bright = [
        SurfaceSeen(z, valid, 4000.0) for z, valid in ((0.5, 0.2), (0.6, 0.8), (0.7, 1.0), (1.0, 0.99), (4.0, 0.5))
    ]
    limits = {near.surface: near for near in near_limits([*dark, *bright])}
    assert limits["bright"].distance == pytest.approx(0.65) and limits["bright"].interval == (0.6, 0.7)
    assert limits["dark"].distance == pytest.approx(0.29)
    assert near_limits([SurfaceSeen(0.5, 1.0, 1.0)]) == []
    (never,) = near_limits([SurfaceSeen(0.5, 0.1, 1.0), SurfaceSeen(0.6, 0.2, 1.0)])
    assert np.isnan(never.distance)


def test_the_numbers_are_json_and_complete():
    found = evaluate([recording(frames(8), telemetry=stated(1.2))])
    text = json_text(numbers(found))
    read = json.loads(text)
    assert read["format"] == "fusion-evaluation/1"
    assert read["stretches"][0]["depth"]["std_m"]["median"] == pytest.approx(NOISE, rel=0.1)
    assert read["camera"]["serial"] == CAMERA.serial
    assert read["stretches"][0]["pixel"] | {"u": 48, "v": 36} == read["stretches"][0]["pixel"]


def test_a_wrong_unit_and_a_wrong_distance_are_grave_notes():
    tiny = recording(frames(4, 1.2, lambda i, z: z / 1000))
    assert any(level == "bad" and "depth_scale" in text for level, text in evaluate([tiny]).notes)
    elsewhere = recording(frames(4, 1.2), telemetry=stated(2.4))
    assert any(level == "bad" and "distance_m" in text for level, text in evaluate([elsewhere]).notes)


def test_a_centre_that_goes_up_and_down_is_no_noise_of_the_camera():
    still = evaluate([recording(frames(20, 1.2))]).looks[0]
    assert not still.shared.changes
    swayed = still.still.centre + 0.066 * (-1.0) ** np.arange(20)  # what a box did that a hand turned
    assert replace(still, still=replace(still.still, centre=swayed)).shared.changes


def test_where_all_moves_nothing_is_told_about_the_camera():
    def sway(i: int, depth: np.ndarray) -> np.ndarray:
        return depth + np.float32(0.06 * np.sin(1.7 * i))

    found = evaluate([recording(frames(20, 1.2, sway))])
    assert "nothing stands still" in summary(found)
    still = evaluate([recording(frames(20, 1.2))])
    assert "noise" in summary(still) and not [text for level, text in still.notes if level == "bad"]
    single = evaluate([recording(frames(1, 1.0 + 0.2 * k, seed=k), name=f"{k}") for k in range(7)])
    assert "nothing stands still" not in summary(single)


@pytest.mark.parametrize(("per_second", "steady"), [(0.01, True), (0.0, False)])
def test_a_steady_change_is_no_noise_that_averaging_takes_out(per_second, steady):
    together = np.random.default_rng(8).normal(0, 0.002, 60)  # [m] of whole frames

    def change(i: int, depth: np.ndarray) -> np.ndarray:
        return (depth + per_second * i / 30 + (0.0 if steady else together[i])).astype(np.float32)

    found = evaluate([recording(frames(60, 1.2, change))])
    (note,) = [text for _, text in found.notes if "shared by all pixels" in text]
    assert ("nor does averaging frames" in note) == steady
    assert ("+10.0 mm a second" in note) == steady


def test_copies_of_one_frame_tell_no_noise():
    (one,) = frames(1)
    found = evaluate([recording([replace(one, index=i, timestamp=i / 30) for i in range(20)])])
    assert found.notes[0][0] == "bad" and "hold the same depth" in found.notes[0][1]
    assert "noise" not in summary(found)


def test_what_passes_through_the_centre_is_no_noise_that_pixels_share():
    def change(i: int, depth: np.ndarray) -> np.ndarray:
        out = depth.copy()
        if i % 5 < 3:  # a hand before nearly all of the centre, never twice at one depth
            out[15:60, 10 : 80 + i % 7] = 0.7 + 0.004 * i
        return out

    found = evaluate([recording(frames(50, 1.2, change))])
    assert any("something moves" in text for _, text in found.notes)
    assert not any("shared by all" in text or "as a whole" in text for _, text in found.notes)


@pytest.mark.parametrize("by", [0.002, 0.006])
def test_a_bump_is_told_with_its_frame(by):
    made = frames(40, 1.2, lambda i, z: z + np.float32(by * (i >= 25)))
    said = [text for _, text in evaluate([recording(made, telemetry=stated(1.2))]).notes]
    (told,) = [text for text in said if "at frame 25 and stays there" in text]
    assert float(told.split("shifts by ")[1].split(" mm")[0]) == pytest.approx(1e3 * by, abs=0.2)
    assert not any("jump" in text for text in said)


@pytest.mark.parametrize(
    "series",
    [
        np.linspace(0, 0.01, 40),
        0.003 * (1 - np.exp(-np.arange(40) / 8)),
        0.002 * np.sin(np.arange(40)),
        0.001 * np.cumsum(np.random.default_rng(3).standard_normal(40)),
    ],
)
def test_what_changes_all_the_time_is_no_bump(series):
    noise = 1e-4 * np.random.default_rng(0).standard_normal(40)
    assert bump_of(series + noise) is None
    assert bump_of(np.where(np.arange(40) < 3, np.nan, noise)) is None


def test_what_hangs_in_the_middle_of_a_wall_is_told():
    def framed(i: int, depth: np.ndarray) -> np.ndarray:
        out = depth.copy()
        out[25:50, 36:60] -= 0.03
        return out

    def bowl(i: int, depth: np.ndarray) -> np.ndarray:
        return depth + np.float32(0.03) * np.square(CAMERA.rays()[..., :2]).sum(axis=-1).astype(np.float32)

    said = [[text for _, text in evaluate([recording(frames(20, 1.2, change), telemetry=stated(1.2))]).notes]
            for change in (framed, bowl)]  # fmt: skip
    assert any("before the plane of the rest" in text for text in said[0])
    assert not any("plane of the rest" in text for text in said[1])


def test_a_thing_before_the_wall_is_told_and_not_a_lack_of_frames():
    """150 mm before it: no value of the middle is one of the wall, and 40 full frames were "fewer than six moments"."""

    v, u = np.mgrid[:72, :96]
    dome = 0.15 * np.sqrt(np.clip(1 - ((u - 48) ** 2 + (v - 36) ** 2) / 18**2, 0, 1)).astype(np.float32)
    found = evaluate([recording(frames(40, 1.2, lambda i, z: z - dome), telemetry=stated(1.2))])
    look = found.looks[0]
    assert look.bias.beside and look.bias.proud == pytest.approx(-0.15, rel=0.1)  # the patch is 12 px wide
    assert any("before the plane of the rest" in text for _, text in found.notes)
    assert "before the plane of the rest" in look.drift.text and "fewer than six" not in look.drift.text
    assert "too short" not in summary(found)


def test_of_depths_far_apart_the_noise_is_that_of_all_places_between_them():
    """At the middle of a level a pixel never changes: 0.2 mm of noise was told, with steps of 23 mm."""
    step = 1 / 90.0  # of the reciprocal [1/m]

    def rounded(i: int, depth: np.ndarray) -> np.ndarray:
        flat = depth - wall(1.2) + wall(1.2, slope=0.03)
        return (1 / (np.rint(1 / flat / step) * step)).astype(np.float32)

    found = evaluate([recording(frames(30, 90 / 75, rounded), telemetry=stated(1.2))])
    look = found.looks[0]
    assert look.gap == pytest.approx(1.2**2 * step, rel=0.05)
    true = np.sqrt(np.nanmean(look.still.depth.std[look.surface.region] ** 2))
    assert f"noise {1e3 * true:.1f} mm" in summary(found) and true > NOISE > 2 * look.noise.axial
    assert any("mm apart, further than the noise" in text for _, text in found.notes)
    assert not evaluate([recording(frames(30))]).looks[0].coarse


def test_stamps_in_milliseconds_do_not_make_a_camera_warm():
    found = evaluate([recording(frames(40, interval=100 / 3))])
    assert "the camera is warm" not in summary(found)
    assert any(level == "bad" and "milliseconds" in text for level, text in found.notes)


@pytest.mark.parametrize(("step", "told"), [(0.002, True), (0.0, False)])
def test_a_camera_whose_poses_go_on_tells_its_motion_and_not_its_noise(step, told):
    poses = np.tile(np.eye(4), (12, 1, 1))
    # what the poses scatter by is their own noise
    poses[:, :3, 3] = step * np.arange(12)[:, None] * [0, 0, 1] + np.random.default_rng(4).normal(0, 5e-4, (12, 3))
    made = frames(12, 1.2, lambda i, z: (z - step * i).astype(np.float32))
    stamps = np.array([frame.timestamp for frame in made])
    found = evaluate([recording(made, poses=Trajectory(stamps, poses))])
    assert any(level == "bad" and "the camera went on by" in text for level, text in found.notes) == told


@pytest.mark.parametrize("posed", [False, True])
def test_where_no_motion_is_stated_none_is_told_though_steps_of_depth_hide_the_noise(posed):
    """Most pixels show one depth: half of no noise at all is less than any motion, and than none."""
    made = frames(40, 1.2, lambda i, z: (np.round((wall() + (z - wall()) / 4) / 0.008) * 0.008).astype(np.float32))
    stamps = np.array([frame.timestamp for frame in made])
    poses = Trajectory(stamps, np.tile(np.eye(4), (40, 1, 1))) if posed else None
    found = evaluate([recording(made, poses=poses)])
    known = found.looks[0].still.depth.std
    assert np.median(known[np.isfinite(known)]) == 0
    assert not any("the camera went on by" in text for _, text in found.notes)
