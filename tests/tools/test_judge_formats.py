"""The judge of the formats: it sees what is planted, and nothing where nothing is."""

import zlib

import cv2
import numpy as np
import pytest

from tools.formats.boxes import seen, way
from tools.formats.cases import PLAIN, RATIONAL, cases
from tools.formats.scenes import row
from tools.formats.writers import xef
from tools.formats.writers.programs import Tools

CASES = {case.name: case for case in cases(Tools(only="none of them"))}


def test_a_whole_recording_is_right(tmp_path):
    found = row(CASES["native"], tmp_path)
    assert found.reached and found.measured["hand"] == "right" and found.measured["frames"] == 4
    # rounding to 0.2 mm alone
    assert found.measured["size_pct"] < 0.001 and found.measured["place_px"] < 0.001
    assert found.measured["spread_mm"] < 0.06 and found.measured["turn_deg"] < 1e-5


@pytest.mark.parametrize(("name", "key", "value"), [
    ("PLANTED half a pixel", "place_px", 0.5), ("PLANTED 0.2 % larger", "size_pct", 0.2),
    ("PLANTED mirrored", "hand", "mirrored"),
])  # fmt: skip
def test_what_is_planted_is_measured(tmp_path, name, key, value):
    found = row(CASES[name], tmp_path)
    assert not found.reached
    assert found.measured[key] == (value if isinstance(value, str) else pytest.approx(value, abs=0.002))


def test_the_judges_lens_is_opencvs():
    rays = RATIONAL.rays()[::40, ::40].reshape(-1, 2)
    points = np.column_stack([rays, np.ones(len(rays))])
    pixels = cv2.projectPoints(points, np.zeros(3), np.zeros(3), RATIONAL.matrix, np.array(RATIONAL.bend))[0]
    v, u = np.mgrid[: RATIONAL.height : 40, : RATIONAL.width : 40]
    np.testing.assert_allclose(pixels.reshape(-1, 2), np.stack([u, v], axis=-1).reshape(-1, 2), atol=1e-6)


def test_the_scene_shows_what_is_measured_on_it():
    """Three walls and three sides of the box, each with a good share of the image."""
    for T in way(4):
        z, which = seen(PLAIN.rays(), T)
        shares = [np.mean(which == index) for index in range(9)]
        assert (z > 0.4).all() and sum(share > 0.01 for share in shares) >= 5


@pytest.mark.parametrize("archived", [False, True])
def test_a_kinect_studio_file_lies_as_it_is_described(tmp_path, archived):
    """Where streams begin, and how an archived file packs: by KinectXEFTools' description, which its reader follows."""
    case = CASES["Kinect Studio .xef"]
    data = xef.write(case.take, tmp_path / "a", archived).read_bytes()
    assert data[:8] == b"EVENTS1\0" and int.from_bytes(data[12:16], "little") == (0 if archived else 4)
    begin = 0x4B4 + (24 + 0xC000 if archived else 0)
    assert data[begin : begin + 2] == b"\x01\0" and data[begin + 48 :].startswith("Nui Body".encode("utf-16-le"))
    depth = np.ascontiguousarray(case.take.counts(0.001)[0, :, ::-1]).astype("<u2").tobytes()
    packed = zlib.compress(depth, 1)
    assert packed[:2] == b"\x78\x01" and data.count(packed if archived else depth) == 4
