"""What every USB device has: descriptors, strings, and how its node and its entry in sysfs are written for umockdev."""

import struct
from dataclasses import dataclass

EPIPE = 32


@dataclass(frozen=True)
class Endpoint:
    address: int
    kind: int  # 1 isochronous, 2 bulk
    packet_bytes: int  # as in the descriptor: two transactions of 960 bytes are 0x0bc0
    interval: int = 1


@dataclass(frozen=True)
class Identity:
    """One device as its descriptors tell it."""

    product_id: int
    release: int
    product: str
    serial: str  # "" for none
    endpoints: tuple[Endpoint, ...]
    milliamperes: int

    def descriptors(self) -> bytes:
        return self.device() + self.configuration()

    def device(self) -> bytes:
        serial = 3 if self.serial else 0
        numbers = (18, 1, 0x200, 0, 0, 0, 64, 0x045E, self.product_id, self.release, 2, 1, serial, 1)
        return struct.pack("<BBHBBBBHHHBBBB", *numbers)

    def configuration(self) -> bytes:
        ends = b"".join(
            struct.pack("<BBBBHB", 7, 5, e.address, e.kind, e.packet_bytes, e.interval) for e in self.endpoints
        )
        interface = struct.pack("<9B", 9, 4, 0, 0, len(self.endpoints), 0xFF, 0xFF, 0xFF, 0)
        total = 9 + len(interface) + len(ends)
        return struct.pack("<BBHBBBBB", 9, 2, total, 1, 1, 0, 0xC0, self.milliamperes // 2) + interface + ends

    def string(self, index: int) -> bytes | int:
        texts = {1: self.product, 2: "Microsoft", 3: self.serial}
        if index == 0:
            return struct.pack("<BBH", 4, 3, 0x0409)
        if not texts.get(index):
            return -EPIPE
        data = texts[index].encode("utf-16-le")
        return bytes([len(data) + 2, 3]) + data

    def standard(self, kind: int, request: int, value: int) -> bytes | int:
        """Answer to a standard request to the device; a negative errno where it stalls."""
        if kind == 0x80 and request == 6:  # GET_DESCRIPTOR
            which = value >> 8
            if which == 1:
                return self.device()
            return self.configuration() if which == 2 else self.string(value & 0xFF) if which == 3 else -EPIPE
        if kind == 0x80 and request == 0:
            return b"\x01\x00"
        if kind == 0x80 and request == 8:
            return b"\x01"
        return b"" if kind < 0x80 else -EPIPE


def entry(name: str, bus: int, address: int, identity: Identity) -> str:
    """One device as `Testbed.add_from_string` takes it; `name` is its place in the tree, `1-1.1`."""
    return f"""P: {sys_path(name)}
N: bus/usb/{bus:03d}/{address:03d}
E: SUBSYSTEM=usb
E: DEVTYPE=usb_device
E: DEVNAME=/dev/bus/usb/{bus:03d}/{address:03d}
E: BUSNUM={bus:03d}
E: DEVNUM={address:03d}
E: MAJOR=189
E: MINOR={(bus - 1) * 128 + address - 1}
E: PRODUCT=45e/{identity.product_id:x}/{identity.release:x}
A: busnum={bus}
A: devnum={address}
A: speed=480
A: bConfigurationValue=1
A: bNumConfigurations=1
A: idVendor=045e
A: idProduct={identity.product_id:04x}
A: serial={identity.serial}
H: descriptors={identity.descriptors().hex().upper()}

"""


def sys_path(name: str) -> str:
    root = "/devices/pci0000:00/0000:00:1d.7/usb1"
    return f"{root}/1-1" if name == "1-1" else f"{root}/1-1/{name}"
