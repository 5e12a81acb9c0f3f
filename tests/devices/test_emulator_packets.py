"""The emulator's own parts against the notes' numbers: packets in a frame, flags, sequence numbers, what is drawn."""

import importlib.util
import struct
from pathlib import Path

import numpy as np
import pytest

EMULATOR = Path(__file__).parent / "emulator"


def _part(name: str):
    spec = importlib.util.spec_from_file_location(f"emulator_{name}", EMULATOR / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


DRAWN, STREAM, CHANNEL = _part("drawn"), _part("stream"), _part("command_channel")


def test_it_shares_nothing_with_what_it_judges():
    for path in EMULATOR.glob("*.py"):
        assert not [line for line in path.read_text().splitlines() if "import" in line and "fusion" in line], path.name


def _frame(base: int, payload: int, roll, fault: str = "none", number: int = 4) -> list[bytes]:
    stream = STREAM.Stream(base, payload, 0, fault)
    stream.start(roll)
    stream.cursor = STREAM.first_microframe(number)
    end = STREAM.first_microframe(number + 1)
    return [stream.next_packet() for _ in range(end - stream.cursor)]


@pytest.mark.parametrize(
    ("base", "payload", "roll", "packets", "last"),
    [
        (0x70, 1748, DRAWN.depth_roll(), 242, 1132),
        (0x80, 1908, DRAWN.BayerRoll(), 162, 12),
        (0x80, 1908, DRAWN.infrared_roll(), 205, 1168),
    ],
    ids=["depth", "bayer", "infrared"],
)
def test_packets_are_those_of_the_notes(base, payload, roll, packets, last):
    """Counts and the last payload as in the table of the notes' section 4; flags; numbers in order."""
    sent = [data for data, status in _frame(base, payload, roll) if data and status == 0]
    assert len(sent) == packets
    assert len(sent[-1]) == 12 + last
    assert {data[:2] for data in sent} == {b"RB"}
    assert [data[3] for data in sent] == [base + 1, *[base + 2] * (packets - 2), base + 5]
    assert [data[5] for data in sent] == [k % 256 for k in range(packets)]
    assert {struct.unpack_from("<I", data, 8)[0] for data in sent} == {(4_200_000_000 + 4 * 2_000_000) % 2**32}


def test_depth_is_what_is_drawn():
    """Unpacked by numpy's own bits: pixel (u, v) of frame 4 shows row v + 4 of the drawing."""
    data = b"".join(data[12:] for data, _ in _frame(0x70, 1748, DRAWN.depth_roll()) if data)
    bits = np.unpackbits(np.frombuffer(data, np.uint8)).reshape(480, 640, 11)
    values = bits @ (1 << np.arange(10, -1, -1))
    for u, v in [(0, 0), (210, 150), (410, 210), (632, 100), (631, 479), (359, 295), (359, 296)]:
        assert values[v, u] == DRAWN.depth(u, (v + 4) % 480)


@pytest.mark.parametrize(
    ("fault", "there"),
    [("lost", 240), ("burst", 232), ("short", 242), ("magic", 242), ("swapped", 242), ("packet-error", 241)],
)
def test_a_planted_fault_is_in_every_tenth_frame_only(fault, there):
    roll = DRAWN.depth_roll()
    assert _frame(0x70, 1748, roll, fault, 4) == _frame(0x70, 1748, roll, "none", 4)
    spoiled, good = _frame(0x70, 1748, roll, fault, 13), _frame(0x70, 1748, roll, "none", 13)
    assert sum(bool(data) for data, _ in spoiled) == there
    assert spoiled != good


def test_commands_answer_with_their_tag():
    """A register that is set is read back; the blocks have the lengths that the notes give."""
    told = []
    channel = CHANNEL.Commands(lambda *change: told.append(change))

    def ask(command: int, payload: bytes) -> bytes:
        reply = channel.answer(struct.pack("<2sHHH", b"GM", len(payload) // 2, command, 77) + payload)
        assert struct.unpack_from("<2sHHH", reply) == (b"RB", len(reply[8:]) // 2, command, 77)
        return reply[8:]

    assert ask(0x03, struct.pack("<HH", 0x06, 2)) == b"\0\0"
    assert ask(0x02, struct.pack("<H", 0x06)) == struct.pack("<HH", 0, 2)
    assert told == [(0x06, 2)]
    fixed = ask(0x04, bytes(10))
    assert len(fixed) == 322
    assert struct.unpack_from("<4f", fixed, 94) == pytest.approx((7.5, 2.3, 120.0, 0.1042))
    sizes = {which: len(ask(0x16, struct.pack("<5H", which, 0, 1, 30, 0))) for which in (0x00, 0x40, 0x41)}
    assert sizes == {0x00: 4, 0x40: 118, 0x41: 8}
    assert channel.answer(b"XX" + bytes(6)) is None
