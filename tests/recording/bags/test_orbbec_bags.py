"""Orbbec's recordings, written here byte by byte as src/media/ros/RosbagWriter.cpp of OrbbecSDK_v2 serialises them.

Its SDK (pyorbbecsdk2 2.1.2, PlaybackDevice) opens such a file and reads the same device, cameras and extrinsics.
"""

import struct

import box_scene
import cv2
import numpy as np
import pytest
import ros_bags
from rosbags import rosbag1

from fusion.errors import RecordingError
from fusion.recording.open import open_recording

LENS = (0.03, -0.02, 0.01, 0.002, -0.001, 0.004, 0.0005, -0.0007)  # k1..k6, p1, p2
TURN = np.array([[0.8, -0.6, 0], [0.6, 0.8, 0], [0, 0, 1.0]])  # depth to colour, by rows
FINE = (176, struct.pack("<f", 0.2))  # property, and millimetres per count
SHIFT_MM = (14.0, -2.0, 0.5)
# the definitions in the files: not those of the bytes
IMAGE = """std_msgs/Header header
uint32 height
uint32 width
string encoding
uint8 is_bigendian
uint32 step
uint8[] data
uint64 number
uint64 timestamp_usec
uint64 timestamp_systemusec
uint64 timestamp_globalusec
uint8[] metadata
uint32 metadatasize
"""
# by which its SDK knows them
SUMS = {
    "sensor_msgs/msg/Image": "060021388200f6f0f447d0fcd9c64743",
    "custom_msg/msg/OBDeviceInfo": "afef5328bb4abebd1a309e1ea8b26b3a",
}
PROPERTY = "std_msgs/Header header\nuint8 propertyId\nuint8[] data\nuint32 datasize\n"
PROFILE = "std_msgs/Header header\nuint8 streamType\n"
DEVICE = """std_msgs/Header header
string name
string fullName
string asicName
uint16 vid
uint16 pid
string uid
string sn
string fwVersion
string hwVersion
string supportedSdkVersion
string connectionType
uint16 type
uint8 backendType
string ipAddress
string localMac
"""


def text(words):
    return struct.pack("<I", len(words)) + words.encode()


def header(seconds):
    return struct.pack("<III", 0, int(seconds), round(seconds % 1 * 1e9)) + text("")


def image(seconds, encoding, size, step, data):
    head = header(seconds) + struct.pack("<II", size[1], size[0]) + text(encoding) + struct.pack("<BI", 0, step)
    behind = struct.pack("<fQQQQ", 0.0, 7, int(seconds * 1e6), 1, 2) + struct.pack("<I", 3) + b"abc"
    return head + struct.pack("<I", len(data)) + data + behind + struct.pack("<IB", 3, 16)


def profile(kind, size, lengths, lens, model):
    return header(0) + struct.pack(
        "<BB9f3fHHH4f8fB", kind, 28, *TURN.ravel(), *SHIFT_MM, *size, 30, *lengths, *lens, model
    )


def write(path, unit=FINE, encoding="z16", model=4, made_depth=None, properties=()):
    """Frames of the scene at 0.2 mm a count, colour as JPEG."""
    per_count = 0.0002
    with rosbag1.Writer(path) as bag:
        made = {}

        def put(topic, kind, definition, seconds, data):
            if topic not in made:
                made[topic] = bag.add_connection(
                    topic, kind, msgdef=definition, md5sum=SUMS.get(kind, "0123456789abcdef" * 2)
                )
            bag.write(made[topic], round(seconds * 1e9), data)

        more = [] if made_depth is None else [(85, struct.pack("<B", made_depth))]  # of one byte, as the SDK has it
        for number, value in (
            (0, struct.pack("<d", 2.1)),
            *([unit] if unit else []),
            *more,
            *properties,
        ):  # 0: the file's version
            data = header(0) + struct.pack("<II", number, len(value)) + value + struct.pack("<I", len(value))
            put("/cam/property", "custom_msg/msg/OBProperty", PROPERTY, 1.0, data)
        for frame in range(3):
            seconds = 100.5 + frame / 32
            counts = np.rint(ros_bags.true_depth(frame) / per_count).astype("<u2")
            data = image(seconds, encoding, ros_bags.SIZE, 2 * ros_bags.SIZE[0], counts.tobytes())
            put("/cam/sensor_3/frameType_3", "sensor_msgs/msg/Image", IMAGE, seconds, data)
            rgb = np.full((*ros_bags.COLOR_SIZE[::-1], 3), (200, 100, 40 * frame), np.uint8)
            jpeg = cv2.imencode(".jpg", rgb[..., ::-1])[1].tobytes()
            data = image(seconds + 0.001, "mjpg", ros_bags.COLOR_SIZE, 0, jpeg)
            put("/cam/sensor_2/frameType_2", "sensor_msgs/msg/Image", IMAGE, seconds + 0.001, data)
        names = b"".join(map(text, ("Orbbec Femto Bolt", "Orbbec Femto Bolt", "")))
        device = (
            header(0)
            + names
            + struct.pack("<HH", 0x2BC5, 0x066B)
            + b"".join(map(text, ("u", "CL1", "1", "1", "2", "USB3.1")))
        )
        device += struct.pack("<HB", 1, 0) + text("") + text("")
        put("/cam/deviceInfo", "custom_msg/msg/OBDeviceInfo", DEVICE, 200.0, device)
        for kind, size, lengths, lens in (
            (3, ros_bags.SIZE, ros_bags.LENGTHS, (0.0,) * 8),
            (2, ros_bags.COLOR_SIZE, ros_bags.COLOR_LENGTHS, LENS),
        ):
            data = profile(kind, size, lengths, lens, model)
            put(f"/cam/streamProfileType_{kind}", "custom_msg/msg/OBStreamProfileInfo", PROFILE, 200.0, data)
    return path


def test_scene_unit_clock_and_device(tmp_path):
    recording = open_recording(write(tmp_path / "bag"))
    camera = recording.camera
    assert (camera.sensor, camera.serial, camera.principle) == ("Orbbec Femto Bolt", "CL1", "itof")
    assert camera.depth_scale == 5000 and recording.format == "orbbec-bag" and not recording.warnings
    np.testing.assert_allclose(camera.parameters, [*ros_bags.LENGTHS, *[0] * 8])
    np.testing.assert_allclose(recording.timestamps, 100.5 + np.arange(3) / 32, atol=1e-6)
    for index, frame in enumerate(recording):
        # half a count of 0.2 mm
        np.testing.assert_allclose(frame.depth, box_scene.depth(camera.rays().astype(float), index), atol=0.11e-3)


def test_disparities_are_not_taken_for_depth(tmp_path):
    """Recorded frames are those before the SDK's own conversion: of cameras that leave it to the SDK, disparities."""
    with pytest.raises(RecordingError, match=r"holds disparities.*property 85"):
        open_recording(write(tmp_path / "disparities", made_depth=0))
    assert len(open_recording(write(tmp_path / "depth", made_depth=1))) == 3


def test_colour_with_its_lens_and_place(tmp_path):
    recording = open_recording(write(tmp_path / "bag"))
    k1, k2, k3, k4, k5, k6, p1, p2 = LENS
    expected = [*ros_bags.COLOR_LENGTHS, k1, k2, p1, p2, k3, k4, k5, k6]
    np.testing.assert_allclose(recording.camera.color.parameters, expected, rtol=1e-6)
    T = recording.camera.T_color_depth
    np.testing.assert_allclose(T[:3, :3], TURN, atol=1e-7)
    np.testing.assert_allclose(T[:3, 3], np.array(SHIFT_MM) / 1000, atol=1e-9)
    for index in range(3):
        # an even picture in JPEG
        np.testing.assert_allclose(recording.color_apart(index)[9, 9], (200, 100, 40 * index), atol=3)


@pytest.mark.parametrize(("level", "scale"), list(enumerate([1000, 1250, 2500, 10000, 5000, 2000, 20000])))
def test_levels_of_the_unit(tmp_path, level, scale):
    path = write(tmp_path / "bag", (75, struct.pack("<i", level)))
    assert open_recording(path).camera.depth_scale == scale


def test_a_unit_that_is_not_stated_is_told(tmp_path):
    recording = open_recording(write(tmp_path / "bag", unit=None))
    assert recording.camera.depth_scale == 1000 and "does not state the unit" in recording.warnings[0]


def test_disparities_are_refused(tmp_path):
    with pytest.raises(RecordingError, match="holds no depth"):
        open_recording(write(tmp_path / "bag", encoding=""))


def test_a_lens_that_is_not_known_leaves_the_colour_out(tmp_path):
    recording = open_recording(write(tmp_path / "bag", model=5))
    assert recording.camera.color is None and "lens model" in " ".join(recording.warnings)


def test_how_the_camera_was_set_is_shown(tmp_path):
    numbers = [(99, struct.pack("<i", 5)), (2017, struct.pack("<i", 8500)), (2016, b"\0"), (2018, b"\x10")]
    told = open_recording(write(tmp_path / "bag", properties=numbers)).settings
    assert told["name"] == "Orbbec Femto Bolt" and told["depth unit [mm]"] == "0.2"
    assert (told["laser power level"], told["depth exposure"], told["depth auto exposure"]) == ("5", "8500", "0")
    assert "depth gain" not in told  # one byte is no number of four
