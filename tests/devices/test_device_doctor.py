"""What the doctor says of what is plugged in, of what is installed, and of a source that it tries."""

import json
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parent))
sys.path.insert(0, str(Path(__file__).resolve().parent / "kinect_v1"))
from fake_usb import FakeDevice
from made_up_kinect import MadeUp

from fusion.commands.main import main
from fusion.devices import doctor
from fusion.devices import open as opening
from fusion.devices.doctor import RULES, look, looked_at
from fusion.errors import DeviceError


def device(vendor, product, speed=3):
    made = FakeDevice(product, idVendor=vendor)
    made.speed = speed
    return made


def test_cameras_are_named_and_what_is_wrong_with_them():
    mouse, radio = device(0x046D, 0xC077, 1), device(0x8086, 0x0032)
    found = look([mouse, radio, device(0x045E, 0x02AE), device(0x045E, 0x02B0), device(0x8086, 0x0B3A, 4)])
    assert found.devices == 5
    assert [one.name for one in found.plugged] == ["Kinect for Xbox 360: camera", "Kinect v1: motor", "Intel RealSense"]
    assert not any(one.wrong for one in found.plugged)
    (slow,) = look([device(0x045E, 0x02AE, 2)]).plugged
    assert "12 Mbit/s" in slow.wrong[0]
    assert "USB 2" in slow.wrong[0]
    (slow,) = look([device(0x045E, 0x02C4, 3)]).plugged
    assert "USB 3" in slow.wrong[0]
    (alone,) = look([device(0x045E, 0x02B0)]).plugged
    assert "power supply" in alone.wrong[0]


def test_what_may_not_be_opened_is_told(monkeypatch, tmp_path):
    node = tmp_path / "005"
    node.write_text("")
    monkeypatch.setattr(doctor, "Path", lambda name: node if "bus/usb" in str(name) else Path(name))
    for allowed in (True, False):
        monkeypatch.setattr(doctor.os, "access", lambda path, how, allowed=allowed: allowed)
        (one,) = look([device(0x045E, 0x02AE)]).plugged
        assert one.may_open is allowed
        assert any("--udev" in text for text in one.wrong) is not allowed


def test_without_usb_the_rest_is_told(monkeypatch, capsys):
    def none():
        raise DeviceError("a Kinect needs the Python package usb", found="it is not installed")

    monkeypatch.setattr(doctor, "all_devices", none)
    assert main(["doctor"]) == 0
    told = capsys.readouterr().out
    assert "USB: a Kinect needs the Python package usb" in told
    assert "python 3." in told


def test_extras_are_those_of_the_package():
    extras = doctor.installed_extras()
    if not extras:
        pytest.skip("the package is not installed here")
    assert set(extras["kinect"][0]) == {"pyusb", "libusb1"}
    assert extras["bags"][1] == all(extras["bags"][0].values())


def test_a_source_is_tried(monkeypatch, capsys):
    source = MadeUp(1000, 0.005, missing={3: 2})
    with source:
        tested = looked_at(source, 0.3)
    assert tested.frames > 5
    assert tested.missed == 2
    assert tested.seconds >= 0.3
    assert 0 < tested.rate < 200
    monkeypatch.setattr(opening, "open_source", lambda name: MadeUp(20, 0.001, missing={3: 2}))
    assert main(["doctor", "--try", "made-up", "--json", "--quiet"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["tried"]["frames"] == 20
    assert told["tried"]["missed"] == 2
    assert main(["doctor", "--try", "made-up", "--quiet"]) == 0
    assert "20 frames in" in capsys.readouterr().out
    monkeypatch.setattr(opening, "open_source", lambda name: MadeUp(0))
    assert main(["doctor", "--try", "made-up", "--quiet"]) == 1


def test_the_rules_name_every_part_of_a_kinect(capsys):
    assert main(["doctor", "--udev"]) == 0
    told = capsys.readouterr().out
    assert told == RULES.read_text()
    for vendor, product in doctor.KNOWN:
        if product is None or product in (*doctor.CAMERAS, doctor.MOTOR, *doctor.AUDIO):
            assert f'ATTR{{idVendor}}=="{vendor:04x}"' in told
            assert product is None or f'ATTR{{idProduct}}=="{product:04x}"' in told
