"""What of a hand is left on an object goes; without a hand, or where the frame's place is wrong, all stays."""

from dataclasses import replace

import numpy as np
import pytest
from owl_and_arm import CAMERA, NEAR, alone, frames_of
from scipy.spatial.transform import Rotation

from fusion.geometry import pose
from fusion.scan.cleaning.touching import fused_untouched, without_touching
from fusion.simulation.scene.shapes import box
from fusion.volume.beside import beside
from fusion.volume.prepared import fused
from fusion.volume.volume import VolumeSettings

BLOCK = box((-0.06, -0.06, 0.02), (0.06, 0.06, 0.2), (120, 120, 120))
FINGER = (0.06, -0.02, 0.09), (0.075, 0.15, 0.11)  # along y, on one of its sides
CUT = 0.03  # [m] along y: the hand beyond was taken out of the frames
SETTINGS = VolumeSettings(0.004, NEAR, bounds=((-0.2, -0.2, 0.01), (0.2, 0.2, 0.35)))


def touched(cut=CUT, arm_in=(0, 1)):
    """Frames of a block, in two of which a finger rests on it, its hand taken out; poses, and the finger's pixels."""
    clean, poses = frames_of((), BLOCK)
    frames = [alone(frame) for frame in frames_of(arm_in, BLOCK, FINGER)[0]]
    fingers = [np.abs(np.nan_to_num(a.depth - b.depth, nan=1.0)) > 1e-4 for a, b in zip(frames, clean, strict=True)]
    fingers = [f & np.isfinite(a.depth) for f, a in zip(fingers, frames, strict=True)]
    for k in arm_in:
        y = pose.transform(poses[k], frames[k].surface.points.astype(float))[..., 1]
        fingers[k] &= ~(y > cut)
        hand = (y > cut) & np.isfinite(frames[k].depth)
        frames[k] = replace(frames[k].masked(~hand), passing=hand if hand.any() else None)
    return frames, poses, fingers


def off(volume, clean, poses):
    """Root mean square [m] of a surface to that without a hand, as seen from four sides."""
    apart = [volume.raycast(CAMERA, T).depth - clean.raycast(CAMERA, T).depth for T in poses[[17, 0, 1, 2]]]
    return float(np.sqrt(np.nanmean(np.square(apart))))


def test_a_finger_on_the_object_goes():
    frames, poses, fingers = touched()
    volume = fused(SETTINGS, frames, poses)
    left = without_touching(volume, frames, poses)
    assert left is not None
    clean = fused(SETTINGS, [alone(frame) for frame in frames_of((), BLOCK)[0]], poses)
    for k in (0, 1):
        there = beside(clean, frames[k], poses[k])
        stands = fingers[k] & (there.off < -there.limit)  # nearer ones may be the noise of the object
        assert stands.sum() > 50
        assert np.isfinite(left[k].depth[stands]).mean() < 0.1
    lost = [np.isfinite(a.depth).sum() - np.isfinite(b.depth).sum() for a, b in zip(frames, left, strict=True)]
    assert sum(lost[2:]) == 0 and max(lost) < 2 * max(map(np.sum, fingers))
    again = fused_untouched(SETTINGS, frames, poses)
    assert off(again, clean, poses) < 0.5 * off(volume, clean, poses)


def test_without_a_hand_a_part_that_is_there_for_a_while_stays():
    frames, poses, _ = touched(cut=1.0)
    assert without_touching(fused(SETTINGS, frames, poses), frames, poses) is None


@pytest.mark.parametrize("frames", [[], [None, None]])
def test_without_frames_nothing_is_left(frames):
    poses = np.full((len(frames), 4, 4), np.nan)
    assert without_touching(fused(SETTINGS, frames, poses), frames, poses) is None


def test_a_frame_at_a_wrong_place_keeps_what_contradicts():
    frames, poses, _ = touched()
    wrong = poses.copy()
    wrong[1, :3, :3] = Rotation.from_rotvec([0, 0, 0.6]).as_matrix() @ poses[1, :3, :3]
    wrong[1, :3, 3] = poses[1, :3, 3] + [0.04, 0, 0]
    left = without_touching(fused(SETTINGS, frames, wrong), frames, wrong)
    assert left is None or left[1] is frames[1]
