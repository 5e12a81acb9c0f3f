"""Images as PNG files: others read back what was packed, value for value."""

import io

import cv2
import numpy as np
import pytest
from PIL import Image

from fusion.recording.images.png import png_bytes

SIZES = [(480, 640), (1, 1), (3, 1), (1, 7), (17, 33)]


@pytest.mark.parametrize("size", SIZES)
def test_counts_come_back(size):
    counts = np.random.default_rng(1).integers(0, 1 << 16, size, np.uint16)
    data = png_bytes(counts)
    assert np.array_equal(cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED), counts)
    assert np.array_equal(np.asarray(Image.open(io.BytesIO(data))), counts)


@pytest.mark.parametrize("size", SIZES)
def test_colours_come_back(size):
    color = np.random.default_rng(2).integers(0, 256, (*size, 3), np.uint8)
    data = png_bytes(color)
    assert np.array_equal(cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR_RGB), color)
    assert np.array_equal(np.asarray(Image.open(io.BytesIO(data))), color)


def test_parts_of_images_and_other_kinds_of_numbers_come_back():
    """A camera's own buffers are turned about and cut."""
    color = np.random.default_rng(3).integers(0, 256, (20, 30, 3), np.uint8)[::-1, 4:17, ::-1]
    assert np.array_equal(np.asarray(Image.open(io.BytesIO(png_bytes(color)))), color)
    infrared = np.arange(30, dtype=np.uint8).reshape(5, 6)
    assert np.array_equal(np.asarray(Image.open(io.BytesIO(png_bytes(infrared)))), infrared)


def test_a_smooth_image_takes_little_room():
    ramp = np.tile(np.arange(640, dtype=np.uint16), (480, 1))
    assert len(png_bytes(ramp)) < ramp.nbytes / 20
