"""A camera that tracking has lost is found by what it sees; pieces are joined where one pair of key frames met."""

from dataclasses import replace

import numpy as np
import pytest

from fusion.geometry.trajectory import trajectory_error
from fusion.reconstruction.pipeline import reconstruct
from fusion.reconstruction.placing import Placer
from fusion.reconstruction.settings import ReconstructSettings
from fusion.sensor.sensor import Sensor
from fusion.volume.blocks import FullError
from fusion.volume.prepared import prepare
from fusion.volume.settings import VolumeSettings
from fusion.volume.volume import Volume
from reference.walked_room import WalkedRoom, round_walk, truth_of

HOW = ReconstructSettings(voxel=0.02, truncation=0.08)
WALK = round_walk(2.4)


def error(result, recording, poses):
    return trajectory_error(result.trajectory, truth_of(recording, poses)).rmse


def test_a_camera_that_jumps_back_to_where_it_was_is_found_at_once():
    poses = np.concatenate([WALK[:16], WALK[2:6]])  # 50 degrees from one frame to the next
    recording = WalkedRoom().recording(poses)
    result = reconstruct(recording, HOW)
    assert result.trajectory.valid.all() and result.course.pieces == 1
    assert error(result, recording, poses) < 0.02


@pytest.mark.parametrize("back", [13, 15])
def test_a_piece_that_comes_back_to_the_views_it_left_is_joined(back):
    poses = np.concatenate([WALK[:16], WALK[28:12:-1], WALK[back : back - 3 : -1]])
    recording = WalkedRoom().recording(poses)
    result = reconstruct(recording, HOW)
    assert result.course.pieces == result.course.joined
    assert result.trajectory.valid.all()
    assert error(result, recording, poses) < 0.02
    assert "Steps" not in {light.subject for light in result.judgement.lights}


def test_a_piece_without_a_key_frame_recognises_nothing():
    """Key frames are thinned out where they are many, and may leave a short piece without one."""
    recording = WalkedRoom().recording(WALK[:1])
    placer = Placer(recording, HOW, Volume(VolumeSettings(voxel=0.02, truncation=0.08)))
    assert not list(placer._recognised(prepare(recording[0], recording.camera, Sensor())))


def test_frames_of_noise_at_the_start_are_lost_and_the_next_one_is_the_first():
    whole = WalkedRoom().recording(WALK[:8])

    def load(index):
        frame = whole.load(index)
        if index > 2:
            return frame
        # a far surface whose noise lets nothing of it be fused
        return replace(frame, depth=np.full_like(frame.depth, 60.0))

    result = reconstruct(replace(whole, load=load), HOW)
    assert result.rejected == dict.fromkeys(range(3), "nothing of it was fused")
    assert result.trajectory.valid[3:].all() and len(result.mesh.faces) > 1000


def test_a_volume_that_is_full_tells_after_how_many_frames_and_what_helps():
    recording = WalkedRoom().recording(WALK[:16])
    with pytest.raises(FullError, match=r"after \d+ of 16 frames.*--room.*--memory"):
        reconstruct(recording, replace(HOW, max_bytes=1_700_000))
