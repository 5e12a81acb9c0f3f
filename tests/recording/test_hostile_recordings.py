"""A recording of somebody else: no reading outside, no flood, nothing that hangs, nothing wrong in silence."""

import os
import struct
import zlib

import numpy as np
import pytest
import synthetic

from fusion.errors import RecordingError
from fusion.recording.images.header import plain_png, read_header
from fusion.recording.images.read import read_color, read_counts, read_mask
from fusion.recording.looking.inspect import inspect
from fusion.recording.native.telemetry_file import read_telemetry
from fusion.recording.open import open_recording
from fusion.recording.writing.write import write_recording


def chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def png(width: int, height: int, bits: int = 16, kind: int = 0, more: bytes = b"") -> bytes:
    """A PNG that holds four grey rows of four, whatever its header says."""
    header = struct.pack(">IIBBBBB", width, height, bits, kind, 0, 0, 0)
    rows = zlib.compress(4 * (b"\0" + bytes(range(8))))
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + more + chunk(b"IDAT", rows) + chunk(b"IEND", b"")


@pytest.fixture
def folder(tmp_path):
    write_recording(tmp_path / "r", synthetic.CAMERA, synthetic.frames(3, color=True), synthetic.trajectory(3))
    return tmp_path / "r"


def replace_line(folder, name, old, new):
    text = (folder / name).read_text()
    assert old in text
    (folder / name).write_text(text.replace(old, new))


@pytest.mark.parametrize(
    "name", ["/etc/passwd", "../other/000001.png", "depth/../../other/000001.png", "link/000001.png"]
)
@pytest.mark.parametrize("table", ["depth.txt", "rgb.txt"])
def test_names_in_lists_stay_inside(folder, name, table, trusting):
    (folder.parent / "other").mkdir()
    (folder.parent / "other/000001.png").write_bytes((folder / "depth/000001.png").read_bytes())
    (folder / "link").symlink_to(folder.parent / "other")
    replace_line(folder, table, f"{table[:-4]}/000001.png", name)
    with pytest.raises(RecordingError, match=r"outside its folder.*--follow-links"):
        open_recording(folder)
    trusting(2.0, True)
    assert len(open_recording(folder)) == 3


@pytest.mark.parametrize("name", ["camera.json", "groundtruth.txt", "depth/000001.png", "rgb.txt"])
def test_parts_that_are_links_stay_inside(folder, name):
    away = folder.parent / "away"
    (folder / name).rename(away)
    (folder / name).symlink_to(away)
    with pytest.raises(RecordingError, match="outside its folder"):
        open_recording(folder)
    away.rename(folder / "kept")
    (folder / name).unlink()
    (folder / name).symlink_to(folder / "kept")
    assert len(open_recording(folder)) == 3


@pytest.mark.parametrize("make", [os.mkfifo, os.mkdir, lambda path: path.symlink_to("/dev/zero")])
@pytest.mark.parametrize("name", ["depth/000001.png", "camera.json", "groundtruth.txt", "telemetry.csv"])
def test_only_regular_files_are_read(folder, make, name):
    (folder / name).unlink(missing_ok=True)
    make(folder / name)
    with pytest.raises(RecordingError, match=r"regular|outside|no camera"):
        recording = open_recording(folder)
        inspect(recording)
        recording[1]


def test_a_header_is_believed_only_within_bounds(tmp_path):
    (tmp_path / "a.png").write_bytes(png(20000, 20000))
    with pytest.raises(RecordingError, match=r"20000 x 20000 pixels is too large.*--allow-gb"):
        read_counts(tmp_path / "a.png")
    (tmp_path / "a.png").write_bytes(png(4000, 4000))
    with pytest.raises(RecordingError, match="another size"):  # before it is decoded
        read_counts(tmp_path / "a.png", (4, 4))


@pytest.mark.parametrize(
    "wrong",
    [png(0, 4), png(4, 4, bits=7), png(4, 4, kind=5), png(4, 4, more=chunk(b"ABCD", b"x")), b"GIF89a" + bytes(99), b"",
     png(4, 4)[:-20], b"\xff\xd8\xff\xe0\0\x04ab" + bytes(50), b"II*\0" + bytes(99), b"BM" + bytes(99)],
)  # fmt: skip
def test_damaged_images_are_told_and_no_library_speaks(tmp_path, wrong, capfd):
    (tmp_path / "a.png").write_bytes(wrong)
    for read in (read_counts, read_color, read_mask):
        with pytest.raises(RecordingError, match=r"damaged|not a PNG"):
            read(tmp_path / "a.png")
    assert capfd.readouterr() == ("", "")


def test_spare_parts_never_reach_the_decoder(tmp_path, capfd):
    spare = chunk(b"iCCP", b"x\0\0abc") + chunk(b"gAMA", b"\0\0\0\1") + chunk(b"gAMA", b"\0\0\0\1")
    (tmp_path / "a.png").write_bytes(png(4, 4, more=spare))
    assert read_counts(tmp_path / "a.png").shape == (4, 4)
    assert capfd.readouterr() == ("", "")
    assert plain_png(png(4, 4, more=spare)) == png(4, 4)
    header = read_header(png(4, 4))
    assert (header.width, header.height, header.channels, header.depth) == (4, 4, 1, 2)


@pytest.mark.parametrize(
    ("name", "old", "new", "told"),
    [
        ("depth.txt", "100.000000", "1700000000000", "line 3.*seconds"),
        ("groundtruth.txt", " 0.000000000 ", " 1e300 ", "out of bounds|quaternion"),
        ("groundtruth.txt", "100.000000", "1e300", "seconds"),
    ],
)
def test_numbers_beyond_all_sense(folder, name, old, new, told):
    replace_line(folder, name, old, new)
    with pytest.raises(RecordingError, match=told):
        open_recording(folder)


def test_a_far_pose_is_told_with_its_line(folder):
    lines = (folder / "groundtruth.txt").read_text().splitlines()
    lines[1] = "100.0 1e9 0 0 0 0 0 1"
    (folder / "groundtruth.txt").write_text("\n".join(lines))
    with pytest.raises(RecordingError, match=r"line 2.*1e9 0 0.*1e\+07"):
        open_recording(folder)


def test_what_a_log_cannot_hold_is_left_out_and_told(folder):
    (folder / "telemetry.csv").write_text(
        "timestamp,turntable_deg,temperature_c\n100.1,3,20\n100.0,1e300,-9999\n100.2,4,nan\n"
    )
    recording = open_recording(folder)
    assert recording.telemetry["timestamp"].tolist() == [100.0, 100.1, 100.2]
    np.testing.assert_array_equal(recording.telemetry["turntable_deg"], [np.nan, 3, 4])
    np.testing.assert_array_equal(recording.telemetry["temperature_c"], [np.nan, 20, np.nan])
    told = " ".join(recording.warnings)
    assert (
        "1 of 3 values of turntable_deg" in told and "temperature_c" in told and "order of time (1 steps back)" in told
    )


@pytest.mark.parametrize("stamp", ["", "nan", "abc", "1e20"])
def test_a_stamp_of_a_log_is_a_number_of_seconds(tmp_path, stamp):
    (tmp_path / "telemetry.csv").write_text(f"timestamp,distance_m\n{stamp},1\n")
    with pytest.raises(RecordingError, match="line 2"):
        read_telemetry(tmp_path / "telemetry.csv")


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16"])
@pytest.mark.parametrize("end", ["\n", "\r\n"])
@pytest.mark.parametrize("name", ["camera.json", "depth.txt", "groundtruth.txt"])
def test_text_is_read_however_it_was_saved(folder, name, end, encoding):
    text = (folder / name).read_text()
    (folder / name).write_bytes(text.replace("\n", end).encode(encoding))
    assert len(open_recording(folder)) == 3


def test_null_bytes_are_refused_alike(folder):
    for name in ("camera.json", "depth.txt", "rgb.txt", "groundtruth.txt", "telemetry.csv", "scene.json"):
        path = folder / name
        good = path.read_bytes() if path.exists() else b"{}"
        path.write_bytes(good + b"\0")
        with pytest.raises(RecordingError, match="null byte"):
            open_recording(folder)
        path.unlink() if name in ("telemetry.csv", "scene.json") else path.write_bytes(good)
