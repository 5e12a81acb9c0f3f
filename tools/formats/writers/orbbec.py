"""Orbbec's bag, serialised as 3rdparty/rosbag/src/msgs of OrbbecSDK_v2 does, in a bag by rosbags' writer.

There is no way to run its recorder without a camera; field order and identifiers are of its source (MIT).
"""

import struct
from pathlib import Path

import numpy as np
from rosbags import rosbag1

from tools.formats.take import Lens, Take
from tools.formats.writers.phones import jpeg

COLOR, DEPTH = 2, 3  # of sensor, frame and stream types alike
VERSION, UNIT_MM = 0, 176  # properties, of include/libobsensor/h/Property.h
# laser's level, exposure and gain of depth; of one byte: the camera made depth of disparities, and the SDK need not
SETTINGS = {99: 5, 2017: 8500, 2018: 16}
SWITCHES = {85: True, 3004: False}
K6 = 4  # OB_DISTORTION_BROWN_CONRADY_K6
# the definitions that the SDK writes are not those of the bytes; it goes by these sums
WORDS = {
    "Image": "uint32 height|uint32 width|string encoding|uint8 is_bigendian|uint32 step|uint8[] data|uint64 number|"
    "uint64 timestamp_usec|uint64 timestamp_systemusec|uint64 timestamp_globalusec|uint8[] metadata|"
    "uint32 metadatasize",
    "OBDeviceInfo": "string name|string fullName|string asicName|uint16 vid|uint16 pid|string uid|string sn|"
    "string fwVersion|string hwVersion|string supportedSdkVersion|string connectionType|uint16 type|uint8 backendType|"
    "string ipAddress|string localMac",
    "OBProperty": "uint8 propertyId|uint8[] data  |uint32 datasize",
    "OBStreamProfileInfo": "uint8 streamType|uint8 format|float32[9] rotationMatrix|float32[3] translationMatrix|"
    "uint16 width|uint16 height|uint16 fps|float32[4] cameraIntrinsic|float32[8] cameraDistortion|"
    "uint8 distortionModel",
}
IMAGE_SUM, DEVICE_SUM = "060021388200f6f0f447d0fcd9c64743", "afef5328bb4abebd1a309e1ea8b26b3a"
OTHER_SUM = "0123456789abcdef" * 2


def text(words: str) -> bytes:
    """A string as ROS serialises it."""
    return struct.pack("<I", len(words)) + words.encode()


def header(seconds: float) -> bytes:
    """std_msgs/Header."""
    whole = int(seconds)
    return struct.pack("<III", 0, whole, round((seconds - whole) * 1e9)) + text("")


def image(seconds: float, number: int, encoding: str, size: tuple[int, int], step: int, data: bytes) -> bytes:
    """sensor_msgs/Image with the fields that the SDK adds."""
    w, h = size
    us, more = round(seconds * 1e6), b"\0" * 16
    begin = header(seconds) + struct.pack("<II", h, w) + text(encoding) + struct.pack("<BII", 0, step, len(data))
    stamps = struct.pack("<fQQQQ", 0.0, number, us, us + 1_700_000_000_000_000, us)
    return begin + data + stamps + struct.pack("<I", len(more)) + more + struct.pack("<IB", len(more), 16)


def profile(kind: int, lens: Lens, T: np.ndarray) -> bytes:
    """OBStreamProfileInfo: rotation by rows, shift in millimetres."""
    k1, k2, p1, p2, k3, k4, k5, k6 = lens.bend
    form = 28 if kind == DEPTH else 5  # Z16, MJPG
    place = struct.pack("<9f3f", *T[:3, :3].ravel(), *(1000 * T[:3, 3]))
    lengths = struct.pack("<HHH4f", lens.width, lens.height, 30, *lens.four)
    return header(0) + struct.pack("<BB", kind, form) + place + lengths + struct.pack(
        "<8fB", k1, k2, k3, k4, k5, k6, p1, p2, K6
    )  # fmt: skip


def prop(number: int, value: bytes) -> bytes:
    """OBProperty."""
    size = struct.pack("<I", len(value))
    return header(0) + struct.pack("<I", number) + size + value + size


def device() -> bytes:
    """OBDeviceInfo of a camera of the G330 line, which states its unit."""
    names = b"".join(map(text, ("Orbbec Gemini 335", "Orbbec Gemini 335", "")))
    rest = b"".join(map(text, ("uid", "CP1", "1.4.60", "0.1", "2.0", "USB3.2")))
    return header(0) + names + struct.pack("<HH", 0x2BC5, 0x0800) + rest + struct.pack("<HB", 0, 1) + text("") * 2


def bag(take: Take, path: Path) -> Path:
    """Depth and colour as MJPG."""
    assert take.color is not None and take.color_lens is not None
    with rosbag1.Writer(path) as out:
        made: dict[str, object] = {}

        def put(topic: str, kind: str, digest: str, seconds: float, data: bytes) -> None:
            if topic not in made:
                words = "\n".join(["std_msgs/Header header", *WORDS[kind.split("/")[-1]].split("|"), ""])
                made[topic] = out.add_connection(topic, kind, msgdef=words, md5sum=digest)
            out.write(made[topic], round(seconds * 1e9), data)  # type: ignore[arg-type]

        first, last = float(take.stamps[0]), float(take.stamps[-1])
        told = {VERSION: struct.pack("<d", 2.1), UNIT_MM: struct.pack("<f", 1000 * take.unit)}
        told |= {number: struct.pack("<i", value) for number, value in SETTINGS.items()}
        told |= {number: struct.pack("<?", value) for number, value in SWITCHES.items()}
        for number, value in told.items():
            put("/cam/property", "custom_msg/msg/OBProperty", OTHER_SUM, first, prop(number, value))
        for i, counts in enumerate(take.counts()):
            seconds, size = float(take.stamps[i]), (take.lens.width, take.lens.height)
            data = image(seconds, i, "z16", size, 2 * size[0], counts.astype("<u2").tobytes())
            put(f"/cam/sensor_{DEPTH}/frameType_{DEPTH}", "sensor_msgs/msg/Image", IMAGE_SUM, seconds, data)
            size = take.color_lens.width, take.color_lens.height
            data = image(seconds, i, "mjpg", size, 0, jpeg(take.color[i]))
            put(f"/cam/sensor_{COLOR}/frameType_{COLOR}", "sensor_msgs/msg/Image", IMAGE_SUM, seconds, data)
        put("/cam/deviceInfo", "custom_msg/msg/OBDeviceInfo", DEVICE_SUM, last, device())
        for kind, lens, T in ((DEPTH, take.lens, take.T_color_depth), (COLOR, take.color_lens, np.eye(4))):
            put(
                f"/cam/streamProfileType_{kind}",
                "custom_msg/msg/OBStreamProfileInfo",
                OTHER_SUM,
                last,
                profile(kind, lens, T),
            )
    return path
