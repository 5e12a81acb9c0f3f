"""Packets to frames to values: exact where all came, marked where it did not, counted in any case."""

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parent))
from fake_usb import packed, packets_of

from fusion.devices.kinect_v1.packets import BAYER, DEPTH_10, DEPTH_11, IR_10, Assembler, RawFrame
from fusion.devices.kinect_v1.pixels import color, infrared, raw_depth, unpack_10, unpack_11

RAW = np.random.default_rng(1).integers(0, 2048, (4, 480, 640)).astype(np.uint16)


def stream(count=4, sequence=250):
    """Packets of as many depth frames, numbered on from one to the next."""
    made = []
    for i in range(count):
        made += packets_of(packed(RAW[i], 11), 0x70, 1748, 1000 + i, sequence + 242 * i)
    return made


def assembled(packets, form=DEPTH_11):
    frames: list[RawFrame] = []
    machine = Assembler(form, frames.append)
    machine.feed((0, packet) if isinstance(packet, bytes) else packet for packet in packets)
    return frames, machine.counts


def test_the_numbers_of_each_stream():
    assert [(f.packets, f.size - (f.packets - 1) * f.payload) for f in (DEPTH_11, DEPTH_10, BAYER, IR_10)] == [
        (242, 1132), (220, 1188), (162, 12), (205, 1168),
    ]  # fmt: skip


def test_values_come_back_bit_for_bit():
    frames, counts = assembled(stream())
    assert [frame.ticks for frame in frames] == [1000, 1001, 1002, 1003]
    for frame, raw in zip(frames, RAW, strict=True):
        np.testing.assert_array_equal(raw_depth(frame), raw)
    assert (counts.packets, counts.frames, counts.lost, counts.damaged, counts.dropped) == (4 * 242, 4, 0, 0, 0)


@pytest.mark.parametrize(("bits", "unpack"), [(11, unpack_11), (10, unpack_10)])
def test_every_bit_has_its_place(bits, unpack):
    values = np.arange(2**bits, dtype=np.uint16)
    np.testing.assert_array_equal(unpack(packed(values, bits)), values)


def test_infrared_and_colours():
    ir = np.random.default_rng(2).integers(0, 1024, (488, 640)).astype(np.uint16)
    frames, _ = assembled(packets_of(packed(ir, 10), 0x80, 1908, 7, 3), IR_10)
    np.testing.assert_array_equal(infrared(frames[0]), ir[:480])
    # rows begin G R and B G: an image that is red alone, then green, then blue
    for channel, places in enumerate([[(0, 1)], [(0, 0), (1, 1)], [(1, 0)]]):
        bayer = np.zeros((480, 640), np.uint8)
        for v, u in places:
            bayer[v::2, u::2] = 200
        frames, _ = assembled(packets_of(bayer.tobytes(), 0x80, 1908, 7, 3), BAYER)
        inner = color(frames[0])[2:-2, 2:-2]
        expected = np.zeros(3)
        expected[channel] = 200
        np.testing.assert_array_equal(inner, np.broadcast_to(expected, inner.shape))


def lost_pixels(first, count):
    """(480, 640) True for values that have a bit in the packets from `first` on."""
    begin, end = first * 1748 * 8, min((first + count) * 1748, 422_400) * 8
    bits = np.arange(480 * 640) * 11
    return ((bits + 11 > begin) & (bits < end)).reshape(480, 640)


@pytest.mark.parametrize("first", [0, 1, 100, 239, 241])
@pytest.mark.parametrize("count", [1, 3, 5])
def test_up_to_five_lost_packets_leave_a_hole_and_no_wrong_value(first, count):
    packets = stream(3)
    del packets[242 + first : 242 + first + count]
    frames, counts = assembled(packets)
    assert (counts.lost, counts.resyncs, counts.dropped, len(frames)) == (count, 0, 0, 3)
    spill = max(0, first + count - 242)  # into the third frame
    holes = [np.zeros((480, 640), bool), lost_pixels(first, count - spill), lost_pixels(0, spill) if spill else None]
    for frame, raw, hole in zip(frames, RAW[:3], holes, strict=True):
        hole = np.zeros((480, 640), bool) if hole is None else hole
        np.testing.assert_array_equal(raw_depth(frame), np.where(hole, 2047, raw))
    assert [frame.ticks for frame in frames] == [1000, 1001, 1002]


@pytest.mark.parametrize("count", [6, 50, 255, 300])
def test_more_lost_packets_cost_the_frame_and_no_other(count):
    packets = stream(4)
    del packets[242 + 20 : 242 + 20 + count]
    frames, counts = assembled(packets)
    whole = [raw_depth(frame) for frame in frames]
    np.testing.assert_array_equal(whole[0], RAW[0])
    np.testing.assert_array_equal(whole[-1], RAW[3])
    for values in whole:  # no mixture of two frames passes for one
        assert any(np.array_equal(values, raw) for raw in RAW)
    assert counts.resyncs >= 1
    assert counts.dropped == 1


def test_what_begins_in_the_middle_waits_for_a_first_packet():
    frames, counts = assembled(stream(2)[100:])
    assert len(frames) == 1
    np.testing.assert_array_equal(raw_depth(frames[0]), RAW[1])
    assert counts.dropped == counts.lost == 0


def test_short_long_alien_and_failed_packets():
    packets = stream(3)
    packets[242 + 10] = packets[242 + 10][:500]
    packets[242 + 30] = packets[242 + 30] + b"more"
    packets[242 + 50] = (-71, packets[242 + 50])
    packets[242 + 60 : 242 + 60] = [b"", b"RB", b"XX" + bytes(40)]
    frames, counts = assembled(packets)
    assert (counts.short, counts.long, counts.failed, counts.alien, counts.lost) == (1, 1, 1, 2, 1)
    short = np.arange(480 * 640) * 11
    begin = (10 * 1748 + 488) * 8
    hole = ((short + 11 > begin) & (short < 11 * 1748 * 8)).reshape(480, 640)
    hole |= lost_pixels(30, 1) | lost_pixels(50, 1)
    np.testing.assert_array_equal(raw_depth(frames[1]), np.where(hole, 2047, RAW[1]))
    np.testing.assert_array_equal(raw_depth(frames[2]), RAW[2])


def test_no_stream_of_noise_brings_it_down_or_passes_for_a_frame():
    rng = np.random.default_rng(3)
    packets = stream(4)
    for _ in range(300):
        i = int(rng.integers(len(packets)))
        packet = bytearray(packets[i])
        packet[int(rng.integers(12))] = int(rng.integers(256))
        packets[i] = bytes(packet[: int(rng.integers(1, len(packet) + 1))])
    frames, counts = assembled(packets)
    for frame in frames:
        values = raw_depth(frame)
        assert any(((values == raw) | (values == 2047)).mean() == 1 for raw in RAW)
    assert counts.packets + counts.alien <= len(packets)
