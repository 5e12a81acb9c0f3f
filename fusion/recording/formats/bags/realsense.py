"""RealSense's own recordings: `.bag` (ROS 1) until 2025, `.db3` (SQLite) since; streams are named the same in both.

In both `Depth_Units` says metres per count, and extrinsics are those from a common reference to the stream.
"""

import re
from dataclasses import replace

import numpy as np

from fusion.errors import RecordingError
from fusion.geometry.camera import Camera, Principle
from fusion.geometry.pose import Array, from_tum, inverse, pose
from fusion.recording.cameras.lens import camera_of_info, made_camera
from fusion.recording.formats.bags.containers.store import Store, Topic
from fusion.recording.formats.bags.messages.values import RosValues, decoded, message
from fusion.recording.formats.bags.pictures import COMPRESSED, IMAGE
from fusion.recording.formats.bags.streams import BagStream, ChosenStreams, stream_stamps

STREAM = re.compile(r"^/device_(\d+)/sensor_(\d+)/(Depth|Color|Infrared)_(\d+)/image/data(?:/compressed\w*)?$")
FINEST, COARSEST = 1e-7, 1e3  # metres per count that a camera file may hold
# by the device's name; the others are pairs of cameras with a projector
PRINCIPLES = {
    "L515": Principle.TIME_OF_FLIGHT,
    "SR300": Principle.STRUCTURED_LIGHT,
    "SR305": Principle.STRUCTURED_LIGHT,
}


def depth_topics(store: Store) -> list[str]:
    """Names of the depth streams of a RealSense recording, none where it is another bag."""
    found = [
        name for name, topic in store.topics.items() if _part(name) == "Depth" and topic.type in (IMAGE, COMPRESSED)
    ]
    return sorted(found)


def choose(store: Store, name: str, camera: Camera | None) -> ChosenStreams:
    """Depth by the name of its stream, with colour and infrared of the same device. Raises RecordingError."""
    warnings = list(store.warnings)
    topic = store.topics[name]
    stated = camera or _camera(store, name)
    if stated is None:
        do = "pass --camera camera.json"
        raise RecordingError("the recording has no camera", store.path, f"no camera_info beside {name}", do=do)
    scale = _depth_scale(store, topic, warnings)
    if scale is None and camera is None:
        do = "pass --camera with depth_scale, counts per metre"
        raise RecordingError("the unit of the depth is not stated", name, "no Depth_Units", "metres a count", do)
    told = _told(store, name)
    if camera is None:
        stated = replace(stated, sensor=told.get("Name", ""), serial=told.get("Serial Number", ""))
        stated = replace(stated, principle=_principle(stated.sensor))
    elif scale not in (None, camera.depth_scale):
        warnings.append(f"the recording's own unit is used: {scale:g} counts a metre, not --camera's")
    stated = replace(stated, depth_scale=scale or stated.depth_scale)
    depth = BagStream(topic, _stamps(store, topic, warnings), stated)
    color, ir = (_beside(store, name, part, warnings) for part in ("Color", "Infrared"))
    places = [_place(store, one.topic.name if one else "") for one in (depth, color)]
    T = None if places[0] is None or places[1] is None else places[1] @ inverse(places[0])
    kind = "realsense-db3" if topic.ros2 else "realsense-bag"
    settings = told | _options(store, name)
    return ChosenStreams(kind, depth, color, ir, T_color_depth=T, warnings=tuple(warnings), settings=settings)


def _part(name: str) -> str:
    found = STREAM.match(name)
    return found[3] if found else ""


def _device_of(name: str) -> str:
    return name.split("/")[1]


def _beside(store: Store, name: str, part: str, warnings: list[str]) -> BagStream | None:
    """The first stream of this kind of the same device, with its camera where the bag has one."""
    names = sorted(n for n in store.topics if _part(n) == part and _device_of(n) == _device_of(name))
    if not names:
        return None
    topic = store.topics[names[0]]
    try:
        camera = _camera(store, names[0])
    except RecordingError as problem:
        warnings.append(f"{part.lower()} is left out: {problem}")
        return None
    return BagStream(topic, _stamps(store, topic, warnings), camera)


def _root(name: str) -> str:
    """`/device_0/sensor_0/Depth_0` of a topic's name."""
    return name.partition("/image/data")[0]


def _camera(store: Store, name: str) -> Camera | None:
    root = _root(name)
    text = store.topics.get(f"{root}/camera_info")
    if text is not None and text.type == "std_msgs/String":
        given = _words(message(text, 0)["data"])
        try:
            values = {key: float(given[key]) for key in ("width", "height", "fx", "fy", "ppx", "ppy")}
            d = np.array([float(word) for word in given.get("coeffs", "").split(",") if word])
        except (KeyError, ValueError) as problem:
            raise RecordingError("the camera cannot be read", text.name, problem, "width, height, fx, ...") from problem
        if not all(0 < values[side] < 65536 for side in ("width", "height")):
            raise RecordingError("the camera cannot be read", text.name, given, "width and height")
        model = given.get("model", "")
        lengths = (values["fx"], values["fy"], values["ppx"], values["ppy"])
        return made_camera(int(values["width"]), int(values["height"]), lengths, model, d, text.name)
    topic = store.topics.get(f"{root}/info/camera_info") or store.topics.get(f"{root}/image/camera_info")
    return None if topic is None else camera_of_info(message(topic, 0), topic.name)


def _depth_scale(store: Store, topic: Topic, warnings: list[str]) -> float | None:
    """Counts a metre: of the images themselves, else of the sensor's option; None where neither tells."""
    units = []
    if not topic.ros2 and topic.type == IMAGE:
        for index in sorted({0, len(topic) - 1}):
            rest = decoded(topic, topic.read(index, -1)).rest
            units += [float(np.frombuffer(rest[:4], "<f4")[0])] if len(rest) >= 4 else []
    option = store.topics.get("/".join(topic.name.split("/")[:3]) + "/option/Depth_Units/value")
    if (
        not units
        and (meta := store.topics.get(f"{_root(topic.name)}/image/metadata"))
        and meta.type == "std_msgs/String"
    ):
        units = [_number(_words(message(meta, i)["data"]).get("depth_units", "")) for i in sorted({0, len(meta) - 1})]
    if not any(unit > 0 for unit in units) and option is not None:
        units = [_number(str(message(option, 0).get("data", "")))]
    units = [unit for unit in units if FINEST <= unit <= COARSEST]
    if not units:
        return None
    if max(units) > min(units) * (1 + 1e-6):
        warnings.append(f"the depth unit changes from {units[0]:g} to {units[-1]:g} m: the first is used for all")
    # stored in single precision, which holds seven digits
    return float(f"{1 / units[0]:.6g}")


def _stamps(store: Store, topic: Topic, warnings: list[str]) -> np.ndarray:
    """[s] by the device's clock. In .db3 headers hold the time of arrival; the device's stands in a text beside."""
    meta = store.topics.get(f"{_root(topic.name)}/image/metadata")
    if topic.ros2 and meta is not None and meta.type == "std_msgs/String" and len(meta) == len(topic):
        texts = [_words(message(meta, index)["data"]).get("timestamp", "") for index in range(len(meta))]
        stamps = np.array([_number(text) for text in texts]) / 1000
        if np.isfinite(stamps).all():
            return stamps
    return stream_stamps(topic, len(topic.read(0, -1)), warnings)


def _place(store: Store, name: str) -> Array | None:
    """(4, 4) from the reference to a stream, or None where the bag does not say it."""
    if not name:
        return None
    root = _root(name)
    found = next((t for n, t in sorted(store.topics.items()) if n.startswith(f"{root}/tf/")), None)
    if found is None:
        return None
    values: RosValues = message(found, 0)
    if "data" in values:
        given = _words(str(values["data"]))
        numbers = [np.array([_number(w) for w in given.get(k, "").split(",")]) for k in ("rotation", "translation")]
        if [len(one) for one in numbers] != [9, 3] or not all(np.isfinite(one).all() for one in numbers):
            return None
        # the SDK stores the columns one after the other
        return _rigid(numbers[0].reshape(3, 3).T, numbers[1])
    turn, shift = values.get("rotation", {}), values.get("translation", {})
    q = np.array([turn.get(axis, 0.0) for axis in "xyzw"], float)
    if not np.isfinite(q).all() or np.linalg.norm(q) < 0.5:
        return None  # never set
    return from_tum([*(shift.get(axis, 0.0) for axis in "xyz"), *q])


def _rigid(R: np.ndarray, t: np.ndarray) -> Array | None:
    """A pose whose rotation was written with few decimals, made a rotation again."""
    u, s, v = np.linalg.svd(R)
    return pose(u @ v, t) if np.abs(s - 1).max() < 1e-3 and np.linalg.det(u @ v) > 0 else None


def _told(store: Store, name: str) -> dict[str, str]:
    """What the recording says of the device: name, serial number, firmware and so on."""
    told: dict[str, str] = {}
    topic = store.topics.get(f"/{_device_of(name)}/info")
    for index in range(min(len(topic), 100)) if topic is not None else ():
        values = message(topic, index)  # type: ignore[arg-type]
        told |= {str(values["key"]): str(values["value"])} if "key" in values else _words(str(values.get("data", "")))
    return told


def _options(store: Store, name: str) -> dict[str, str]:
    """How the depth sensor was set: its options by name, with the last value too where one was changed."""
    root = "/".join(name.split("/")[:3]) + "/option/"
    found = {}
    for option, topic in sorted(store.topics.items()):
        if option.startswith(root) and option.endswith("/value"):
            values = [_option(message(topic, index)) for index in sorted({0, len(topic) - 1})]
            title = option.removeprefix(root).removesuffix("/value").replace("_", " ")
            found[title] = " to ".join(dict.fromkeys(values))
    return found


def _option(values: RosValues) -> str:
    value = _number(str(values.get("data", "")))
    return f"{value:.6g}" if np.isfinite(value) else str(values.get("data", ""))


def _principle(device: str) -> Principle:
    return next(
        (p for model, p in PRINCIPLES.items() if model in device),
        Principle.ACTIVE_STEREO if device else Principle.UNKNOWN,
    )


def _words(text: str) -> dict[str, str]:
    """`a=1;b=2` as names and values."""
    return {key.strip(): value for key, _, value in (part.partition("=") for part in text.split(";")) if key.strip()}


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return float("nan")
