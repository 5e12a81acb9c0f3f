"""Writes Matroska files as RFC 9559 describes them, with Azure Kinect's tracks; shares nothing with the reader."""

import json
import struct


def size(n):
    """A length as an EBML number of eight bytes; None: not known when it was written."""
    return b"\x01" + (b"\xff" * 7 if n is None else n.to_bytes(7, "big"))


def element(kind, data, unknown=False):
    """An element: identifier in hexadecimal, length, data."""
    return bytes.fromhex(kind) + size(None if unknown else len(data)) + data


def whole(n):
    return n.to_bytes(8, "big")


def track(number, name, codec, width, height):
    head = struct.pack("<IiiHH4sIiiII", 40, width, height, 1, 16, codec.encode(), 0, 0, 0, 0, 0)
    video = element("E0", element("B0", whole(width)) + element("BA", whole(height)))
    told = element("D7", whole(number)) + element("86", b"V_MS/VFW/FOURCC") + element("63A2", head)
    return element("AE", told + element("536E", name.encode()) + video)


def heads(tracks, calibration=None, tags=(), scale=1000):
    """All that stands before the images; `tracks`: of (number, name, codec, width, height)."""
    out = element("1549A966", element("2AD7B1", whole(scale)))
    out += element("1654AE6B", b"".join(track(*one) for one in tracks))
    if calibration is not None:
        text = json.dumps(calibration).encode()
        held = element("466E", b"calibration.json") + element("465C", text)
        out += element("1941A469", element("61A7", held))
    named = [element("67C8", element("45A3", k.encode()) + element("4487", v.encode())) for k, v in tags]
    return out + element("1254C367", element("7373", b"".join(named)))


def cluster(stamp, blocks, unknown=False):
    """Images of (track, ticks after the stamp, data) at a time [ticks]."""
    made = [element("A3", bytes([0x80 | number]) + struct.pack(">hB", late, 0) + data) for number, late, data in blocks]
    return element("1F43B675", element("E7", whole(stamp)) + b"".join(made), unknown)


def matroska(head, clusters, unknown=False):
    """A whole file."""
    begin = element("1A45DFA3", element("4282", b"matroska"))
    return begin + element("18538067", head + b"".join(clusters), unknown)
