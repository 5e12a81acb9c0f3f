"""The emulator as others see it: real libusb in another process finds the units, asks them and takes their streams."""

import emulated
import pytest

pytest.importorskip("usb.core", reason="needs pyusb: pip install 'fusion-scan[kinect]'")
pytest.importorskip("usb1", reason="needs libusb1: pip install 'fusion-scan[kinect]'")
WHY_NOT = emulated.missing()
pytestmark = [pytest.mark.slow, pytest.mark.skipif(bool(WHY_NOT), reason=WHY_NOT or "never")]

FOUND = """
import usb.core
units = {u.idProduct: u for u in usb.core.find(find_all=True, idVendor=0x045e)}
camera, motor = units[0x02ae], units[0x02b0]
print(sorted(hex(p) for p in units), hex(camera.bcdDevice), camera.serial_number)
print(camera.port_numbers[:-1] == motor.port_numbers[:-1])
print(motor.ctrl_transfer(0xC0, 10, 0, 0, 1)[0], bytes(motor.ctrl_transfer(0xC0, 32, 0, 0, 10)).hex())
"""

STREAM = """
import struct, sys, time, usb1
context = usb1.USBContext()
handle = context.openByVendorIDAndProductID(0x045e, 0x02ae)
handle.claimInterface(0)
frames, current, gone, stop = [], bytearray(), [], False

def took(transfer):
    if transfer.getStatus() != usb1.TRANSFER_COMPLETED:
        gone.append(transfer.getStatus())
        return
    for status, data in transfer.iterISO():
        if not data:
            continue
        if data[3] == 0x71:
            current.clear()
        current.extend(data[12:])
        if data[3] == 0x75:
            frames.append((struct.unpack_from("<I", data, 8)[0], bytes(current)))
    if not stop:
        transfer.submit()

transfers = [handle.getTransfer(iso_packets=16) for _ in range(16)]
for transfer in transfers:
    transfer.setIsochronous(0x82, 16 * 1920, callback=took)
    transfer.submit()

def command(tag, *payload):
    sent = struct.pack("<2sHHH", b"GM", 2, 3, tag) + struct.pack("<HH", *payload)
    handle.controlWrite(0x40, 0, 0, 0, sent)
    while not len(reply := handle.controlRead(0xC0, 0, 0, 0, 512)):
        pass
    assert bytes(reply) == struct.pack("<2sHHHH", b"RB", 1, 3, tag, 0)

command(1, 0x12, 3)
command(2, 0x06, 2)
until = time.monotonic() + 20
while len(frames) < WANTED and not gone and time.monotonic() < until:
    context.handleEventsTimeout(0.1)
stop = True
"""

WHOLE = """
sys.path.insert(0, EMULATOR)
import drawn
roll = drawn.depth_roll()
numbers = [(stamp - 4_200_000_000) % 2**32 // 2_000_000 for stamp, _ in frames]
good = sum(data == roll.frame(number) for number, (_, data) in zip(numbers, frames))
print(good, len(frames), numbers == list(range(numbers[0], numbers[0] + len(frames))))
until = time.monotonic() + 5
while any(t.isSubmitted() for t in transfers) and time.monotonic() < until:
    context.handleEventsTimeout(0.1)
"""

BACK = """
print("gone", len(gone) > 0)
until = time.monotonic() + 5
while any(t.isSubmitted() for t in transfers) and time.monotonic() < until:
    context.handleEventsTimeout(0.1)
handle.close()
import usb.core
until = time.monotonic() + 20
while time.monotonic() < until and not (camera := usb.core.find(idVendor=0x045e, idProduct=0x02ae)):
    time.sleep(0.1)
print("back", camera.address > 5)
"""


def test_units_are_found_with_one_parent_and_the_motor_answers():
    with emulated.kinect("--serial", "A1") as environment:
        lines = emulated.run(FOUND, environment).splitlines()
    assert lines == ["['0x2ad', '0x2ae', '0x2b0', '0x2c2'] 0x10b A1", "True", "34 0000000c0333ffe70000"]


def test_depth_streams_whole_and_in_order():
    program = f"EMULATOR = {str(emulated.EMULATOR.parent)!r}" + STREAM.replace("WANTED", "12") + WHOLE
    with emulated.kinect() as environment:
        good, frames, in_order = emulated.run(program, environment).split()
    assert int(frames) >= 12
    assert (good, in_order) == (frames, "True")


def test_unplugged_it_is_gone_and_comes_back_with_another_address():
    with emulated.kinect("--fault", "unplug") as environment:
        told = emulated.run(STREAM.replace("WANTED", "10000") + BACK, environment)
    assert told.split() == ["gone", "True", "back", "True"]
