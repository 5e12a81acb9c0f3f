"""What masks do to a scan's frames: the region is the object's, outside nothing is aligned or fused."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from fusion.errors import TrackingError
from fusion.geometry.camera import Camera
from fusion.recording.images.masks import open_masks
from fusion.recording.open import open_recording
from fusion.recording.recording import Frame
from fusion.recording.writing.write import write_recording
from fusion.scan.finding.frames import load, seen_again
from fusion.scan.finding.region import find_region
from fusion.scan.settings import ScanSettings
from fusion.sensor.sensor import Sensor

CAMERA = Camera(160, 120, 130.0, 130.0, 79.5, 59.5, depth_scale=5000.0)
COUNT = 6


def scene(index):
    """A slab at 0.6 m that moves over a wall at 1 m, and where it is: (120, 160) [m], bool."""
    mask = np.zeros(CAMERA.shape, bool)
    mask[40:90, 50 + 4 * index : 90 + 4 * index] = True
    return np.where(mask, 0.6, 1.0).astype(np.float32), mask


@pytest.fixture
def masked(tmp_path):
    """Recording and settings with a mask per frame; the mask of frame 2 is empty: the object is not there."""
    write_recording(tmp_path / "rec", CAMERA, (Frame(i, i / 10, scene(i)[0]) for i in range(COUNT)))
    recording = open_recording(tmp_path / "rec")
    (tmp_path / "masks").mkdir()
    for i, name in enumerate(recording.files.depth):
        cv2.imwrite(str(tmp_path / "masks" / name.split("/")[-1]), 255 * (scene(i)[1] & (i != 2)).astype(np.uint8))
    return recording, ScanSettings(mask=tmp_path / "masks")


def test_the_region_is_what_the_masks_show(masked):
    recording, settings = masked
    region = find_region(recording, Sensor(), settings, open_masks(settings.mask, recording))
    # the slab's depth, and the margin of 15 mm; half a per cent of the points at each end is left out
    assert region.low[2] == pytest.approx(0.585, abs=0.001) and region.high[2] == pytest.approx(0.615, abs=0.001)
    left, right = (50 + 2 - 79.5) / 130 * 0.6 - 0.015, (90 + 20 - 3 - 79.5) / 130 * 0.6 + 0.015
    # a pixel is 4.6 mm there
    assert region.low[0] == pytest.approx(left, abs=0.006) and region.high[0] == pytest.approx(right, abs=0.006)


def test_outside_nothing_is_aligned_or_fused_but_points_stay(masked):
    recording, settings = masked
    masks = open_masks(settings.mask, recording)
    region = find_region(recording, Sensor(), settings, masks)
    frames, broken = load(recording, Sensor(), region, masks)
    window = region.window(CAMERA)
    assert broken == {}
    for i, frame in enumerate(frames):
        inside = scene(i)[1][window] & (i != 2)
        assert np.array_equal(np.isfinite(frame.depth), inside)
        assert not np.isfinite(frame.surface.normals[~inside]).any()
        assert np.isfinite(frame.surface.points).all()  # they say where the object is not
    assert np.isfinite(frames[0].surface.normals[..., 0]).sum() > 1000


def test_masks_without_depth_are_told(masked):
    recording, settings = masked
    masks = open_masks(settings.mask, recording)
    nothing = np.full(CAMERA.shape, np.nan, np.float32)
    blind = replace(recording, load=lambda i: Frame(i, i / 10, nothing))
    with pytest.raises(TrackingError, match="hold no depth"):
        find_region(blind, Sensor(), settings, masks)


@pytest.mark.parametrize("with_masks", [False, True])
def test_another_camera_sees_what_was_read_as_if_it_were_read_anew(masked, with_masks):
    recording, settings = masked
    masks = open_masks(settings.mask, recording)
    region = find_region(recording, Sensor(), settings, masks)
    before, _ = load(recording, Sensor(), region, masks if with_masks else None)
    other = replace(recording, camera=replace(CAMERA, fx=150.0, fy=150.0))
    squeeze = np.array([130 / 150, 130 / 150, 1.0])
    squeezed = replace(region, low=squeeze * region.low, high=squeeze * region.high)
    window = squeezed.window(other.camera)
    assert window == region.window(CAMERA)
    anew, _ = load(other, Sensor(), squeezed)
    for again, frame in zip(seen_again(before, other, Sensor(), window), anew, strict=True):
        assert np.array_equal(again.depth, frame.depth, equal_nan=True)
        assert np.array_equal(again.surface.points, frame.surface.points, equal_nan=True)
        assert np.array_equal(again.surface.normals, frame.surface.normals, equal_nan=True)
        assert np.array_equal(again.weight, frame.weight)
