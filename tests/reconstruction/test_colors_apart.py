"""Colour that does not belong to the depth neither moves a camera that surfaces hold, nor passes in silence."""

from dataclasses import replace

import numpy as np
import pytest

from fusion.geometry.trajectory import trajectory_error
from fusion.reconstruction.pipeline import reconstruct
from fusion.reconstruction.settings import ReconstructSettings
from reference.walked_room import WalkedRoom, round_walk, truth_of

HOW = ReconstructSettings(voxel=0.02, truncation=0.08)
WALK = round_walk(2.0)


@pytest.fixture(scope="module")
def recording():
    return WalkedRoom().recording(WALK)


@pytest.fixture(scope="module")
def mirrored(recording):
    def load(index):
        frame = recording[index]
        return replace(frame, color=np.ascontiguousarray(frame.color[:, ::-1]))

    return replace(recording, load=load)


def colour(result):
    return [light for light in result.judgement.lights if light.subject == "Colour"]


def error(result, recording):
    return trajectory_error(result.trajectory, truth_of(recording, WALK)).rmse


def test_colours_of_the_depth_are_not_doubted(recording):
    assert not colour(reconstruct(recording, HOW))


def test_mirrored_colours_are_told_and_do_not_move_the_camera(recording, mirrored):
    result = reconstruct(mirrored, HOW)
    assert "do not belong together" in colour(result)[0].reason
    assert error(result, recording) < error(reconstruct(recording.without_color(), HOW), recording) + 0.005


def test_without_colour_it_is_not_looked_at(recording, mirrored):
    told, alone = reconstruct(mirrored, replace(HOW, color=False)), reconstruct(recording.without_color(), HOW)
    np.testing.assert_array_equal(told.trajectory.poses, alone.trajectory.poses)
    assert told.mesh.colors is None and not colour(told)
