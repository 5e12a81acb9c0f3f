"""A photograph's note of how to turn it for showing (EXIF) moves no pixel: cameras and poses are of the stored ones."""

import io

import numpy as np
import pytest
from PIL import Image

from fusion.recording.images.read import image_size, read_color


@pytest.mark.parametrize("orientation", range(1, 9))
def test_pixels_stay_as_they_are_stored(tmp_path, orientation):
    pixels = np.zeros((40, 64, 3), np.uint8)
    pixels[:16, :16] = (255, 0, 0)
    note, data = Image.Exif(), io.BytesIO()
    note[0x112] = orientation
    Image.fromarray(pixels).save(data, "JPEG", exif=note, quality=95)
    path = tmp_path / "photo.jpg"
    path.write_bytes(data.getvalue())
    found = read_color(path)
    assert found.shape == pixels.shape and image_size(path) == (64, 40)
    assert found[4, 4, 0] > 240 and found[-4:, -4:].max() < 10 and found[4, -4].max() < 10
