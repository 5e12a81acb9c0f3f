"""A frame that does not fit leaves nothing behind in the images that frames of one camera share."""

import numpy as np
import pytest

from fusion.errors import VolumeError
from fusion.geometry.camera import Camera
from fusion.volume.volume import Volume, VolumeSettings


def test_what_a_refused_frame_did_not_see_holds_no_surface_of_the_one_before():
    camera = Camera(128, 96, 110.0, 110.0, 63.5, 47.5)
    whole = np.full(camera.shape, 0.5, np.float32)
    part = whole.copy()
    part[:, :32] = np.nan
    volume, alone = (Volume(VolumeSettings(0.005, 0.02)) for _ in range(2))
    for image in (whole, part):
        alone.integrate(image, camera, np.eye(4))
    volume.integrate(whole, camera, np.eye(4))
    with pytest.raises(VolumeError, match="does not fit"):
        Volume(VolumeSettings(0.005, 0.02, max_bytes=50_000)).integrate(part, camera, np.eye(4))
    volume.integrate(part, camera, np.eye(4))
    n = volume.block_count
    assert n == alone.block_count
    assert np.array_equal(volume.blocks.voxels[:n], alone.blocks.voxels[:n])
