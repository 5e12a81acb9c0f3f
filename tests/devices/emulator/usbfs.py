"""The kernel's part: ioctls on a device's node as Linux's usbfs answers them, by umockdev.

A URB that is submitted is kept; a clock completes those that are due; a reap takes the oldest that is complete. A reap
without delay that finds none is kept waiting for up to 2 ms: the node always looks ready to libusb, which else asks
without end. Numbers of the ioctls and struct usbdevfs_urb: linux/usbdevice_fs.h, 64 bits.
"""

import errno
import struct
import time

import gi

gi.require_version("UMockdev", "1.0")
from gi.repository import UMockdev  # noqa: E402
from stream import MICROFRAMES  # noqa: E402

SUBMIT, DISCARD, REAP, REAP_NDELAY = 0x8038550A, 0x550B, 0x4008550C, 0x4008550D
CAPABILITIES, CONTROL, SPEED, GET_DRIVER, IOCTL = 0x8004551A, 0xC0185500, 0x551F, 0x41045508, 0xC0105512
# set interface and configuration, claim, release, reset, clear halt, disconnect and claim: nothing to do
PLAIN = {0x80085504, 0x80045505, 0x8004550F, 0x80045510, 0x5514, 0x80045515, 0x8108551B, 0x80045503}
ISO, CONTROL_URB = 0, 2
URB_BYTES, PACKET_BYTES = 56, 12
PATIENCE_S = 0.002


class Urb:
    """One transfer as it was submitted; `answer` is bytes (control), packets with their status, or a negative errno."""

    def __init__(self, raw: bytes, address: int) -> None:
        self.address = address
        self.kind, self.endpoint = raw[0], raw[1]
        self.length, self.packets = struct.unpack_from("<i", raw, 24)[0], struct.unpack_from("<i", raw, 36)[0]
        if self.kind != ISO:  # else the same place holds a stream's number
            self.packets = 0
        self.answer: bytes | list | int = 0


class Node:
    """One device's node. `strict`: what is due while no transfer is queued is lost, as on a real bus."""

    def __init__(self, device, power_on: float, strict: bool) -> None:
        self.device, self._power_on, self._strict = device, power_on, strict
        self.queued: dict[int, list[Urb]] = {}
        self.done: list[Urb] = []
        self._waiting: list[tuple[object, float, bool]] = []
        self.gone = self.silent = False
        self.streamed_since: float | None = None
        self.lost = 0
        self.handler = UMockdev.IoctlBase()
        self.handler.connect("handle-ioctl", self._handle)

    def _handle(self, _base, client) -> bool:
        request, arg = client.get_request() & 0xFFFFFFFF, client.get_arg()
        if request in (REAP, REAP_NDELAY):
            self._waiting.append((client, time.monotonic() + PATIENCE_S, request == REAP))
            self._reaped()
        elif self.gone:
            client.complete(-1, errno.ENODEV)
        elif request == SUBMIT:
            self._submit(client, arg)
        elif request == DISCARD:
            self._discard(client, arg)
        elif request == CAPABILITIES:
            arg.resolve(0, 4).update(0, struct.pack("<I", 0))
            client.complete(0, 0)
        elif request in PLAIN:
            client.complete(0, 0)
        elif request == SPEED:
            client.complete(3, 0)
        elif request == GET_DRIVER:
            client.complete(-1, errno.ENODATA)
        else:
            client.complete(-1, errno.ENOTTY)
        return True

    def _submit(self, client, arg) -> None:
        address = struct.unpack("<Q", arg.retrieve())[0]
        data = arg.resolve(0, URB_BYTES)
        urb = Urb(data.retrieve(), address)
        if urb.kind == CONTROL_URB:
            sent = bytes(data.resolve(16, urb.length).retrieve())
            urb.answer = self.device.control(*struct.unpack_from("<BBHHH", sent), sent[8:])
            self.done.insert(0, urb)  # does not wait behind the packets of a stream
        else:
            self.queued.setdefault(urb.endpoint, []).append(urb)
        client.complete(0, 0)

    def _discard(self, client, arg) -> None:
        address = struct.unpack("<Q", arg.retrieve())[0]
        for waiting in self.queued.values():
            for urb in waiting:
                if urb.address == address:
                    waiting.remove(urb)
                    urb.answer = -errno.ENOENT
                    self.done.append(urb)
                    client.complete(0, 0)
                    return
        client.complete(-1, errno.EINVAL)

    def unplug(self) -> None:
        """What was queued ends with ESHUTDOWN, as the kernel ends it; then all that is asked ends with ENODEV."""
        self.gone = True
        for urbs in self.queued.values():
            for urb in urbs:
                urb.answer = -errno.ESHUTDOWN
            self.done += urbs
            urbs.clear()

    def tick(self) -> None:
        """Completes what is due by now; called every millisecond."""
        if not self.gone and not self.silent:
            now = int((time.monotonic() - self._power_on) * MICROFRAMES)
            for endpoint, stream in self.device.streams.items():
                self._feed(stream, self.queued.setdefault(endpoint, []), now)
        self._reaped()

    def _feed(self, stream, queued: list[Urb], now: int) -> None:
        if stream.running and self.streamed_since is None:
            self.streamed_since = time.monotonic()
        if not stream.running or (self._strict and not queued):
            skipped = max(0, now - stream.cursor)
            self.lost += skipped if stream.running else 0
            if not queued:
                stream.skip(skipped)
        while queued and stream.cursor + queued[0].packets <= now:
            urb = queued.pop(0)
            urb.answer = [stream.next_packet() for _ in range(urb.packets)]
            self.done.append(urb)

    def _reaped(self) -> None:
        """Answers those who wait; an answer may bring the next request at once, so nothing is held over it."""
        for entry in tuple(self._waiting):
            client, until, patient = entry
            if entry not in self._waiting:
                continue
            late = time.monotonic() >= until
            if not (self.done or (late and (self.gone or not patient))):
                continue
            self._waiting.remove(entry)
            if self.done:
                _write(self.done.pop(0), client.get_arg().resolve(0, 8))
                client.complete(0, 0)
            else:
                client.complete(-1, errno.ENODEV if self.gone else errno.EAGAIN)


def _write(urb: Urb, place) -> None:
    """The answer into the memory of the one who asked, which can be written only while it waits in an ioctl.

    `place` is the pointer that a reap fills. What is resolved is written back whole, so never more than the URB has.
    """
    place.update(0, struct.pack("<Q", urb.address))
    data = place.resolve(0, URB_BYTES + PACKET_BYTES * urb.packets)
    status, actual = 0, 0
    if isinstance(urb.answer, int):
        status = urb.answer
    elif isinstance(urb.answer, bytes):  # control; of what was sent all was taken
        buffer = data.resolve(16, urb.length)
        going_in, room = buffer.retrieve()[0] >= 0x80, urb.length - 8
        actual = min(len(urb.answer), room) if going_in else room
        if going_in and actual:
            buffer.update(8, urb.answer[:room])
    else:
        actual = _write_packets(urb, data)
    data.update(4, struct.pack("<i", status))
    data.update(28, struct.pack("<i", actual))


def _write_packets(urb: Urb, data) -> int:
    """Packets lie one behind the other, each in the room that its descriptor has; returns how many bytes there are."""
    descriptors, filled = bytearray(data.retrieve()[URB_BYTES:]), bytearray(urb.length)
    start, total = 0, 0
    for k, (packet, status) in enumerate(urb.answer):
        room = struct.unpack_from("<I", descriptors, PACKET_BYTES * k)[0]
        kept = packet[:room]
        filled[start : start + len(kept)] = kept
        struct.pack_into("<Ii", descriptors, PACKET_BYTES * k + 4, len(kept), status)
        start, total = start + room, total + len(kept)
    data.resolve(16, urb.length).update(0, bytes(filled))
    data.update(URB_BYTES, bytes(descriptors))
    return total
