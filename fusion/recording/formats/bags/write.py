"""A recording as an MCAP file of ROS 2: topics as a driver of a depth camera sends them."""

import json
from pathlib import Path

import numpy as np

from fusion.errors import RecordingError
from fusion.geometry.camera import Camera
from fusion.geometry.pose import inverse, to_tum
from fusion.recording.formats.bags.containers.mcap_writer import McapWriter
from fusion.recording.formats.bags.messages.values import RosValues
from fusion.recording.formats.bags.ros import CAMERA_TOPIC, DEVICE_TOPIC, SCENE_TOPIC, TELEMETRY_TOPIC
from fusion.recording.native.camera_file import camera_to_dict
from fusion.recording.native.device_file import device_text
from fusion.recording.native.telemetry_file import telemetry_text
from fusion.recording.recording import Frame, Recording
from fusion.recording.writing.losses import Watched
from fusion.recording.writing.write import depth_counts, tell

DEPTH, COLOR, INFRARED = "/camera/depth", "/camera/color", "/camera/ir"
WORLD, DEPTH_FRAME, COLOR_FRAME = "world", "camera_depth_optical_frame", "camera_color_optical_frame"
MILLIMETRES = 1000.0
LATEST_S = 2**31  # a header holds seconds in 31 bits


def write_mcap(path: Path, recording: Recording) -> None:
    """Write a recording as one MCAP file; depth is 16UC1 where it is stored in millimetres, else 32FC1.

    Raises:
        RecordingError: a frame cannot be read, or a time stamp is none that ROS can hold.
    """
    camera, stamps = recording.camera, [_nanoseconds(stamp, recording) for stamp in recording.timestamps]
    first = min(stamps, default=0)
    with path.open("wb") as file, McapWriter(file) as out:
        for topic, text in _own_texts(recording).items():
            out.write(topic, "std_msgs/String", first, RosValues(data=text))
        if recording.color_is_apart and camera.T_color_depth is not None:
            place = to_tum(inverse(np.asarray(camera.T_color_depth)))
            out.write("/tf_static", "tf2_msgs/TFMessage", first, _transform(first, DEPTH_FRAME, COLOR_FRAME, place))
        _write_poses(out, recording)
        watched = Watched(recording, counts=_in_millimetres(recording))
        for frame, stamp in zip(watched, stamps, strict=True):
            _write_frame(out, recording, frame, stamp)
    left_out = ["the mesh of the scene is left out: a bag has no place for it"] if "mesh" in recording.scene else []
    tell(recording.path, (*recording.warnings, *watched.told(), *left_out), None)


def _own_texts(recording: Recording) -> dict[str, str]:
    """What messages of ROS cannot say, as this program's own files say it."""
    texts = {CAMERA_TOPIC: json.dumps(camera_to_dict(recording.camera))}
    if recording.telemetry:
        texts[TELEMETRY_TOPIC] = telemetry_text(recording.telemetry)
    if recording.settings:
        texts[DEVICE_TOPIC] = device_text(recording.settings)
    scene = {name: value for name, value in recording.scene.items() if name != "mesh"}
    if scene:
        texts[SCENE_TOPIC] = json.dumps(scene)
    return texts


def _write_poses(out: McapWriter, recording: Recording) -> None:
    if recording.poses is None:
        return
    for stamp, T in zip(recording.poses.timestamps, recording.poses.poses, strict=True):
        if np.isfinite(T).all():
            at = _nanoseconds(stamp, recording)
            out.write("/tf", "tf2_msgs/TFMessage", at, _transform(at, WORLD, DEPTH_FRAME, to_tum(T)))


def _write_frame(out: McapWriter, recording: Recording, frame: Frame, stamp: int) -> None:
    camera, header = recording.camera, _header(stamp, DEPTH_FRAME)
    out.write(f"{DEPTH}/camera_info", "sensor_msgs/CameraInfo", stamp, _info(camera, header))
    if _in_millimetres(recording):
        image, encoding = depth_counts(frame.depth, MILLIMETRES), "16UC1"
    else:
        image, encoding = frame.depth.astype(np.float32), "32FC1"
    out.write(f"{DEPTH}/image_raw", "sensor_msgs/Image", stamp, _image(image, encoding, header))
    color = frame.color
    if recording.color_is_apart and camera.color is not None:
        color, header = recording.color_apart(frame.index), _header(stamp, COLOR_FRAME)
        if color is not None:
            out.write(f"{COLOR}/camera_info", "sensor_msgs/CameraInfo", stamp, _info(camera.color, header))
    if color is not None:
        out.write(f"{COLOR}/image_raw", "sensor_msgs/Image", stamp, _image(color, "rgb8", header))
    if frame.ir is not None:
        header = _header(stamp, DEPTH_FRAME)
        out.write(f"{INFRARED}/image_raw", "sensor_msgs/Image", stamp, _image(frame.ir, "mono16", header))


def _in_millimetres(recording: Recording) -> bool:
    """True where depth is stored in counts of a millimetre: these come back as they are."""
    if recording.camera.depth_scale != MILLIMETRES:
        return False
    if recording.files is not None:
        return recording.files.to_metres is None
    return recording.streams is not None and recording.streams.counts is not None


def _nanoseconds(stamp: float, recording: Recording) -> int:
    if not 0 <= stamp < LATEST_S:
        expected = f"0 to {LATEST_S} s"
        raise RecordingError("a time stamp cannot be written into a bag", recording.path, f"{stamp:g} s", expected)
    return round(float(stamp) * 1e9)


def _header(stamp: int, frame: str) -> RosValues:
    return RosValues(stamp={"sec": stamp // 10**9, "nanosec": stamp % 10**9}, frame_id=frame)


def _image(pixels: np.ndarray, encoding: str, header: RosValues) -> RosValues:
    rows = np.ascontiguousarray(pixels).view(np.uint8).reshape(pixels.shape[0], -1)
    return RosValues(
        header=header,
        height=pixels.shape[0],
        width=pixels.shape[1],
        encoding=encoding,
        is_bigendian=0,
        step=rows.shape[1],
        data=rows.reshape(-1),
    )


def _info(camera: Camera, header: RosValues) -> RosValues:
    rational = any(camera.distortion[5:])
    K = camera.matrix
    return RosValues(
        header=header,
        height=camera.height,
        width=camera.width,
        distortion_model="rational_polynomial" if rational else "plumb_bob",
        d=camera.distortion if rational else camera.distortion[:5],
        k=K.ravel(),
        r=np.eye(3).ravel(),
        p=np.hstack([K, np.zeros((3, 1))]).ravel(),
        binning_x=0,
        binning_y=0,
        roi={"x_offset": 0, "y_offset": 0, "height": 0, "width": 0, "do_rectify": False},
    )


def _transform(stamp: int, parent: str, child: str, place: np.ndarray) -> RosValues:
    x, y, z, *q = (float(value) for value in place)
    moved = {
        "translation": {"x": x, "y": y, "z": z},
        "rotation": {"x": q[0], "y": q[1], "z": q[2], "w": q[3]},
    }
    return RosValues(transforms=[{"header": _header(stamp, parent), "child_frame_id": child, "transform": moved}])
