"""Azure Kinect's `.mkv`: a file of the maker's own library (tools/formats/samples), and files written as described."""

import gzip
import json
import struct
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent / "bags"))

import box_scene
import cv2
import matroska

from fusion import open_recording
from fusion.errors import RecordingError
from fusion.files.content import Content
from fusion.recording.formats.azure.calibration import cameras_of
from fusion.recording.formats.azure.matroska import read_matroska

SAMPLES = Path(__file__).parent / "samples"
TOLD = json.loads((SAMPLES / "azure_pixels.json").read_text())
SIZES = {"NFOV_2X2BINNED": (320, 288), "NFOV_UNBINNED": (640, 576), "WFOV_2X2BINNED": (512, 512)}
COLORS = {"720P": (1280, 720), "1536P": (2048, 1536)}
SMALL = (320, 288)


@pytest.fixture(scope="module")
def sample(tmp_path_factory):
    path = tmp_path_factory.mktemp("azure") / "recorded"  # by content, not by name
    path.write_bytes(gzip.decompress((SAMPLES / "azure_box.mkv.gz").read_bytes()))
    return path


@pytest.fixture
def recording(sample):
    return open_recording(sample)


def cameras(mode, color):
    return cameras_of(Content(TOLD["calibration"], "here", error=RecordingError), SIZES[mode], COLORS[color])


@pytest.mark.parametrize("mode", TOLD["modes"])
def test_pixels_and_points_are_the_library_s(mode):
    """Depth's rays to a thousandth of a pixel, colour's pixels of these points to a hundredth."""
    known, rays = cameras(*mode.split()), cameras(*mode.split()).depth.rays()
    for row in (row for row in TOLD["modes"][mode] if row["point"]):
        u, v = row["pixel"]
        off = (rays[v, u] - np.array(row["point"][:2])) * known.depth.fx
        assert np.abs(off).max() < 1e-3
        point = known.T_color_depth @ [*row["point"], 1.0]
        assert known.color.project(point[None, :3])[0] == pytest.approx(row["color"], abs=0.01)


def test_scene_is_where_it_stands(recording):
    """Depth along the library's rays, seen through the camera of the file: 0.1 % and 0.2 px are asked."""
    assert (recording.format, recording.camera.shape, recording.camera.principle) == ("azure-mkv", (288, 320), "itof")
    assert (recording.camera.serial, recording.camera.depth_scale) == ("000123", 1000)
    for index, frame in enumerate(recording):
        expected = box_scene.depth(recording.camera.rays().astype(float), index)
        off = np.abs(frame.depth - expected)
        edges = cv2.dilate((np.abs(cv2.Laplacian(expected, cv2.CV_64F)) > 0.02).astype(np.uint8), np.ones((3, 3))) > 0
        assert np.nanmax(off[~edges]) < 0.51e-3 and np.isfinite(frame.depth).all()
        assert np.nanmean(off[edges] > 1e-3) < 0.02  # not a pixel of the box's outline lies elsewhere


def test_a_radius_of_nothing_is_the_usual_one():
    """The maker's own files state 0 for the colour camera."""
    stated = json.loads(json.dumps(TOLD["calibration"]))
    for camera in stated["CalibrationInformation"]["Cameras"]:
        camera["MetricRadius"] = 0
    known = cameras_of(Content(stated, "here", error=RecordingError), SMALL, (1280, 720))
    assert known.radius == 1.7 and known.color is not None


def test_half_a_pixel_would_be_seen(recording):
    shifted = recording.camera.rays().astype(float) + 0.5 / recording.camera.fx
    off = np.abs(recording[0].depth - box_scene.depth(shifted, 0))
    assert np.mean(off > 0.51e-3) > 0.01


def test_clock_is_the_device_s(recording):
    np.testing.assert_allclose(recording.timestamps, 1.5 + 0.033333 * np.arange(3), atol=1e-6)


def test_infrared_lies_in_the_pixels_of_depth(recording):
    for index, frame in enumerate(recording):
        assert frame.ir.dtype == np.uint16 and (frame.ir[7] == 300 + 10 * index + np.arange(320)).all()


def test_colour_keeps_its_place_and_one_that_is_missing_is_told(recording):
    assert recording.streams.color.tolist() == [True, False, True]
    assert "1 of 3 frames have no colour image" in recording.warnings
    assert recording.color_apart(1) is None and recording[0].color is None
    image = recording.color_apart(2)
    assert image.shape == (720, 1280, 3) == (*recording.camera.color.shape, 3)
    v, u = np.mgrid[:720, :1280]
    assert np.abs(image[..., 0].astype(int) - u * 255 // 1280).mean() < 3  # packed by JPEG
    assert np.abs(image[..., 1].astype(int) - v * 255 // 720).mean() < 3


def test_a_camera_that_is_given_goes_before_the_file_s(sample):
    recording = open_recording(sample, camera="250,251,160,144")
    assert recording.camera.parameters[:4].tolist() == [250, 251, 160, 144] and recording.camera.shape == (288, 320)
    assert recording.camera.color is not None  # which the file alone knows


def written(tmp_path, tracks=None, clusters=None, calibration=TOLD["calibration"], tags=(), unknown=False, scale=1000):
    tracks = tracks or [(1, "DEPTH", "b16g", *SMALL)]
    clusters = [matroska.cluster(0, [(1, 0, image(1000))])] if clusters is None else clusters
    path = tmp_path / "written.mkv"
    path.write_bytes(matroska.matroska(matroska.heads(tracks, calibration, tags, scale), clusters, unknown))
    return path


def image(value, size=SMALL):
    return np.full(size[::-1], value, ">u2").tobytes()


def test_beyond_the_lens_there_is_no_depth(tmp_path):
    """What the library gives no ray (a wide mode's corners) is missing; what it gives one is there."""
    clusters = [matroska.cluster(0, [(1, 0, image(1000, (512, 512)))])]
    recording = open_recording(written(tmp_path, [(1, "DEPTH", "b16g", 512, 512)], clusters))
    depth = recording[0].depth
    for row in TOLD["modes"]["WFOV_2X2BINNED 720P"]:
        u, v = row["pixel"]
        assert np.isfinite(depth[v, u]) == (row["point"] is not None)
    assert 0.6 < np.isfinite(depth).mean() < 0.95


def test_colour_that_is_not_packed(tmp_path):
    width, height = COLORS["720P"]
    blue = np.full((height, width, 4), [200, 40, 10, 255], np.uint8)
    for codec, data in (("BGRA", blue.tobytes()), ("NV12", nv12(blue)), ("YUY2", yuy2(width, height))):
        tracks = [(1, "DEPTH", "b16g", *SMALL), (2, "COLOR", codec, width, height)]
        recording = open_recording(written(tmp_path, tracks, [matroska.cluster(0, [(1, 0, image(900)), (2, 5, data)])]))
        assert recording.color_apart(0).reshape(-1, 3).mean(axis=0) == pytest.approx([10, 40, 200], abs=3), codec


def nv12(bgra):
    y, u, v = yuv()
    height, width = bgra.shape[:2]
    return (
        np.full((height, width), y, np.uint8).tobytes()
        + np.tile(np.array([u, v], np.uint8), height * width // 4).tobytes()
    )


def yuy2(width, height):
    y, u, v = yuv()
    return np.tile(np.array([y, u, y, v], np.uint8), width * height // 2).tobytes()


def yuv():
    """BT.601's limited range, of red 10, green 40, blue 200."""
    r, g, b = 10, 40, 200
    y = 16 + (65.481 * r + 128.553 * g + 24.966 * b) / 255
    u = 128 + (-37.797 * r - 74.203 * g + 112.0 * b) / 255
    v = 128 + (112.0 * r - 93.786 * g - 18.214 * b) / 255
    return round(y), round(u), round(v)


def test_stamps_of_any_tick_and_start(tmp_path):
    clusters = [matroska.cluster(10, [(1, 0, image(900)), (1, 33, image(901))])]
    path = written(tmp_path, clusters=clusters, tags=[("K4A_START_OFFSET_NS", "2000000000")], scale=1_000_000)
    assert open_recording(path).timestamps.tolist() == pytest.approx([2.010, 2.043])


def test_lengths_that_were_never_written(tmp_path):
    """A file whose writer was stopped: segment and clusters of no known length."""
    clusters = [matroska.cluster(33333 * k, [(1, 0, image(900 + k))], unknown=True) for k in range(3)]
    recording = open_recording(written(tmp_path, clusters=clusters, unknown=True))
    assert [round(1000 * float(frame.depth[9, 9])) for frame in recording] == [900, 901, 902]


def test_a_file_that_was_cut_off_is_read_as_far_as_it_is_whole(sample, tmp_path):
    data = sample.read_bytes()
    (tmp_path / "cut").write_bytes(data[: len(data) * 3 // 4])
    recording = open_recording(tmp_path / "cut")
    assert 0 < len(recording) < 3 and any("cut off" in told for told in recording.warnings)
    assert np.isfinite(recording[len(recording) - 1].depth).all()


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"calibration": None}, "the recording has no camera"),
        ({"calibration": {"CalibrationInformation": {"Cameras": []}}}, "no depth camera"),
        ({"calibration": {"nothing": 1}}, "CalibrationInformation"),
        ({"clusters": []}, "the recording is empty"),
        ({"tracks": [(1, "DEPTH", "b16g", 33, 44)]}, "of no known mode"),
        ({"tracks": [(1, "DEPTH", "b16g", 60000, 60000)]}, "too large"),
    ],
)
def test_what_cannot_be_read_is_said(tmp_path, change, said):
    with pytest.raises(RecordingError, match=said):
        open_recording(written(tmp_path, **change))


def test_an_image_of_another_size_is_that_frame_s_fault_alone(tmp_path):
    clusters = [matroska.cluster(0, [(1, 0, image(900)), (1, 33, b"short")])]
    recording = open_recording(written(tmp_path, clusters=clusters))
    assert recording[0].depth[0, 0] == pytest.approx(0.9)
    with pytest.raises(RecordingError, match="another size"):
        recording[1]


def test_another_matroska_video_is_known_by_name(tmp_path):
    path = written(tmp_path, [(1, "video", "MJPG", 640, 480)], [])
    with pytest.raises(RecordingError, match="without Azure Kinect's depth"):
        open_recording(path)


def test_several_images_in_a_block_are_refused(tmp_path):
    block = matroska.element("A3", b"\x81" + struct.pack(">hB", 0, 0x02) + image(900))
    clusters = [matroska.element("1F43B675", matroska.element("E7", b"\0") + block)]
    with pytest.raises(RecordingError, match="several images"):
        open_recording(written(tmp_path, clusters=clusters))


def test_an_hour_is_opened_without_its_images(tmp_path):
    """20 000 frames, whose images are holes in the file: only heads are read."""
    path, tracks = tmp_path / "hour.mkv", [(1, "DEPTH", "b16g", *SMALL)]
    block, length = bytes.fromhex("A3"), 4 + len(image(0))
    with path.open("wb") as file:
        file.write(matroska.matroska(matroska.heads(tracks, TOLD["calibration"]), [], unknown=True))
        for k in range(20_000):
            stamp = matroska.element("E7", matroska.whole(33_333 * k))
            file.write(bytes.fromhex("1F43B675") + matroska.size(None) + stamp)
            file.write(block + matroska.size(length) + b"\x81" + struct.pack(">hB", 0, 0))
            file.seek(length - 4, 1)
        file.truncate()
    held = read_matroska(path)
    assert len(held.tracks[1].parts) == 20_000 and held.whole
    assert held.tracks[1].ticks[-1] == 33_333 * 19_999
