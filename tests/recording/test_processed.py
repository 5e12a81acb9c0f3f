"""Processing that the camera did: raw frames of every simulator give no alarm, filtered ones do."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from fusion import Camera, Frame, Recording, open_recording, read_sensor, sense_all
from fusion.recording.checks.processed import check_processed
from fusion.recording.looking.sample import draw
from fusion.sensor.presets import PRESETS

SIZE = (240, 180)
NOISY = [name for name in PRESETS if "sunlight" not in name]  # there a wall of grey paint is not seen at all


def recording(depths, principle):
    camera = Camera(*SIZE, 240.0, 240.0, 119.5, 89.5, principle=principle)
    frames = [Frame(i, i / 30, np.asarray(depth, np.float32)) for i, depth in enumerate(depths)]
    return Recording(Path("made"), "native", camera, np.arange(len(frames)) / 30, frames.__getitem__)


@pytest.fixture(scope="module", params=NOISY)
def raw(request):
    """Twenty frames of a slanted wall with a board before it."""
    sensor = read_sensor(request.param)
    camera = Camera(*SIZE, 240.0, 240.0, 119.5, 89.5, principle=sensor.principle)
    u, v = np.meshgrid(np.linspace(-1, 1, SIZE[0]), np.linspace(-1, 1, SIZE[1]))
    scene = (1.2 + 0.2 * u + 0.1 * v).astype(np.float32)
    scene[50:130, 80:150] = 0.8
    frames = sense_all([scene] * 20, camera, sensor, seed=1)
    return recording([frame.depth for frame in frames], sensor.principle)


def told(depths, principle):
    return check_processed(draw(recording(depths, principle)))


def millimetres(depth):
    return np.round(depth * 1000) / 1000


def test_raw_frames_are_no_alarm(raw):
    assert not check_processed(draw(raw))


def test_a_filter_over_time_is_seen(raw):
    """RealSense's and Orbbec's temporal filter with its usual weight of 0.4 for what is new."""
    made, before = [], None
    for frame in raw:
        now = frame.depth
        both = None if before is None else np.isfinite(now) & np.isfinite(before)
        before = now if both is None else np.where(both, 0.4 * now + 0.6 * np.where(both, before, 0), now)
        made.append(millimetres(before))
    assert any("smoothed in time" in finding.seen for finding in told(made, raw.camera.principle))


def test_holes_that_were_filled_are_seen(raw):
    if raw.camera.principle in ("itof", "unknown"):  # the phone's LiDAR is of no known principle
        pytest.skip("light that comes back along its way leaves no side of a rim unseen")
    made = [_filled(frame.depth) for frame in raw]
    assert any("holes were filled" in finding.seen for finding in told(made, raw.camera.principle))


def test_smoothing_over_pixels_is_seen_where_pixels_measure_alone(raw):
    made = [millimetres(cv2.bilateralFilter(np.nan_to_num(frame.depth), 5, 0.03, 2.0)) for frame in raw]
    made = [np.where(np.isfinite(frame.depth), z, np.nan) for frame, z in zip(raw, made, strict=True)]
    seen = [finding for finding in told(made, raw.camera.principle) if "over pixels" in finding.seen]
    assert bool(seen) == (raw.camera.principle == "itof")
    assert all(finding.severity == "ok" for finding in seen)


def test_a_camera_that_moves_is_no_filter(raw):
    """A shake of 8 mm in 10 frames, far above the noise."""
    shake = 8e-3 * np.sin(np.arange(len(raw)) * 0.6)
    made = [frame.depth + s for frame, s in zip(raw, shake.astype(np.float32), strict=True)]
    assert not told(made, raw.camera.principle)


def _filled(depth):
    """From the left, as RealSense's hole filling does by default."""
    made = depth.copy()
    for u in range(1, made.shape[1]):
        made[:, u] = np.where(np.isfinite(made[:, u]), made[:, u], made[:, u - 1])
    return np.where(np.isfinite(made), made, np.nanmedian(depth))


@pytest.mark.real
@pytest.mark.parametrize(
    ("name", "camera"),
    [("kinect_v2_floor", "kinect-v2"), ("custard_box", None), ("kleenex_turntable", None), ("robot_arm_boxes", None),
     ("tum_fr1_rpy", "tum-fr1"), ("ycbv_0000", None), ("azure_kinect_mkv/recording.mkv", None)],
)  # fmt: skip
def test_real_recordings_are_no_alarm(shared, name, camera):
    opened = open_recording(shared / "data" / name, camera)
    assert not [finding for finding in check_processed(draw(opened)) if finding.severity != "ok"]


def test_frames_that_repeat_are_told_as_such(raw):
    depths = [raw[i].depth for i in range(20)]
    twice = [f"{f.check} {f.seen}" for f in told([depths[i // 2] for i in range(40)], "itof")]
    assert len(twice) == 1 and "8 of 16 frames" in twice[0]
    (still,) = told([depths[0]] * 20, "unknown")
    assert "15 of 16 frames" in still.seen
