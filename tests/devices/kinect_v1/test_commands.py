"""Commands, tables, parts that belong together, motor: what the device is told, and what is made of its answers."""

import struct
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parent))
from fake_usb import SERIAL, FakeDevice

from fusion.devices.kinect_v1.commands import Commands
from fusion.devices.kinect_v1.find import find_kinect, kinects
from fusion.devices.kinect_v1.motor import Motor
from fusion.devices.kinect_v1.registration import color_camera
from fusion.devices.kinect_v1.streaming import DeviceClock
from fusion.devices.kinect_v1.tables import read_tables, read_zero_plane
from fusion.errors import DeviceError
from fusion.recording.cameras.zero_plane import ZeroPlane

TYPICAL = ZeroPlane(7.5, 2.4, 120.0, 0.1042, 200)


def test_registers_are_set_and_read_though_replies_are_late():
    camera = FakeDevice(late=5)
    commands = Commands(camera)
    commands.set(0x12, 3)
    assert commands.get(0x12) == 3
    # an earlier command's answer, which came too late for it, is not taken for this one's
    camera.stale = [struct.pack("<2sHHHH", b"RB", 1, 3, 1, 0), bytes(512)]
    commands.set(0x13, 1)
    assert camera.registers == {0x12: 3, 0x13: 1}


def test_a_silent_or_garbled_device_is_told():
    with pytest.raises(DeviceError, match="does not answer; in Kinect v1; found no reply to command 0x2"):
        Commands(FakeDevice(late=10**9), patience=0.05).get(1)
    for how, found in (("magic", "begins with 58 58"), ("length", "bytes, of which")):
        with pytest.raises(DeviceError, match=f"not understood.*{found}"):
            Commands(FakeDevice(garble=how)).get(1)


def test_depth_follows_from_the_reference_plane():
    commands = Commands(FakeDevice())
    plane = read_zero_plane(commands)
    assert plane == ZeroPlane(7.5, pytest.approx(2.4), 120.0, pytest.approx(0.1042), 200)
    metres = plane.metres()
    # kinect_v1_protocol, section 6: millimetres by libfreenect's formula, and the fit of others at 0.7 m
    expected = {0: 317, 300: 437.7, 400: 501.1, 600: 705.9, 800: 1193.8, 900: 1824, 1000: 3864, 1050: 8767}
    for raw, millimetres in expected.items():
        assert metres[raw] == pytest.approx(millimetres / 1000, rel=2e-3)
    assert metres[600] == pytest.approx(0.1236 * np.tan(600 / 2842.5 + 1.1863), rel=2e-3)
    assert np.isnan(metres[[1100, 2000, 2047]]).all()
    assert np.all(np.diff(metres[:1050]) > 0)
    assert plane.camera("").fx == pytest.approx(575.8, abs=0.1)
    tables = read_tables(commands, plane)
    assert (len(tables.registration), len(tables.padding)) == (29, 3)


def test_a_reference_plane_that_cannot_be_is_told(monkeypatch):
    for values in ((0, 2.4, 120, 0.1), (7.5, 2.4, float("nan"), 0.1), (7.5, 2.4, 120, 1e9)):
        monkeypatch.setattr("fake_usb.PLANE", values)
        with pytest.raises(DeviceError, match="calibration cannot be used"):
            read_zero_plane(Commands(FakeDevice()))


def test_the_registration_table_becomes_a_colour_camera():
    numbers = [0] * 29
    numbers[5], numbers[10], numbers[17], numbers[20] = 10_000, 4000, -3000, -3000  # start and slope of both axes
    depth = TYPICAL.camera("")
    camera, about = color_camera(depth, TYPICAL, numbers)
    assert "to 0.00 px rms" in about
    assert camera.color is not None
    assert camera.T_color_depth is not None
    for z in (0.6, 1.0, 3.0):
        points = depth.points(np.full((480, 640), z, np.float32))[::60, ::80].reshape(-1, 3)
        at = points @ camera.T_color_depth[:3, :3].T + camera.T_color_depth[:3, 3]
        v, u = np.mgrid[0:480:60, 0:640:80].reshape(2, -1)
        # the protocol's equations, written out for a table that is linear
        row_sum, column_sum = (4000 << 13 >> 4) / 2**17, (10_000 << 13 >> 4) / 2**17
        slope = (-3000 << 11 >> 3 >> 6) / 2**17
        s = 1 / (0.1042 * 20)
        shift = 10 * 2.4 * s * (1000 * z * s - 1200 * s) / (1000 * z * s) + 0.375
        expected = np.stack([u + column_sum + slope * u + 1 + shift, v + row_sum + slope * (v + 1) + 1], axis=1)
        np.testing.assert_allclose(camera.color.project(at), expected, atol=0.05)
    nominal, about = color_camera(depth, TYPICAL, [0] * 29)
    assert "nominal" in about
    assert nominal.T_color_depth[0, 3] == pytest.approx(-0.024)


def test_parts_at_one_hub_belong_together():
    def unit(bus, ports, address, serial):
        return [
            FakeDevice(0x02AE, bus, address, (*ports, 1), serial),
            FakeDevice(0x02B0, bus, address + 1, (*ports, 2), None),
            FakeDevice(0x02AD, bus, address + 2, (*ports, 3), "B" + serial),
        ]

    one, two = unit(1, (2,), 5, "A1"), unit(1, (3,), 9, "A2")
    mouse = FakeDevice(0x0040, 1, 30, (4,), None)
    for parts, own in zip(kinects([two[1], *one, mouse, two[0], two[2]]), (one, two), strict=True):
        assert [parts.camera, parts.motor, parts.audio] == own
    assert find_kinect("A2", [*one, *two]).motor is two[1]
    with pytest.raises(DeviceError, match=r"several Kinects are plugged in.*A1, A2"):
        find_kinect("", [*one, *two])
    with pytest.raises(DeviceError, match=r"no Kinect has this serial number.*A3.*found A1, A2"):
        find_kinect("A3", [*one, *two])
    with pytest.raises(DeviceError, match="no Kinect v1 is plugged in"):
        find_kinect("", [mouse])
    # a system that tells no ports: the only one on the bus, then the only one at all
    for device in one:
        device.port_numbers = None
    assert find_kinect("", one).motor is one[1]
    one[1].bus = 7
    assert find_kinect("", one).motor is one[1]
    assert [parts.motor for parts in kinects([*one, *unit(2, (1,), 3, "A9")[:1]])] == [None, None]


def test_later_kinects_take_the_serial_number_of_their_microphones():
    camera, audio = FakeDevice(0x02AE, serial="0" * 16, bcdDevice=0x0200), FakeDevice(0x02AD, serial="A77")
    parts = find_kinect("A77", [camera, audio])
    assert (parts.serial, parts.name) == ("A77", "Kinect for Xbox 360 (1473)")
    with pytest.raises(DeviceError, match=r"may not be opened by you.*--udev"):
        find_kinect("", [FakeDevice(serial="secret")])
    assert find_kinect(devices=[FakeDevice()]).serial == SERIAL


def test_the_motor_is_tilted_and_lit_within_its_range():
    motor = FakeDevice(0x02B0)
    parts = find_kinect(devices=[FakeDevice(), motor])
    sent = []
    answer = struct.pack(">2xhhhbB", 0, 819, -410, -128, 4)

    def transfer(kind, request, value, index, data, timeout):
        sent.append((kind, request, value))
        return answer

    motor.ctrl_transfer = transfer
    foot = Motor(parts)
    for degrees in (10.5, -90, 45):
        foot.tilt(degrees)
    foot.light("green")
    assert sent == [(0x40, 0x31, 21), (0x40, 0x31, 0x10000 - 62), (0x40, 0x31, 62), (0x40, 0x06, 1)]
    state = foot.state()
    assert state.acceleration == pytest.approx((0, 1, -0.5006), abs=1e-4)
    assert (state.tilt_deg, state.moving) == (None, "moving")
    with pytest.raises(DeviceError, match="motor does not answer"):
        Motor(find_kinect(devices=[FakeDevice(bcdDevice=0x0200)]))


class Audio(FakeDevice):
    """The microphones' device of a 1473 whose firmware runs."""

    def __iter__(self):
        return iter([type("Configuration", (), {"bNumInterfaces": 2})])

    def write(self, endpoint, data, timeout):
        assert endpoint == 0x01
        self.message = struct.unpack_from("<4I", data)
        self.rest = data[16:]
        acknowledged = struct.pack("<3I", 0x0A6FE000, self.message[1], 0)
        state = struct.pack("<4x4x4x4x4i", 0, 819, 0, 7) + bytes(72)
        self.replies = [state, acknowledged] if self.message[3] == 0x8032 else [acknowledged]

    def read(self, endpoint, size, timeout):
        return self.replies.pop(0)


def test_a_later_motor_is_spoken_to_through_its_microphones():
    audio = Audio(0x02AD, serial="A77")
    motor = Motor(find_kinect(devices=[FakeDevice(serial="0" * 16, bcdDevice=0x0200), audio]))
    motor.tilt(-12)
    assert audio.message[0] == 0x06022009
    assert audio.message[2:] == (0, 0x803B)
    assert struct.unpack("<i", audio.rest) == (-12,)
    state = motor.state()
    assert (state.acceleration, state.tilt_deg) == ((0.0, 1.0, 0.0), 7.0)


def test_the_clock_goes_on_over_its_end_and_counts_what_is_missing():
    clock = DeviceClock()
    ticks, shown = 2**32 - 5_000_000, (0, 1, 2, 3, 4, 5, 8, 9)  # the counter begins anew between 2 and 3
    told = [clock.at((ticks + 2_000_000 * frame) % 2**32, 100 + frame / 30) for frame in shown]
    assert np.diff([seconds for seconds, _ in told]) == pytest.approx(np.array([1, 1, 1, 1, 1, 3, 1]) / 30)
    assert [missed for _, missed in told] == [0, 0, 0, 0, 0, 0, 2, 0]
    clock.restart()  # unplugged for two seconds, from its 9th frame on
    seconds, missed = clock.at(77, 100 + 9 / 30 + 2)
    assert seconds - told[-1][0] == pytest.approx(2)
    assert missed == 59
