"""Depth in images that are no PNG: 16-bit PGM and TIFF, TIFF of metres, whole or broken."""

import numpy as np
import pytest
from PIL import Image

from fusion.errors import RecordingError
from fusion.recording.open import open_recording

CAMERA = "525,525,3.5,2.5"
COUNTS = np.arange(900, 948, dtype=np.uint16).reshape(6, 8)


def pgm(path):
    path.with_suffix(".pgm").write_bytes(b"P5\n8 6\n65535\n" + COUNTS.astype(">u2").tobytes())


def tiff(path):
    Image.fromarray(COUNTS).save(path.with_suffix(".tif"), compression="tiff_lzw")


def big_endian(path):
    Image.frombytes("I;16B", (8, 6), COUNTS.astype(">u2").tobytes()).save(path.with_suffix(".tiff"))


def real(path):
    values = COUNTS / np.float32(1000)
    values[0, 0], values[0, 1] = np.nan, 0
    Image.fromarray(values.astype(np.float32)).save(path.with_suffix(".tiff"))


@pytest.mark.parametrize("place", ["", "depth"])
@pytest.mark.parametrize("write", [pgm, tiff, big_endian, real])
def test_depth_is_read_as_it_was_written(tmp_path, write, place):
    (tmp_path / place).mkdir(exist_ok=True)
    for index in (2, 10):
        write(tmp_path / place / f"{index}")
    found = open_recording(tmp_path, CAMERA)
    assert len(found) == 2 and found.format == "plain"
    depth = found[1].depth
    np.testing.assert_allclose(depth[1:], COUNTS[1:] / 1000, rtol=1e-6)
    assert np.isnan(depth[0, :2]).all() == (write is real)


@pytest.mark.parametrize("write", [pgm, tiff])
def test_beside_colour_they_are_a_folder_of_open3d(tmp_path, write):
    for name in ("depth", "color"):
        (tmp_path / name).mkdir()
    write(tmp_path / "depth" / "1")
    Image.fromarray(np.full((6, 8, 3), 90, np.uint8)).save(tmp_path / "color" / "1.png")
    frame = open_recording(tmp_path, CAMERA)[0]
    assert frame.color is not None and np.nanmax(frame.depth) == pytest.approx(0.947)


@pytest.mark.parametrize(("name", "taken"), [("rgb", True), ("depth_vis", False)])
def test_colours_beside_depth_go_with_it_in_order(tmp_path, name, taken):
    for index in (2, 10):
        pgm(tmp_path / f"depth_{index}")
        Image.fromarray(np.full((6, 8, 3), 10 * index, np.uint8)).save(tmp_path / f"{name}_{index}.png")
    found = open_recording(tmp_path, CAMERA)
    assert found.format == "plain"
    # a picture of the depth in colours is no photograph
    assert [
        frame.color is not None and frame.color[0, 0, 0] == k for frame, k in zip(found, (20, 100), strict=True)
    ] == [taken] * 2


@pytest.mark.parametrize("write", [pgm, tiff, real])
def test_a_cut_file_is_named(tmp_path, write, capfd):
    write(tmp_path / "1")
    write(tmp_path / "2")
    path = next(tmp_path.glob("2.*"))
    path.write_bytes(path.read_bytes()[:-50])
    with pytest.raises(RecordingError, match="damaged") as told:
        open_recording(tmp_path, CAMERA)[1]
    assert path.name in str(told.value) and not capfd.readouterr().err


def test_a_tiff_of_colours_is_no_depth(tmp_path):
    Image.fromarray(np.zeros((6, 8, 3), np.uint8)).save(tmp_path / "1.tif")
    with pytest.raises(RecordingError, match="no recording"):
        open_recording(tmp_path, CAMERA)
