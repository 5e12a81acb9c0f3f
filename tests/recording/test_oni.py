"""OpenNI's files: one of its own recorder (a driver without a camera), and rendered ones written as described."""

import hashlib
import struct
from pathlib import Path

import numpy as np
import pytest
import rendered
from hypothesis import given, settings
from hypothesis import strategies as st

from fusion import open_recording
from fusion.errors import RecordingError
from fusion.recording.formats.recorded.sixteen_z import unpack, unpack_with_table

# twelve frames by libOpenNI2 2.2.0.33 and its dummy device; what the program that recorded saw itself, as sha256
SAMPLE = Path(__file__).parent / "samples" / "openni2_dummy.oni"
SEEN = {
    9: "1a77e696db3d2bdfd6f3b623f6c675bdbbb4cf78cea457092e04b5db38a6ffb1",
    10: "37a7945247d45b81013a9b48b8c88bf08072741d90b8654c33d94591b5d67036",
    11: "4d0ea1b3b025fba62c7ea920848b8a18958af45e61033fc270f89ea6709eb1b0",
}
LENS = (300.0, 302.0, 166.0, 114.0)  # of 320 x 240, from the first pixel's centre


def packed(values):
    """16z, pixel by pixel."""
    out, half, zeros = bytearray(int(values[0]).to_bytes(2, "little")), None, 0

    def nibble(value):
        nonlocal half
        if half is None:
            half = value
        else:
            out.append(half << 4 | value)
            half = None

    def flush_zeros():
        nonlocal zeros, half
        if zeros >= 2 and half is not None:
            nibble(0xD) if zeros % 2 == 0 else nibble(6)
            zeros -= zeros % 2
        while zeros >= 2:
            pairs = min(zeros // 2, 15 - 1)
            out.append(0xE0 + pairs)
            zeros -= 2 * pairs
        if zeros:
            nibble(6)
        zeros = 0

    for before, now in zip(values[:-1].tolist(), values[1:].tolist(), strict=True):
        step = before - now
        if step == 0:
            zeros += 1
            continue
        flush_zeros()
        if abs(step) <= 6:
            nibble(step + 6)
            continue
        if half is not None:
            nibble(0xF)
        else:
            out.append(0xFF)
        out += bytes([step + 192]) if -64 <= step <= 63 else now.to_bytes(2, "big")
    flush_zeros()
    if half is not None:
        nibble(0xD)
    return bytes(out)


def with_table(values):
    table = np.unique(values)
    numbers = np.searchsorted(table, values)
    return len(table).to_bytes(2, "little") + table.astype("<u2").tobytes() + packed(numbers)


def record(kind, fields=b"", data=b"", node=1):
    return struct.pack("<4sIIIIQ", b"NIR\0", kind, node, 28 + len(fields), len(data), 0) + fields + data


def named(name, data):
    name = name.encode() + b"\0"
    return len(name).to_bytes(4, "little") + name + len(data).to_bytes(4, "little") + data


def oni(path, codec, mirrored=False, view=None):
    data = b"NI10" + bytes(20)
    data += record(0x0D, named("Depth", b"")[:-4] + struct.pack("<I4sIQQQ", 2, codec, 3, 0, 0, 0))
    data += record(0x06, named("xnMapOutputMode", struct.pack("<3I", 320, 240, 30)))
    data += record(0x03, named("xnMirror", int(mirrored).to_bytes(8, "little")))
    data += record(0x06, named("xnFOV", struct.pack("<2d", *view))) if view else b""
    fx, fy, cx, cy = LENS
    for i, T in enumerate(rendered.cameras()):
        z, _ = rendered.depth(T, 320, 240, fx, fy, cx + 0.5, cy + 0.5)
        counts = np.rint(1000 * z).astype("<u2")[:, :: -1 if mirrored else 1]
        image = {b"NONE": lambda c: c.tobytes(), b"16zP": packed, b"16zT": with_table}[codec](counts.ravel())
        data += record(0x0A, struct.pack("<QI", 33_333 * i, i), image)
    path.write_bytes(data + record(0x0B, node=0))
    return path


def test_the_recorders_own_file():
    recording = open_recording(SAMPLE, "290,290,159.5,119.5")
    assert recording.format == "oni" and len(recording) == 12 and not recording.warnings
    np.testing.assert_allclose(np.diff(recording.timestamps), 0.033)
    for index, seen in SEEN.items():
        assert hashlib.sha256(recording.depth_counts(index).astype("<u2").tobytes()).hexdigest() == seen


@pytest.mark.parametrize("codec", [b"NONE", b"16zP", b"16zT"])
@pytest.mark.parametrize("mirrored", [False, True])
def test_a_rendered_scene(tmp_path, codec, mirrored):
    recording = open_recording(oni(tmp_path / "x", codec, mirrored), ",".join(map(str, LENS)))
    assert any("mirrored" in told for told in recording.warnings) == mirrored
    for frame, T in zip(recording, rendered.cameras(), strict=True):
        z, _ = rendered.depth(T, 320, 240, LENS[0], LENS[1], LENS[2] + 0.5, LENS[3] + 0.5)
        # half a millimetre: the counts
        np.testing.assert_allclose(np.nan_to_num(frame.depth), z, atol=0.51e-3)


def test_a_camera_by_its_field_of_view(tmp_path):
    # what OpenNI states for a Kinect v1, whose preset has 575.8 px at twice the size
    recording = open_recording(oni(tmp_path / "x", b"NONE", view=(1.0144686707507438, 0.78980943449644714)))
    assert recording.camera.fx == pytest.approx(575.8 / 2, abs=0.05) and recording.camera.cx == 160
    assert any("nominal" in told for told in recording.warnings)
    with pytest.raises(RecordingError, match="no field of view"):
        open_recording(SAMPLE)


@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(st.integers(0, 32767), st.integers(1, 40)), min_size=1, max_size=60), st.booleans())
def test_packing_comes_out_as_it_went_in(runs, smooth):
    values = np.concatenate([np.full(n, v) for v, n in runs])
    if smooth:
        values = np.clip(np.cumsum(values % 13 - 6) + 900, 0, 32767)
    np.testing.assert_array_equal(unpack(packed(values), len(values)), values)
    np.testing.assert_array_equal(unpack_with_table(with_table(values), len(values)), values)


def test_changed_and_cut_files_are_one_line(tmp_path):
    whole = SAMPLE.read_bytes()
    random = np.random.default_rng(5)
    for k in range(60):
        data = bytearray(whole[: random.integers(len(whole))] if k % 3 == 0 else whole)
        for at in random.integers(0, max(1, len(data) if k % 2 else min(800, len(data))), 4):
            data[at : at + 1] = bytes([random.integers(256)])
        (tmp_path / "bad").write_bytes(bytes(data))
        try:
            list(open_recording(tmp_path / "bad", "290,290,159.5,119.5"))
        except RecordingError as problem:
            assert "\n" not in str(problem)
