"""Depth nearer or farther than a camera of its kind can measure is a wrong unit."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import synthetic

from fusion.geometry.camera import Camera
from fusion.recording.checks.depth_values import check_depth_values
from fusion.recording.looking.sample import draw
from fusion.recording.open import open_recording
from fusion.recording.recording import Frame, FrameStreams, Recording
from fusion.recording.writing.write import write_recording

CAMERA = Camera(40, 30, 35.0, 35.0, 19.5, 14.5, depth_scale=1000.0, principle="structured_light")
SCENE = np.tile(np.linspace(0.7, 2.1, 40, dtype=np.float32), (30, 1))  # what stands on a table, and the wall behind


def findings(times, principle="structured_light", counted=True):
    camera, depth = replace(CAMERA, principle=principle), SCENE * np.float32(times)
    counts = np.minimum(1000 * depth, 65534).astype(np.uint16)
    streams = FrameStreams(counts=lambda i: counts) if counted else None
    recording = Recording(
        Path("made_up"), "native", camera, np.arange(8) / 10, lambda i: Frame(i, i / 10, depth), streams=streams
    )
    return check_depth_values(draw(recording, 8, 8))


def errors(times, principle="structured_light"):
    return [f.seen for f in findings(times, principle) if f.severity == "error"]


def test_five_times_too_far_is_doubted_where_a_camera_may_see_as_far():
    (found,) = findings(5.0, "unknown")
    assert found.severity == "warning" and "depth_scale 5000 (1.4 m)" in found.do
    (usual,) = findings(1.0, "unknown")
    assert usual.severity == "ok"


def test_real_numbers_in_millimetres_are_no_matter_of_a_scale():
    (found,) = findings(1000.0, "unknown", counted=False)
    assert found.severity == "error" and "depth_scale" not in found.seen and "write metres" in found.do


@pytest.mark.parametrize("principle", ["structured_light", "itof"])
@pytest.mark.parametrize("times", [0.1, 10.0])
def test_ten_times_too_small_or_large_is_told(times, principle):
    (seen,) = errors(times, principle)
    assert "depth_scale" in seen


def test_a_fifth_is_nearer_than_a_projector_lets_see():
    (seen,) = errors(0.19)
    assert "nearer than such cameras measure" in seen
    assert errors(0.19, "active_stereo") == []  # some of these see from 7 cm on


@pytest.mark.parametrize("times", [0.5, 1.0, 3.0])
def test_what_cameras_measure_passes(times):
    assert errors(times) == []


@pytest.mark.parametrize(("value", "told"), [(750.0, True), (0.75, False)])
def test_distances_in_millimetres_are_told_as_such(tmp_path, value, told):
    log = {"timestamp": [0.0, 1.0], "distance_m": [value, value]}
    write_recording(tmp_path / "wall", synthetic.CAMERA, synthetic.frames(2), telemetry=log)
    warnings = open_recording(tmp_path / "wall").warnings
    assert any("these look like millimetres" in text for text in warnings) == told
