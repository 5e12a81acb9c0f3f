"""Kinect Studio's `.xef`: samples of tools/formats/writers/xef.py, which KinectXEFTools reads as written.

They hold three (plain) and two (archived) views of the rendered scene, with infrared of 800 + depth / 8.
"""

import lzma
import struct
from pathlib import Path

import numpy as np
import pytest
import rendered

from fusion import convert_recording, open_recording
from fusion.errors import RecordingError
from fusion.geometry.trajectory import Trajectory
from fusion.recording.formats.recorded.xef import BYTES, DEPTH
from fusion.recording.formats.recorded.xef_events import events_of

SAMPLES = Path(__file__).parent / "samples"
LENS = (365.0, 366.0, 250.0, 210.0)  # fx, fy, cx, cy [px] from the corner, of the picture as a person sees it
CAMERA = "365,366,249.5,209.5"
CLOSE = 0.15e-3  # as of phones: 0.2 px are more
KINDS = [("plain", 3), ("archived", 2)]


@pytest.fixture(params=KINDS, ids=[name for name, _ in KINDS])
def sample(request, tmp_path):
    name, frames = request.param
    path = tmp_path / "room.xef"
    path.write_bytes(unpacked(name))
    return path, frames


def unpacked(name):
    return lzma.decompress((SAMPLES / f"kinect_studio_{name}.xef.xz").read_bytes())


def test_scene_has_its_size_hand_clock_and_infrared(sample, tmp_path):
    path, frames = sample
    recording = open_recording(path, CAMERA)
    assert recording.format == "xef" and recording.camera.shape == (424, 512) and len(recording) == frames
    np.testing.assert_allclose(np.diff(recording.timestamps), [1 / 30, 0.1][: frames - 1], atol=1e-7)
    views = rendered.cameras(frames)
    placed = type(recording)(
        **{**vars(recording), "poses": Trajectory(recording.timestamps, views @ np.diag([1.0, -1, -1, 1]))}
    )
    seen = [rendered.depth(T, 512, 424, *LENS) for T in views]
    worst = np.abs(rendered.errors(placed, [face for _, face in seen]))
    assert len(worst) >= 4 * frames and worst.max() < CLOSE
    counts = np.rint(1000 * seen[1][0])
    np.testing.assert_array_equal(recording.depth_counts(1), counts)
    np.testing.assert_array_equal(recording[1].ir, np.where(counts > 0, 800 + counts // 8, 0))
    assert any("mirrored" in told for told in recording.warnings)
    convert_recording(recording, tmp_path / "native")
    np.testing.assert_array_equal(open_recording(tmp_path / "native").depth_counts(1), counts)


def test_its_camera_is_nominal_and_told(sample):
    recording = open_recording(sample[0])
    assert recording.camera.cx == pytest.approx(511 - 254.878) and recording.camera.principle == "itof"
    assert any("nominal Kinect v2" in told for told in recording.warnings)


def test_cut_off_is_read_as_far_as_it_is_whole(sample):
    path, frames = sample
    whole = path.read_bytes()
    last = events_of(path, {DEPTH: BYTES}).of(DEPTH).parts[-1]
    for end, left in ((len(whole) - 2000, frames), (last.begin + last.size // 2, frames - 1)):
        path.write_bytes(whole[:end])
        recording = open_recording(path)
        assert len(recording) == left and any("cut off or damaged" in told for told in recording.warnings)


def test_no_depth_and_noise_behind_the_head(tmp_path):
    path = tmp_path / "room.xef"
    path.write_bytes(unpacked("plain")[:0x4B4])  # the file's own properties alone
    with pytest.raises(RecordingError, match="no depth stream"):
        open_recording(path)
    rng = np.random.default_rng(0)
    for content in (b"EVENTS1\0", b"EVENTS1\0" + rng.bytes(5000), b"EVENTS1\0" + bytes(5000)):
        path.write_bytes(content)
        with pytest.raises(RecordingError):
            open_recording(path)


def test_several_records_of_unknown_content_in_a_row(tmp_path):
    """They often come so (KinectXEFTools' description), with any number where other events have their size."""
    path, data = tmp_path / "room.xef", unpacked("plain")
    at = data.index(struct.pack("<HHI", 0xFFFF, 0, 3), 0x4B4)
    more = b"".join(struct.pack("<HHIqII", 0xFFFF, 0, number, 5, 0, 0) + bytes(size)
                    for number, size in ((7, 0xC000), (300, 0x6000), (0, 0x7000)))  # fmt: skip
    path.write_bytes(data[:at] + more + data[at:])
    recording = open_recording(path)
    assert len(recording) == 3 and not any("cut off" in told for told in recording.warnings)
