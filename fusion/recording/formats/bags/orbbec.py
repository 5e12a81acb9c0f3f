"""Orbbec's own recordings (ROS 1 bags of its SDK 2). Layout as src/media/ros of OrbbecSDK_v2 writes it.

The definitions that these bags hold are not those of their bytes (an image lacks a field, a property's number is called
one byte and has four): what is read here is laid out as it is written.
"""

import re
import struct
from dataclasses import replace

import numpy as np

from fusion.errors import RecordingError
from fusion.geometry.camera import Camera, Principle
from fusion.geometry.pose import Array, is_rigid, pose
from fusion.recording.cameras.lens import made_camera
from fusion.recording.formats.bags.containers.store import Store, Topic, cut
from fusion.recording.formats.bags.messages.values import message
from fusion.recording.formats.bags.pictures import IMAGE, look_at
from fusion.recording.formats.bags.streams import BagStream, ChosenStreams, stream_stamps

FRAMES = re.compile(r"^/cam/sensor_(\d+)/frameType_(\d+)$")
IR, COLOR, DEPTH, IR_LEFT = 1, 2, 3, 6  # OBSensorType, and OBStreamType alike
# OBDepthPrecisionLevel: millimetres per count
LEVELS_MM = (1.0, 0.8, 0.4, 0.1, 0.2, 0.5, 0.05)
LEVEL, UNIT_MM = 75, 176  # numbers of the properties that say the unit: a level, or millimetres
# OB_PROP_DISPARITY_TO_DEPTH_BOOL: the camera made depth of disparities itself. Frames are recorded before the SDK does
# it, under the same encoding (SensorBase::outputFrame, PlaybackDevice.cpp)
MADE_DEPTH = 85
# properties of how the depth was made (include/libobsensor/h/Property.h): name, and how the value is stored
SET: dict[int, tuple[str, str]] = {
    3: ("laser", "?"),
    8: ("temperature compensation", "?"),
    16: ("depth postfilter", "?"),
    17: ("depth hole filter", "?"),
    22: ("least depth [mm]", "<i"),
    23: ("most depth [mm]", "<i"),
    24: ("depth noise removal filter", "?"),
    40: ("noise removal filter: largest difference", "<i"),
    41: ("noise removal filter: largest speckle", "<i"),
    42: ("depth in the colour's pixels", "?"),
    61: ("lens taken out by the camera", "?"),
    75: ("depth precision level", "<i"),
    76: ("time-of-flight filter range", "<i"),
    79: ("laser mode", "<i"),
    85: ("depth from disparities in the camera", "?"),
    98: ("infrared mode", "<i"),
    99: ("laser power level", "<i"),
    119: ("laser power level, as it is", "<i"),
    174: ("laser always on", "?"),
    175: ("laser on and off pattern", "<i"),
    176: ("depth unit [mm]", "<f"),
    182: ("laser control", "<i"),
    191: ("disparity search range mode", "<i"),
    196: ("disparity search offset", "<i"),
    211: ("noise removal in hardware", "?"),
    212: ("noise removal in hardware: threshold", "<f"),
    2000: ("color auto exposure", "?"),
    2001: ("color exposure", "<i"),
    2002: ("color gain", "<i"),
    2016: ("depth auto exposure", "?"),
    2017: ("depth exposure", "<i"),
    2018: ("depth gain", "<i"),
    2025: ("infrared auto exposure", "?"),
    2026: ("infrared exposure", "<i"),
    2027: ("infrared gain", "<i"),
    2029: ("depth without distortion", "?"),
    2037: ("depth of two exposures", "?"),
}
MODELS = ("none", "modified brown conrady", "true inverse", "brown conrady", "rational_polynomial", "fisheye")
PROFILE = struct.Struct("<BB9f3fHHH4f8fB")
PRINCIPLES = {"Femto": Principle.TIME_OF_FLIGHT, "Gemini": Principle.ACTIVE_STEREO, "Astra": Principle.STRUCTURED_LIGHT}


def depth_topics(store: Store) -> list[str]:
    """Names of the depth streams of an Orbbec recording, none where it is another bag."""
    return sorted(name for name in store.topics if _sensor(store, name) == DEPTH)


def choose(store: Store, name: str, camera: Camera | None) -> ChosenStreams:
    """Depth with colour and infrared of the device. Raises RecordingError."""
    topic, warnings = store.topics[name], list(store.warnings)
    look = look_at(topic)
    if look.kind != "depth":
        expected = "z16 or mono16 (the SDK may record disparities and packed depth: record depth)"
        raise RecordingError("the depth stream holds no depth", name, repr(look.encoding), expected)
    properties = _properties(store)
    if properties.get(MADE_DEPTH) and not any(properties[MADE_DEPTH][:4]):
        do = "record with the camera's own conversion (hardware disparity to depth), or save depth images in its viewer"
        raise RecordingError("the depth stream holds disparities", name, f"property {MADE_DEPTH} is 0", "depth", do)
    stated, T = _profile(store, DEPTH)
    millimetres = _unit_mm(properties)
    if millimetres is None:
        warnings.append("the recording does not state the unit of its depth: taken for millimetres, as the SDK does")
    scale = 1000 / (millimetres or 1.0)
    chosen = camera or stated
    if chosen is None:
        do = "pass --camera camera.json"
        raise RecordingError("the recording has no camera", store.path, "no streamProfileType_3", do=do)
    told = _told(store) | _settings(properties)
    if camera is None:
        name = told.get("name", "")
        principle = next((kind for word, kind in PRINCIPLES.items() if word in name), Principle.UNKNOWN)
        chosen = replace(chosen, sensor=name, serial=told.get("sn", ""), principle=principle)
    # given in single precision, which holds seven digits
    chosen = replace(chosen, depth_scale=float(f"{scale:.6g}"))
    depth = BagStream(topic, stream_stamps(topic, len(topic.read(0, -1)), warnings), chosen)
    color = _beside(store, COLOR, warnings)
    ir = _beside(store, IR, warnings) or _beside(store, IR_LEFT, warnings)
    return ChosenStreams("orbbec-bag", depth, color, ir, T_color_depth=T, warnings=tuple(warnings), settings=told)


def _sensor(store: Store, name: str) -> int:
    found = FRAMES.match(name)
    return int(found[1]) if found and store.topics[name].type == IMAGE else 0


def _beside(store: Store, sensor: int, warnings: list[str]) -> BagStream | None:
    names = [name for name in store.topics if _sensor(store, name) == sensor]
    if not names:
        return None
    topic = store.topics[names[0]]
    try:
        if not look_at(topic).kind:
            raise RecordingError("the images are packed in a way that is not read", topic.name)
        camera, _ = _profile(store, sensor)
    except RecordingError as problem:
        warnings.append(f"{topic.name} is left out: {problem}")
        return None
    return BagStream(topic, stream_stamps(topic, len(topic.read(0, -1)), warnings), camera)


def _profile(store: Store, stream: int) -> tuple[Camera | None, Array | None]:
    """The camera of a stream, and for the depth where the colour camera stands (4, 4). Raises RecordingError."""
    topic = store.topics.get(f"/cam/streamProfileType_{stream}")
    if topic is None:
        return None, None
    data = topic.read(0, -1)
    at = 16 + int.from_bytes(data[12:16], "little")  # behind the header and its frame's name
    if at + PROFILE.size > len(data):
        raise cut(store.path, f"{topic.name} of {len(data)} bytes")
    _, _, *values = PROFILE.unpack_from(data, at)
    R, t = np.array(values[:9]).reshape(3, 3), np.array(values[9:12]) / 1000
    width, height, _ = (int(value) for value in values[12:15])
    fx, fy, cx, cy = values[15:19]
    k1, k2, k3, k4, k5, k6, p1, p2 = values[19:27]
    model = MODELS[values[27]] if values[27] < len(MODELS) else f"number {values[27]}"
    lens = np.zeros(0) if model == "none" else np.array([k1, k2, p1, p2, k3, k4, k5, k6])
    T = pose(R, t)
    return made_camera(width, height, (fx, fy, cx, cy), model, lens, topic.name), T if is_rigid(T) else None


def _properties(store: Store) -> dict[int, bytes]:
    """The first eight bytes of each property that the recording holds, by its number."""
    found: dict[int, bytes] = {}
    topic = store.topics.get("/cam/property")
    for index in range(min(len(topic), 10_000)) if topic is not None else ():
        data = topic.read(index, -1)  # type: ignore[union-attr]
        at = 16 + int.from_bytes(data[12:16], "little")
        if at + 12 <= len(data):
            number, length = struct.unpack_from("<II", data, at)
            found[number] = data[at + 8 : at + 8 + min(length, 8)]
    return found


def _unit_mm(found: dict[int, bytes]) -> float | None:
    """Millimetres per count, None where the recording does not tell."""
    if len(found.get(UNIT_MM, b"")) >= 4:
        (value,) = struct.unpack_from("<f", found[UNIT_MM])
        return value if 1e-3 <= value <= 1e3 else None
    if len(found.get(LEVEL, b"")) >= 4:
        (level,) = struct.unpack_from("<i", found[LEVEL])
        return LEVELS_MM[level] if 0 <= level < len(LEVELS_MM) else None
    return None


def _settings(found: dict[int, bytes]) -> dict[str, str]:
    """How the device was set, of the properties that say something about the depth."""
    held = [(name, how, found[number]) for number, (name, how) in SET.items() if number in found]
    values = {name: struct.unpack_from(how, data)[0] for name, how, data in held if len(data) >= struct.calcsize(how)}
    return {name: f"{value:.6g}" if isinstance(value, float) else str(int(value)) for name, value in values.items()}


def _told(store: Store) -> dict[str, str]:
    """What the recording says of the device: name, serial number, firmware and so on, as far as it does."""
    topic: Topic | None = store.topics.get("/cam/deviceInfo")
    values = {} if topic is None else message(topic, 0)
    return {name: str(value) for name, value in values.items() if isinstance(value, str | int) and str(value)}
