"""What was there in a few frames only goes; the object stays, its rims too."""

import numpy as np
import pytest
from owl_and_arm import COUNT, NEAR, frames_of, of_arm, surface_of

from fusion.mesh.mesh import Mesh
from fusion.scan.cleaning.seen import looked_through


def test_an_arm_that_came_in_goes_and_the_object_stays():
    frames, poses = frames_of(arm_in=(4, 5))
    mesh = surface_of(frames, poses)
    marked, arm = looked_through(mesh, frames, poses, NEAR), of_arm(mesh.vertices)
    assert arm.sum() > 300  # it is there
    assert marked[arm].mean() > 0.8
    assert marked[~arm].mean() < 0.005


def test_what_stays_beside_the_object_stays():
    frames, poses = frames_of(arm_in=range(COUNT))
    assert looked_through(surface_of(frames, poses), frames, poses, NEAR).mean() < 0.005


@pytest.mark.parametrize("frames", [[], [None, None]])
def test_without_frames_nothing_is_looked_through(frames):
    mesh = Mesh(np.eye(3), np.array([[0, 1, 2]]), normals=np.eye(3))
    assert not looked_through(mesh, frames, np.full((len(frames), 4, 4), np.nan), NEAR).any()
