"""A phone's confidence of its own pixels becomes noise, and so weight in tracking and fusion alike."""

from dataclasses import replace

import numpy as np
import pytest
import test_phones

from fusion import convert_recording, open_recording
from fusion.sensor.files.sensor_file import read_sensor
from fusion.volume.prepared import fusing_weight, prepare

WRITERS = {"r3d": test_phones.record3d, "polycam": test_phones.polycam, "stray": test_phones.stray}


@pytest.fixture(params=WRITERS)
def middle(request, tmp_path, monkeypatch):
    """A recording whose right half is of middle confidence, rows 0 to 9 of the lowest."""
    levels = test_phones.CONFIDENCE.copy()
    levels[10:, 80:] = 1
    monkeypatch.setattr(test_phones, "CONFIDENCE", levels)
    return open_recording(WRITERS[request.param](tmp_path / "x", test_phones.Scene()))


def test_middle_confidence_weighs_less(middle):
    frame = middle[0]
    factor = frame.noisier.max()
    assert (frame.noisier[:, :80] == 1).all() and (frame.noisier[10:, 80:] == factor).all()
    assert 2 <= factor < 2.5  # at least twice; a scene of planes and millimetres scatters about alike in both halves
    assert any("pixels of middle confidence count" in told for told in middle.warnings)
    assert np.isnan(frame.depth[:10]).all()  # the lowest stays missing
    sensor = read_sensor("kinect-v2-indoors")
    plain = prepare(replace(frame, noisier=None), middle.camera, sensor)
    told = prepare(frame, middle.camera, sensor)
    there = np.isfinite(frame.depth)
    # tracking takes sigma, fusion takes weight
    np.testing.assert_allclose(told.surface.sigma[there], (frame.noisier * plain.surface.sigma)[there], rtol=1e-5)
    both = (told.weight > 0) & (plain.weight > 0)
    # normals, and with them the tilt that noise depends on, are smoothed over a little more of the surface
    ratio = np.where(both, plain.weight / np.where(both, told.weight, 1), np.nan) / frame.noisier**2
    assert np.nanmedian(ratio[:, :80]) == pytest.approx(1, abs=1e-4) and np.nanmedian(ratio[10:, 80:]) == pytest.approx(
        1, rel=0.01
    )
    assert np.nanmean(fusing_weight(told, 0.2)[10:, 80:]) < 0.26 * np.nanmean(fusing_weight(plain, 0.2)[10:, 80:])


def test_what_is_sure_is_as_it_was(tmp_path):
    recording = open_recording(test_phones.record3d(tmp_path / "x", test_phones.Scene()))
    assert all(frame.noisier is None for frame in recording)
    frame, sensor = recording[0], read_sensor("kinect-v2-indoors")
    ones = np.ones(frame.depth.shape, np.float32)
    pairs = zip(*(_images(one, recording, sensor) for one in (frame, replace(frame, noisier=ones))), strict=True)
    for without, with_ in pairs:
        np.testing.assert_array_equal(with_, without)


def _images(frame, recording, sensor):
    made = prepare(frame, recording.camera, sensor)
    return made.weight, made.surface.sigma, made.surface.normals


def test_more_noise_is_measured(tmp_path, monkeypatch):
    """Where the middle level scatters five times as much, that is its factor."""
    levels = np.full((120, 160), 2, np.uint8)
    levels[:, 80:] = 1
    random = np.random.default_rng(0)
    noise = random.normal(0, 1, (120, 160)) * np.where(levels == 1, 5e-3, 1e-3)
    monkeypatch.setattr(test_phones, "CONFIDENCE", levels)
    monkeypatch.setattr(test_phones.Scene, "rendered", lambda scene, i: (1.0 + noise, np.zeros((120, 160), int)))
    recording = open_recording(test_phones.record3d(tmp_path / "x", test_phones.Scene()))
    # the median of 9000 deviations is sure to 1 %, three times over
    assert recording[0].noisier.max() == pytest.approx(5, rel=0.05)


def test_cameras_of_single_frames_take_it_along(tmp_path, monkeypatch):
    levels = np.full((120, 160), 2, np.uint8)
    levels[:, 80:] = 1
    monkeypatch.setattr(test_phones, "CONFIDENCE", levels)
    recording = open_recording(test_phones.record3d(tmp_path / "x", test_phones.Scene(lens=test_phones.MOVED)))
    moved = recording[1].noisier
    # the principal point moved by 6 of 640 px to the right: 1.5 of 160, and with it the border
    assert len(np.unique(moved)) == 2 and 77 <= int((moved[60] == 1).sum()) <= 80


def test_what_has_no_place_is_told(middle, tmp_path):
    notes = []
    convert_recording(middle, tmp_path / "native", notes)
    assert any("confidence of single pixels" in note for note in notes)
