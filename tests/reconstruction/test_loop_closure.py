"""A camera that comes back to what it saw first: the loop closes, and what is not closed is told."""

from dataclasses import replace

import numpy as np
import pytest

from fusion.geometry.camera import Camera
from fusion.geometry.pose import angle, exp, inverse
from fusion.geometry.trajectory import Trajectory, trajectory_error
from fusion.reconstruction.loops.closing import close
from fusion.reconstruction.loops.keyframes import keyframe_of
from fusion.reconstruction.loops.network import pose_network
from fusion.reconstruction.pipeline import reconstruct
from fusion.reconstruction.settings import ReconstructSettings
from fusion.sensor.sensor import Sensor
from fusion.volume.prepared import prepare
from reference.walked_room import WalkedRoom, round_walk, truth_of

CHEAP = ReconstructSettings(voxel=0.02, truncation=0.08)
ROUND = 2 * np.pi + 0.5


def error(result, recording, poses):
    return trajectory_error(result.trajectory, truth_of(recording, poses))


def light(result, subject):
    return next((x for x in result.judgement.lights if x.subject == subject), None)


def drifted(room, truth, colored=False):
    """Key frames at poses each some 5 mm and 0.2 deg off the one before."""
    recording = room.recording(truth, colored=colored)
    drift = [exp([0.001 * k, 0.002 * k, 0, 0.004 * k, -0.003 * k, 0.002 * k]) for k in range(len(truth))]
    ready = [prepare(recording[k], room.camera, Sensor()) for k in range(len(truth))]
    return [keyframe_of(frame, 0, drift[k] @ truth[k]) for k, frame in enumerate(ready)]


@pytest.fixture(scope="module")
def walk():
    return round_walk(ROUND)


@pytest.fixture(scope="module")
def bare(walk):
    recording = WalkedRoom(bare=True).recording(walk)
    return recording, reconstruct(recording, CHEAP)


def test_a_walk_past_bare_walls_is_closed(bare, walk):
    recording, result = bare
    assert not result.rejected
    # tracking alone slides along the bare wall; half a voxel is left
    assert result.course.moved > 0.05
    assert error(result, recording, walk).rmse < 0.01
    assert result.course.met > 3 and result.course.after < 0.01 < result.course.before
    assert light(result, "Loops").level == "ok" and light(result, "Drift") is None
    assert result.facts.values()["course"]["places_seen_again"] == result.course.met
    assert np.allclose(result.trajectory.poses[0], np.eye(4))


def test_what_is_not_closed_is_told(walk):
    half = walk[: len(walk) // 2]
    result = reconstruct(WalkedRoom().recording(half), CHEAP)
    assert result.course.met == 0 and not result.course.in_view
    assert "not checked" in light(result, "Drift").reason


def test_a_camera_that_keeps_its_view_costs_nothing_more(walk):
    few = walk[:4]
    result = reconstruct(WalkedRoom().recording(few), CHEAP)
    assert result.course.in_view and result.course.met == 0
    assert light(result, "Drift").level == "ok"


def test_after_a_loss_the_pieces_are_joined(walk):
    """Frames without depth, and meanwhile the camera turned by more than it sees at once."""
    kept = [*range(40), *range(54, len(walk))]
    poses = walk[kept]
    poses[40:44] = poses[44]
    recording = WalkedRoom().recording(poses, blank=range(38, 44))
    result = reconstruct(recording, CHEAP)
    assert result.course.pieces == result.course.joined == 2
    assert set(result.rejected) >= set(range(38, 44)) and len(result.rejected) <= 8
    assert error(result, recording, poses).rmse < 0.01


def test_a_piece_that_meets_nothing_is_left_out_and_told(walk):
    kept = [*range(25), *range(41, 50)]
    poses = walk[kept]
    poses[25:31] = poses[31]
    recording = WalkedRoom().recording(poses, blank=range(25, 31))
    result = reconstruct(recording, CHEAP)
    assert (result.course.pieces, result.course.joined) == (2, 1)
    assert "after a loss" in result.rejected[len(poses) - 1]
    placed = result.trajectory.valid
    assert placed[:25].all() and not placed[25:].any()


def test_given_poses_have_no_course(walk):
    recording = WalkedRoom().recording(walk[:4])
    result = reconstruct(recording, replace(CHEAP, poses=truth_of(recording, walk[:4])))
    assert result.course is None and light(result, "Drift") is None


@pytest.mark.parametrize("start", [0.0, 1.0, 2.8])
def test_without_colour_a_symmetric_room_is_not_mistaken(start):
    """From its middle a room looks much the same both ways; bare depth of 160 x 120 tells little, and nothing wrong."""
    truth = round_walk(ROUND, start=start, step=np.deg2rad(8))
    frames = drifted(WalkedRoom(), truth)
    found = close(frames)
    before = [frame.T_world_camera for frame in frames]
    for i, j in () if found is None else found.met:
        off = [inverse(inverse(truth[i]) @ truth[j]) @ inverse(poses[i]) @ poses[j] for poses in (before, found.poses)]
        shifts, turns = np.linalg.norm([T[:3, 3] for T in off], axis=1), [angle(T) for T in off]
        # where walls leave a direction open drift stays; a mistake is half a metre and 90 degrees or more
        assert shifts[1] < shifts[0] and turns[1] < turns[0]


def test_without_colour_the_shapes_are_recognised():
    truth = round_walk(ROUND, start=2.8, step=np.deg2rad(8))
    fine = Camera(320, 240, 280.0, 280.0, 159.5, 119.5)
    room = WalkedRoom(camera=fine, sigma=0.001)
    frames = drifted(room, truth)
    stamps = np.arange(len(truth), dtype=float)
    start, found, true = (
        Trajectory(stamps, poses)
        for poses in (np.stack([frame.T_world_camera for frame in frames]), close(frames).poses, truth)
    )
    before, after = (trajectory_error(one, true).rmse for one in (start, found))
    assert before > 0.05 and after < 0.01


def test_what_slides_along_a_wall_is_held_by_its_print():
    """Before bare walls tracking alone stays where it is, and would say that the camera kept its view."""
    bare = WalkedRoom(bare=True)
    poses = round_walk(1.2, start=2.3)
    recording = bare.recording(poses)
    result = reconstruct(recording, CHEAP)
    assert result.course.moved > 0.05
    assert error(result, recording, poses).rmse < 0.02


def test_key_frames_that_drift_are_settled_by_the_network_of_all_pairs():
    truth = round_walk(1.2)[::2]
    frames = drifted(WalkedRoom(bare=False), truth, colored=True)
    poses = np.stack([frame.T_world_camera for frame in frames])
    network = pose_network(frames, poses)

    def off(found):  # between first and last, where drift has added up
        return np.linalg.norm((inverse(found[0]) @ found[-1] @ inverse(inverse(truth[0]) @ truth[-1]))[:3, 3])

    assert off(poses) == pytest.approx(0.005 * (len(truth) - 1), rel=0.5)
    assert 0 < off(network.poses) < 0.3 * off(poses)
    assert network.moved(poses) == pytest.approx(off(poses), rel=0.5)
    assert pose_network(frames[:1], poses[:1]) is None
