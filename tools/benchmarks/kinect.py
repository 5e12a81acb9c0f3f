"""How much of a core the Kinect v1 driver takes at 30 frames a second.

    python -m tools.benchmarks.kinect --seconds 10

Transfers of libusb as they come from the camera (16 packets each, depth and colours in turn) are laid out in memory;
what is timed is all that the driver does with them: libusb1's walk over the packets, frames of packets, 11-bit values,
metres by the device's reference plane, Bayer colours. What the kernel and libusb do before is not in it. Frames are
random values, so nothing is easy; one of each second is compared with what was sent.
"""

import argparse
import ctypes
import json
import struct
import time
from collections.abc import Iterator

import numpy as np
import usb1
from usb1 import _libusb1 as libusb

from fusion.devices.kinect_v1.packets import BAYER, DEPTH_11, Assembler, RawFrame, StreamFormat
from fusion.devices.kinect_v1.pixels import color, raw_depth
from fusion.devices.kinect_v1.port import PACKET_BYTES, PACKETS
from fusion.recording.cameras.zero_plane import ZeroPlane

RATE = 30
PLANE = ZeroPlane(7.5, 2.4, 120.0, 0.1042, 200)  # of a typical unit


class Transfer:
    """One isochronous transfer in libusb's own form."""

    def __init__(self, packets: list[bytes]) -> None:
        self.pointer = libusb.libusb_alloc_transfer(PACKETS)
        self.buffer = ctypes.create_string_buffer(PACKETS * PACKET_BYTES)
        one = self.pointer.contents
        one.num_iso_packets = PACKETS
        for place, descriptor in enumerate(libusb.get_iso_packet_list(self.pointer)):
            data = packets[place] if place < len(packets) else b""
            descriptor.length, descriptor.actual_length, descriptor.status = PACKET_BYTES, len(data), 0
            ctypes.memmove(ctypes.addressof(self.buffer) + place * PACKET_BYTES, data, len(data))

    def packets(self) -> Iterator[tuple[int, bytearray]]:
        """As usb1.USBTransfer.iterISO gives them."""
        position = ctypes.addressof(self.buffer)
        for descriptor in libusb.get_iso_packet_list(self.pointer):
            yield descriptor.status, libusb.buffer_at(position, descriptor.actual_length)
            position += descriptor.length


def transfers(data: bytes, form: StreamFormat, number: int) -> list[Transfer]:
    """A frame in packets, 16 to a transfer."""
    made, first = [], number * form.packets
    for place in range(form.packets):
        kind = 1 if place == 0 else 5 if place == form.packets - 1 else 2
        head = struct.pack("<2sBBBBHI", b"RB", 0, form.base + kind, 0, (first + place) % 256, 0, 2_000_000 * number)
        made.append(head + data[place * form.payload : (place + 1) * form.payload])
    return [Transfer(made[i : i + PACKETS]) for i in range(0, len(made), PACKETS)]


def main() -> None:
    """Measure, and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=int, default=10, help="of the stream (default: 10)")
    options = parser.parse_args()
    usb1.loadLibrary()
    rng = np.random.default_rng(0)
    raw = rng.integers(0, 2048, (8, 480, 640)).astype(np.uint16)
    bits = [np.packbits((one.reshape(-1, 1) >> np.arange(10, -1, -1)) & 1).tobytes() for one in raw]
    pictures = rng.integers(0, 256, (8, BAYER.size)).astype(np.uint8)
    depth, video = [], []
    for number in range(256 // 2):  # numbers of packets go round within 128 frames of either
        depth.append(transfers(bits[number % 8], DEPTH_11, number))
        video.append(transfers(pictures[number % 8].tobytes(), BAYER, number))
    frames: list[RawFrame] = []
    shown: list[RawFrame] = []
    machines = Assembler(DEPTH_11, frames.append), Assembler(BAYER, shown.append)
    metres = PLANE.metres()
    spent = {"packets to frames": 0.0, "frames to values": 0.0, "values to metres": 0.0, "Bayer to colours": 0.0}
    for number in range(RATE * options.seconds):
        begin = time.thread_time()
        for machine, stream in zip(machines, (depth, video), strict=True):
            for transfer in stream[number % 128]:
                machine.feed(transfer.packets())
        packed = time.thread_time()
        values = raw_depth(frames.pop())
        unpacked = time.thread_time()
        metres[values]
        measured = time.thread_time()
        color(shown.pop())
        steps = (begin, packed, unpacked, measured, time.thread_time())
        for name, a, b in zip(spent, steps, steps[1:], strict=False):
            spent[name] += b - a
        assert number % RATE or np.array_equal(values, raw[number % 8])
    lost = sum(machine.counts.lost for machine in machines)
    shares = {name: round(seconds / options.seconds, 4) for name, seconds in spent.items()}
    told = {"share_of_a_core": shares, "together": round(sum(shares.values()), 4), "packets_lost": lost}
    print(json.dumps(told | {"packets": sum(machine.counts.packets for machine in machines)}, indent=1))


if __name__ == "__main__":
    main()
