"""A Kinect v1 that is not there: camera, motor and audio on an emulated USB, for real libusb in another process.

    /usr/bin/python3 tests/devices/emulator/kinect_v1.py [--fault NAME] [--seconds N] [--serial S] [--strict]

It prints `UMOCKDEV_DIR=<dir>` when it is ready and stays until it is killed. Another program sees the camera with
`UMOCKDEV_DIR=<dir> LD_PRELOAD=libumockdev-preload.so.0 PROGRAM`. Needs Debian's packages umockdev, gir1.2-umockdev-1.0,
python3-gi. It was written from notes of the protocol alone and imports nothing of the project, whose driver it judges.
What the camera sees: drawn.py. Packet faults: stream.py. Faults (`--fault`):

    lost, burst     frames n with n mod 10 = 3 lack 2 (10) packets from packet 50 on; sequence numbers run on
    short           packet 50 of these frames has half its bytes
    magic           packet 50 of these frames begins with XX
    swapped         packets 50 and 51 of these frames come in the wrong order
    packet-error    packet 50 of these frames is empty and has the USB status EPROTO
    stall           every third control request to camera or motor ends with EPIPE
    late, mute      replies to commands take 0.4 s; never come
    reply-magic     every third reply begins with XX
    silent          2 s after the first stream began the packets stop for 1.5 s, while transfers stay queued
    unplug          2 s after the first stream began the whole device is gone for 1.5 s (ENODEV), then there again with
                    other addresses; `--times N` times
"""

import argparse
import os
import signal
import sys
import time

import gi

gi.require_version("UMockdev", "1.0")
from gi.repository import GLib, UMockdev  # noqa: E402
from identity import entry, sys_path  # noqa: E402
from units import Audio, Camera, Hub, Motor  # noqa: E402
from usbfs import Node  # noqa: E402

FAULTS = (
    "none", "lost", "burst", "short", "magic", "swapped", "packet-error", "stall", "late", "mute", "reply-magic",
    "silent", "unplug",
)  # fmt: skip
PRELOAD = "libumockdev-preload.so.0"
UNTIL_S, AWAY_S = 2.0, 1.5


class Bus:
    """The emulated USB with the device on it, or not."""

    def __init__(self, serial: str, fault: str, strict: bool, times: int) -> None:
        self.testbed = UMockdev.Testbed.new()
        self._serial, self._fault, self._strict, self._times = serial, fault, strict, times
        self._address = 1
        self._nodes: dict[str, tuple[int, Node]] = {}
        self._left: list[Node] = []
        self._away_since: float | None = None
        self.plug()

    def plug(self) -> None:
        power_on = time.monotonic()
        units = {
            "1-1": Hub(), "1-1.1": Camera(self._serial, self._fault), "1-1.2": Motor(self._fault),
            "1-1.3": Audio(self._serial),
        }  # fmt: skip
        for name, device in units.items():
            self._address += 1
            node = Node(device, power_on, self._strict)
            self.testbed.add_from_string(entry(name, 1, self._address, device.identity))
            self.testbed.attach_ioctl(f"/dev/bus/usb/001/{self._address:03d}", node.handler)
            self._nodes[name] = (self._address, node)
            self.testbed.uevent(f"/sys{sys_path(name)}", "add")
        self._away_since = None

    def unplug(self) -> None:
        for name, (_, node) in reversed(self._nodes.items()):
            node.unplug()  # and stays attached: whoever has it open is told so for ever
            self._left.append(node)
            self.testbed.uevent(f"/sys{sys_path(name)}", "remove")
            self.testbed.remove_device(f"/sys{sys_path(name)}")
        self._away_since = time.monotonic()

    def tick(self) -> bool:
        now = time.monotonic()
        camera = self._nodes["1-1.1"][1]
        due = camera.streamed_since is not None and now > camera.streamed_since + UNTIL_S
        if self._fault == "silent" and due:
            camera.silent = now < camera.streamed_since + UNTIL_S + AWAY_S
        if self._fault == "unplug" and self._away_since is None and due and self._times > 0:
            self._times -= 1
            self.unplug()
        if self._away_since is not None and now > self._away_since + AWAY_S:
            self.plug()
        for node in self._left:
            node.tick()
        if self._away_since is None:
            for _, node in self._nodes.values():
                node.tick()
        return True


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--fault", choices=FAULTS, default="none")
    parser.add_argument("--seconds", type=float, help="end by itself after so many")
    parser.add_argument("--serial", default="A00362A01234043A")
    parser.add_argument("--strict", action="store_true", help="packets that find no transfer queued are lost")
    parser.add_argument("--times", type=int, default=1, help="how often `unplug` happens")
    chosen = parser.parse_args()
    if PRELOAD not in os.environ.get("LD_PRELOAD", ""):  # udev must see the devices here too, to tell of them
        os.execve(sys.executable, [sys.executable, *sys.argv], {**os.environ, "LD_PRELOAD": PRELOAD})
    bus = Bus(chosen.serial, chosen.fault, chosen.strict, chosen.times)
    loop = GLib.MainLoop()
    GLib.timeout_add(1, bus.tick)
    if chosen.seconds:
        GLib.timeout_add(int(1000 * chosen.seconds), loop.quit)
    GLib.unix_signal_add(GLib.PRIORITY_DEFAULT, signal.SIGTERM, loop.quit)
    GLib.unix_signal_add(GLib.PRIORITY_DEFAULT, signal.SIGINT, loop.quit)
    sys.stdout.write(f"UMOCKDEV_DIR={bus.testbed.get_root_dir()}\n")
    sys.stdout.flush()
    loop.run()
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
