"""A Kinect v2's raw images become the depth that a forward model, written apart, made them of."""

import sys
from pathlib import Path

import numpy as np
import pytest

from fusion.devices.kinect_v2.decode import LEVELS, decode
from fusion.devices.kinect_v2.tables import made_tables, read_lens, read_phases, undistorted
from fusion.errors import DeviceError

sys.path.insert(0, str(Path(__file__).resolve().parent))
import raw_frame

LENS = (365.4, 365.4, 258.7, 206.1, 0.0914, -0.2703, 0.0002, -0.0004, 0.0957)
INNER = (slice(1, -1), slice(2, -2))


def p0():
    """Smooth and different for each frequency, as devices have them."""
    v, u = np.mgrid[:424, :512]
    return np.stack([10_000 + 9_000 * f + 3 * u + 5 * v for f in range(3)]).astype(np.uint16)


@pytest.fixture(scope="module")
def tables():
    lens = read_lens(raw_frame.camera_parameters(*LENS))
    return made_tables(lens, read_phases(raw_frame.phase_tables(p0())))


def seen(z, tables, amplitude=3000.0, saturated=None):
    """What is decoded of a scene (rows of the sub-images), in the same rows."""
    x, y = raw_frame.rays(*LENS)
    amplitude = np.broadcast_to(np.asarray(amplitude, float), z.shape)
    made = decode(raw_frame.frame(z, x, y, amplitude, p0(), saturated), tables)
    return made.depth[::-1] / 1000, made.infrared[::-1]


def test_levels_are_those_of_the_notes():
    assert (LEVELS[0], LEVELS[256], LEVELS[257], LEVELS[1023], LEVELS[1024], LEVELS[1025]) == (
        0, 256, 258, 16320, 32767, -1,
    )  # fmt: skip
    np.testing.assert_array_equal(raw_frame.codes(LEVELS[:1024]), np.arange(1024))


def test_rays_undo_the_lens():
    x, y = raw_frame.rays(*LENS)
    lens = read_lens(raw_frame.camera_parameters(*LENS))
    u, v = np.meshgrid(np.arange(512) + 0.5, np.arange(424) + 0.5)
    mine = undistorted(lens, (u - lens.cx) / lens.fx, (v - lens.cy) / lens.fy)
    np.testing.assert_allclose(mine, (x, y), atol=1e-5)  # the lens is stored in 32 bits


@pytest.mark.parametrize("distance", [0.6, 1.0, 1.9, 2.6, 4.2])
def test_a_tilted_wall_comes_back(distance, tables):
    """Past 1.25, 1.875 and 2.5 m the phases have turned over; 4.2 m needs all three."""
    v, u = np.mgrid[:424, :512]
    z = distance + 0.0002 * (u - 256) + 0.0001 * (v - 212)
    depth, infrared = seen(z, tables)
    error = (depth - z)[INNER]
    found = depth[INNER] > 0
    assert found.mean() > 0.999
    # the decoder leaves out the square of the lamp's offset, 0.045^2 / 4 z; and codes hold 1 part in 256 to 512
    left_out = 0.045**2 / (4 * distance)
    assert abs(np.median(error[found]) - left_out) < 0.0003
    assert np.std(error[found]) < 0.002
    assert np.median(infrared[INNER]) == pytest.approx(16 * 3000, rel=0.01)


def test_what_is_faint_saturated_or_out_of_reach_has_no_depth(tables):
    v, u = np.mgrid[:424, :512]
    z = np.where(u < 400, 1.5, 5.0)
    amplitude = np.where(v < 100, 2.0, 3000.0)
    saturated = (u > 200) & (u < 220) & (v > 200) & (v < 220)
    depth, infrared = seen(z, tables, amplitude, saturated)
    assert (depth[:95] == 0).all()  # 2 < 3
    assert (depth[:, 405:] == 0).all()  # beyond 4.5 m
    assert (depth[202:219, 202:219] == 0).all()
    assert (infrared[202:219, 202:219] == 65535).all()
    assert (depth[110:190, 10:390] > 0).all()
    assert (depth[:, [0, -1]] == 0).all()  # these columns hold nothing


def test_nothing_floats_between_near_and_far(tables):
    """A mixed pixel at an edge, light of both alike: it is the depth of neither, and goes."""
    u = np.mgrid[:424, :512][1]
    near = u < 256
    x, y = raw_frame.rays(*LENS)
    one = raw_frame.measured(np.full(u.shape, 1.0), x, y, 3000.0, p0())
    other = raw_frame.measured(np.full(u.shape, 1.4), x, y, 3000.0, p0())
    share = np.where(u == 256, 0.5, near.astype(float))
    mixed = share * one + (1 - share) * other
    made = decode([raw_frame.packed(raw_frame.codes(value)) for value in mixed], tables)
    depth = made.depth[::-1] / 1000
    row = depth[200, 240:272]
    known = row[row > 0]
    assert (np.minimum(abs(known - 1.0), abs(known - 1.4)) < 0.05).all(), known
    assert 24 <= len(known) < 32


def test_the_first_row_of_the_picture_is_the_last_of_the_raw_images(tables):
    v = np.mgrid[:424, :512][0]
    depth, _ = seen(1.0 + v / 424, tables)
    assert np.nanmedian(depth[20, 100:400]) == pytest.approx(1.0 + 20 / 424, abs=0.003)


def test_what_is_not_whole_is_told(tables):
    with pytest.raises(DeviceError, match="raw images are not whole"):
        decode([bytes(10)] * 10, tables)
    with pytest.raises(DeviceError, match="raw images are not whole"):
        decode([], tables)
    with pytest.raises(DeviceError, match="cut off"):
        read_phases(bytes(100))
    with pytest.raises(DeviceError, match="parameters are none"):
        read_lens(bytes(92))
