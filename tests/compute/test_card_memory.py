"""What a card is given and gives back, tried on a processor that is taken for one: it has arrays of its own too."""

from copy import deepcopy

import numpy as np
import pytest

from fusion.compute.cards import memory
from fusion.compute.language import F32, kernel
from fusion.compute.launch import Kernel
from fusion.compute.start import start
from fusion.geometry.camera import Camera
from fusion.volume.settings import VolumeSettings
from fusion.volume.volume import Volume

CAMERA = Camera(80, 60, 70.0, 70.0, 39.5, 29.5, (-0.1, 0.02, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0))
DOWN = 4096  # bytes that may come back of a frame
NUMBERS = 1024  # bytes of poses and settings that go up with an image


@kernel
def _double(given: F32, out: F32):
    for n in range(given.shape[0] // 2):
        out[n] = 2 * given[n]


@pytest.fixture(autouse=True)
def card(monkeypatch):
    start()
    monkeypatch.setattr(memory, "on_card", lambda: True)
    monkeypatch.setattr(Kernel, "quick", False)
    monkeypatch.setenv("FUSION_KERNELS", "plain")


def moved(work):
    """Bytes that go up and come down meanwhile."""
    before = memory.moved.up, memory.moved.down
    work()
    return memory.moved.up - before[0], memory.moved.down - before[1]


def test_what_a_kernel_leaves_unwritten_stays():
    given, out = np.arange(6, dtype=np.float32), np.full(6, 9, np.float32)
    assert moved(lambda: _double(given, out)) == (48, 48)
    assert out.tolist() == [0, 2, 4, 9, 9, 9] and given.tolist() == [0, 1, 2, 3, 4, 5]


def test_what_is_read_only_does_not_come_back_and_large_goes_up_once():
    given, out = np.ones(2000, np.float32), np.zeros(2000, np.float32)
    assert moved(lambda: _double(memory.read_only(given), out)) == (16000, 8000)
    given.flags.writeable = False
    assert moved(lambda: _double(given, out)) == (16000, 8000)
    assert moved(lambda: _double(given, out)) == (8000, 8000)


def test_what_is_kept_stays_there_until_it_is_fetched():
    given, out = np.ones(4, np.float32), memory.keep(np.full(4, 9, np.float32))
    for up in (32, 16):
        assert moved(lambda: _double(given, out)) == (up, 16)
    assert out.tolist() == [9, 9, 9, 9]
    assert moved(lambda: memory.fetch(out)) == (0, 16)
    assert out.tolist() == [2, 2, 9, 9]
    assert moved(lambda: memory.fetch(out)) == (0, 0)
    memory.fetch(out, changed=True)[3] = 5
    assert moved(lambda: _double(given, out)) == (32, 16)
    assert memory.fetch(out).tolist() == [2, 2, 9, 5]


def test_filled_arrays_do_not_go_up():
    given, out = np.ones(4, np.float32), memory.filled(4, 7, np.float32)
    assert moved(lambda: _double(given, out)) == (16, 16)
    assert memory.fetch(out).tolist() == [2, 2, 7, 7]


def test_nothing_is_held_that_is_let_go():
    count = len(memory._kept)
    array = memory.keep(np.zeros(4, np.float32))
    assert len(memory._kept) == count + 1
    del array
    assert len(memory._kept) == count


def frame(k):
    v, u = np.indices(CAMERA.shape)
    return (1.0 + 0.05 * np.sin(u / 9 + k / 40) + 0.05 * np.cos(v / 7)).astype(np.float32)


@pytest.mark.parametrize("color", [False, True])
def test_of_a_frame_its_images_go_up_and_little_comes_down(color, monkeypatch):
    image = np.full((*CAMERA.shape, 3), 99, np.uint8)
    volume, counted = Volume(VolumeSettings(0.01, 0.04, color=color)), []
    for k in range(8):
        size = len(volume.blocks.arrays.coordinates)
        bytes_ = moved(lambda k=k: volume.integrate(frame(k), CAMERA, np.eye(4), color=image if color else None))
        if len(volume.blocks.arrays.coordinates) == size:  # else memory grew, and all of it moves
            counted.append(bytes_)
    assert len(counted) >= 6
    images = frame(0).nbytes + (image.nbytes if color else 0)
    assert all(images <= up <= images + NUMBERS and down < DOWN for up, down in counted)
    mesh = volume.surface(min_weight=0.5)
    copied = deepcopy(volume)
    volume.integrate(frame(20), CAMERA, np.eye(4), color=image if color else None)
    assert np.array_equal(copied.surface(min_weight=0.5).vertices, mesh.vertices)
    monkeypatch.undo()
    monkeypatch.setenv("FUSION_KERNELS", "plain")
    same = Volume(VolumeSettings(0.01, 0.04, color=color))
    for k in range(8):
        same.integrate(frame(k), CAMERA, np.eye(4), color=image if color else None)
    expected = same.surface(min_weight=0.5)
    assert len(mesh.vertices) > 10_000 and np.array_equal(mesh.vertices, expected.vertices)
    assert np.array_equal(mesh.faces, expected.faces)
