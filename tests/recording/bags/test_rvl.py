"""RVL against a packer written from the paper, nibble by nibble."""

import struct

import box_scene
import numpy as np
import pytest
import ros_bags

from fusion.recording.formats.bags.messages.rvl import unpack_rvl
from fusion.recording.open import open_recording


def packed(counts):
    """A. D. Wilson 2017, listing 1: runs of zeros and of others, differences with the sign in the lowest bit."""
    nibbles, flat = [], [int(value) for value in counts.ravel()]

    def put(value):
        while True:
            nibble, value = value & 7, value >> 3
            nibbles.append(nibble | 8 if value else nibble)
            if not value:
                return

    at, before = 0, 0
    while at < len(flat):
        start = at
        while at < len(flat) and flat[at] == 0:
            at += 1
        put(at - start)
        start = at
        while at < len(flat) and flat[at] != 0:
            at += 1
        put(at - start)
        for value in flat[start:at]:
            step = value - before
            put((step << 1) ^ (step >> 63))
            before = value
    nibbles += [0] * (-len(nibbles) % 8)
    words = [int("".join(f"{nibble:x}" for nibble in nibbles[i : i + 8]), 16) for i in range(0, len(nibbles), 8)]
    return struct.pack(f"<{len(words)}I", *words)


IMAGES = {
    "noise": lambda rng: rng.integers(0, 65536, (13, 17)),
    "holes": lambda rng: rng.integers(500, 600, (24, 31)) * (rng.random((24, 31)) > 0.4),
    "empty": lambda rng: np.zeros((5, 7), int),
    "full": lambda rng: np.full((5, 7), 65535),
    "one pixel": lambda rng: np.ones((1, 1), int),
    "begins with zeros": lambda rng: np.arange(30).reshape(5, 6) // 9,
}


@pytest.mark.parametrize("name", IMAGES)
def test_what_was_packed_comes_back(name):
    counts = IMAGES[name](np.random.default_rng(3)).astype(np.uint16)
    np.testing.assert_array_equal(unpack_rvl(packed(counts), counts.shape[1], counts.shape[0]), counts)


def test_in_a_bag(tmp_path):
    out = ros_bags.Writer(tmp_path / "bag", "mcap")
    for frame, seconds in enumerate(ros_bags.stamps()):
        out.info(f"{ros_bags.DEPTH}/camera_info", ros_bags.SIZE, ros_bags.LENGTHS, seconds, "d")
        data = struct.pack("<iffII", 0, 0.0, 0.0, *ros_bags.SIZE) + packed(ros_bags.stored(frame, "16UC1"))
        form = "16UC1; compressedDepth rvl"
        out.packed(f"{ros_bags.DEPTH}/image_raw/compressedDepth", data, form, seconds, "d")
    out.bag.close()
    for frame, read in enumerate(open_recording(tmp_path / "bag")):
        expected = box_scene.depth(box_scene.rays(*ros_bags.SIZE, *ros_bags.LENGTHS), frame)
        known = np.isfinite(read.depth)
        np.testing.assert_allclose(read.depth[known], expected[known], atol=0.51e-3)
