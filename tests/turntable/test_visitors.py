"""What hangs together with the border of the image is no object, unless all of them do."""

import numpy as np

from fusion.turntable.turning.visitors import undisturbed, without_visitors

SHAPE = (12, 80, 100)


def scene(arms=(), wall=2.0, block=slice(40, 60)):
    """Moving pixels and depths (12, 80, 100) of a block in the middle; an arm from the left in some frames."""
    moving, depths = np.zeros(SHAPE, bool), np.full(SHAPE, wall, np.float32)
    moving[:, 30:60, block] = True
    depths[:, 30:60, block] = 0.6
    for k in arms:
        moving[k, 40:46, :40] = True
        depths[k, 40:46, :40] = 0.6
    return moving, depths


def test_an_arm_takes_its_frame_along():
    moving, depths = scene(arms=(1, 4, 5))
    kept = without_visitors(moving, depths)
    assert not kept[[1, 4, 5]].any()
    assert np.array_equal(kept[[0, 2, 3]], moving[[0, 2, 3]])


def test_what_passes_behind_goes_and_the_block_stays():
    moving, depths = scene()
    for k in range(len(moving)):  # up to the upper border, beside and behind the block
        depths[k, :50, 5 * k : 5 * k + 12] = np.minimum(depths[k, :50, 5 * k : 5 * k + 12], 1.5)
        moving[k, :50, 5 * k : 5 * k + 12] = True
    kept = without_visitors(moving, depths)
    assert kept[:, 31:59, 41:59].all()  # but for its rim
    assert not (kept & (depths > 1)).any()


def test_a_gap_of_some_pixels_leaves_an_arm_whole():
    moving, depths = scene(arms=(2,))
    moving[2, :, 20:23] = False
    assert not without_visitors(moving, depths)[2].any()


def test_an_object_larger_than_the_image_is_kept():
    moving, depths = scene(block=slice(0, 60))
    assert np.array_equal(without_visitors(moving, depths), moving)


def test_an_empty_background_is_no_border():
    """Where nothing is measured beside the object, its own outline is not taken for the border of the camera."""
    moving, depths = scene(wall=np.nan)
    assert np.array_equal(without_visitors(moving, depths), moving)


def test_noise_is_nothing_that_is_left():
    """The few pixels that an object in each frame leaves behind do not stand for it."""
    moving, depths = scene(block=slice(0, 60))
    moving[:, 10:12, 80:83] = True
    depths[:, 10:12, 80:83] = 1.9
    assert np.array_equal(without_visitors(moving, depths), moving)


def test_frames_that_reach_far_out_are_left_out():
    random = np.random.default_rng(0)
    frames = np.repeat(np.arange(12), 200)
    points = random.uniform(-0.05, 0.05, (len(frames), 3))
    far = (frames % 4 == 1) & (random.random(len(frames)) < 0.3)
    points[far, 0] += random.uniform(0, 0.3, far.sum())
    assert set(frames[undisturbed(points, frames)]) == {k for k in range(12) if k % 4 != 1}


def test_a_lever_is_no_arm():
    """Twice as long one way as the other, seen from all sides: nothing is left out."""
    random = np.random.default_rng(1)
    frames = np.repeat(np.arange(12), 200)
    turn = frames * np.pi / 6
    along = random.uniform(-0.05, 0.1, len(frames))
    points = np.column_stack([along * np.cos(turn), random.uniform(-0.02, 0.02, len(frames)), along * np.sin(turn)])
    assert undisturbed(points, frames).all()
