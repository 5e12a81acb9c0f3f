"""Choices before the start."""

import numpy as np
import pytest
import scenes

from fusion.errors import VolumeError
from fusion.geometry.camera import Camera
from fusion.volume.forecast import choose_truncation, choose_voxel, forecast_bytes
from fusion.volume.volume import Volume, VolumeSettings

CAMERA = Camera(160, 120, 140.0, 140.0, 79.5, 59.5)


def test_voxel_and_truncation():
    kinect = Camera(640, 480, 570.0, 570.0, 319.5, 239.5)
    assert choose_voxel(0.7, kinect) == pytest.approx(1.25e-3)
    assert choose_voxel(0.2, kinect) == 1e-3 and choose_voxel(3.0, kinect) == 2e-3
    assert 5e-3 <= choose_voxel(3.0, kinect, room=True) <= 20e-3
    assert choose_truncation(0.002, 0.0) == 0.008 and choose_truncation(0.002, 0.005) == 0.015
    for bad in (0.0, np.nan, -1.0):
        with pytest.raises(VolumeError):
            choose_voxel(bad, kinect)


@pytest.mark.parametrize("voxel", [0.004, 0.008])
def test_the_forecast_is_near_what_is_taken(voxel):
    T = scenes.look_at(np.array([0.5, 0.3, 0.4]), np.zeros(3))
    depth = scenes.plane(CAMERA, T, np.zeros(3), np.array([0.0, 0.0, 1.0]))
    depth[depth > 1.5] = np.nan
    settings = VolumeSettings(voxel, 4 * voxel)
    volume = Volume(settings)
    volume.integrate(depth, CAMERA, T)
    taken = volume.block_count * settings.block_bytes
    # one view of a slanted wall, border and stray corners included
    assert 0.4 < forecast_bytes(settings, depth, CAMERA) / taken < 2.0
    with pytest.raises(VolumeError):
        forecast_bytes(settings)
