"""Scratch images belong to whoever uses them: two threads with one camera get what one gets."""

import copy
from threading import Thread

import numpy as np
import pytest
from side_by_side import compared

from fusion.compute.spare import Spare
from fusion.geometry.camera import Camera
from fusion.geometry.depth import point_map
from fusion.volume.volume import Volume, VolumeSettings

CAMERA = Camera(160, 120, 140.0, 140.0, 79.5, 59.5)
SETTINGS = VolumeSettings(0.01, 0.04)


def waves(n: int) -> np.ndarray:
    """A depth image (h, w) [m], another for each n, partly missing."""
    v, u = np.mgrid[: CAMERA.height, : CAMERA.width]
    depth = 1 + 0.1 * np.sin(u / (9 + n)) + 0.05 * np.cos(v / (7 + n)) + 0.02 * n
    depth[:, 40 + 5 * n : 44 + 7 * n] = np.nan
    return depth.astype(np.float32)


def filled(first: int) -> Volume:
    volume = Volume(SETTINGS)
    for n in range(3):
        volume.integrate(waves(first + n), CAMERA, np.eye(4))
    return volume


def inside(volume: Volume) -> list[np.ndarray]:
    count = volume.block_count
    return [volume.blocks.coordinates[:count], volume.blocks.voxels[:count]]


def test_point_maps():
    assert not compared(lambda: point_map(waves(0), CAMERA), lambda: point_map(waves(5), CAMERA), 40)


def test_filled_volumes():
    assert not compared(lambda: inside(filled(0)), lambda: inside(filled(5)), 8)


def test_views_of_two_volumes():
    one, other = filled(0), filled(5)
    assert not compared(
        lambda: one.raycast(CAMERA, np.eye(4)), lambda: other.raycast(CAMERA.halved(), np.eye(4)), rounds=40
    )


def test_one_volume_is_filled_and_seen_by_two():
    """Seen while it is filled it shows the surface of all frames so far, and in the end it holds all of them."""
    volume, alone = Volume(SETTINGS), Volume(SETTINGS)
    depths = [np.full(CAMERA.shape, 1.0, np.float32)] * 40
    for depth in depths:
        alone.integrate(depth, CAMERA, np.eye(4))
    volume.integrate(depths[0], CAMERA, np.eye(4))
    wrong = []

    def see() -> None:
        for _ in range(40):
            seen = volume.raycast(CAMERA, np.eye(4)).depth
            wrong.append(not np.allclose(seen[20:-20, 20:-20], 1.0, atol=1e-4))

    thread = Thread(target=see)
    thread.start()
    for depth in depths[1:]:
        volume.integrate(depth, CAMERA, np.eye(4))
    thread.join()
    assert len(wrong) == 40 and not any(wrong)
    assert all(np.array_equal(a, b) for a, b in zip(inside(volume), inside(alone), strict=True))


def test_volumes_may_be_added_to_each_other_at_once():
    one, other = Volume(SETTINGS), Volume(SETTINGS)
    thread = Thread(target=lambda: [one.add(other) for _ in range(300)], daemon=True)
    thread.start()
    for _ in range(300):
        other.add(one)
    thread.join(60)
    assert not thread.is_alive()


def test_a_copy_of_a_volume_works_alone():
    one = filled(0)
    other = copy.deepcopy(one)
    other.integrate(waves(7), CAMERA, np.eye(4))
    assert all(np.array_equal(a, b) for a, b in zip(inside(one), inside(filled(0)), strict=True))


def test_spare_things_are_in_one_hand_and_bounded():
    made: list[list[str]] = []
    spare: Spare[str, list[str]] = Spare(lambda key: made.append([key]) or made[-1], most=2)
    with spare.taken("a") as first, spare.taken("a") as second:
        assert first is not second
    with spare.taken("b") as other:
        assert other == ["b"]
    with spare.taken("a") as again:
        assert again is second or again is first
    assert len(made) == 3
    with pytest.raises(ValueError, match="half"), spare.taken("a") as broken:
        raise ValueError("half written")
    with spare.taken("a") as later:
        assert later is not broken
