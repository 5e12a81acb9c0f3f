"""Cameras as programs that calibrate write them: kalibr's chain, ROS's CameraInfo and its calibrator's file, OpenCV's
FileStorage, the settings of ORB-SLAM.

kalibr: github.com/ethz-asl/kalibr/wiki/yaml-formats; ROS: sensor_msgs/CameraInfo, camera_calibration_parsers.
"""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import yaml
from numpy.typing import NDArray

from fusion.errors import RecordingError
from fusion.files.json_file import shown
from fusion.files.reading import read_text
from fusion.geometry.camera import Camera
from fusion.recording.cameras.lens import camera_of_info, made_camera
from fusion.recording.cameras.named_numbers import KNOWN, Size, camera_of_fields, listed, numbers_of, pair_of
from fusion.recording.native.camera_file import LEAST_SCALE, MOST_SCALE

Array = NDArray[np.float64]
Fields = Mapping[str, Any]

OPENCV = ("%YAML:1.0", "!!opencv-", "<opencv_storage")  # what only its files hold
SETTINGS = ("Camera1.", "Camera.")  # ORB-SLAM 3, and before
SCALES = ("RGBD.DepthMapFactor", "DepthMapFactor")  # counts per metre


class _Plain(yaml.SafeLoader):
    """YAML without names for parts: a few lines of them stand for more than any memory holds."""

    def compose_node(self, parent: yaml.Node | None, index: int) -> yaml.Node | None:
        if self.check_event(yaml.AliasEvent):
            raise yaml.YAMLError("a part that is only named (*)")
        return super().compose_node(parent, index)


def camera_of_calibration(path: Path, size: Size | None = None) -> Camera:
    """The camera of a file in YAML, or of OpenCV's in YAML or XML; one with a matrix alone asks for its size.

    Raises:
        RecordingError: it cannot be read, holds no camera or several, or one that cannot be used.
    """
    fields = _read(path)
    chain = {name: part for name, part in fields.items() if isinstance(part, Mapping) and "intrinsics" in part}
    if chain:
        return _of_kalibr(chain, path)
    if any(f"{begin}fx" in fields for begin in SETTINGS):
        return _of_settings(fields, path)
    info = {str(name).lower(): value for name, value in fields.items()}
    if {"k", "width", "height"} <= info.keys():
        return camera_of_info(
            {**info, **{name: numbers_of(info.get(name, ()), path, name) for name in "kdp"}}, str(path)
        )
    return camera_of_fields(fields, path, size)


def _of_kalibr(chain: Fields, path: Path) -> Camera:
    if len(chain) > 1:
        found = ", ".join(f"{name} ({listed(part.get('resolution'))})" for name, part in chain.items())
        do = "keep the part of the camera that made the depth in a file of its own"
        raise RecordingError("the camera file holds several cameras", path, found, "one", do)
    ((name, part),) = chain.items()
    if part.get("camera_model", "pinhole") != "pinhole":
        expected = "pinhole, with radtan or equidistant distortion"
        raise RecordingError("the camera model is not known", f"{path}, {name}", part["camera_model"], expected)
    lengths = _four(numbers_of(part["intrinsics"], path, f"{name}.intrinsics"), path, f"{name}.intrinsics")
    lens = numbers_of(part.get("distortion_coeffs", ()), path, f"{name}.distortion_coeffs")
    width, height = pair_of(part.get("resolution"), path, f"{name}.resolution")
    return made_camera(width, height, lengths, str(part.get("distortion_model", "")), lens, f"{path}, {name}")


def _of_settings(fields: Fields, path: Path) -> Camera:
    begin = next(begin for begin in SETTINGS if f"{begin}fx" in fields)
    values = numbers_of([fields.get(begin + name, np.nan) for name in ("fx", "fy", "cx", "cy")], path, begin + "fx")
    width, height = pair_of([fields.get(f"Camera.{side}") for side in ("width", "height")], path, "Camera.width")
    fish = fields.get("Camera.type") == "KannalaBrandt8"
    model, names = ("equidistant", "k1 k2 k3 k4") if fish else ("plumb_bob", "k1 k2 p1 p2 k3")
    lens = [fields.get(begin + name, 0.0) for name in names.split()]
    camera = made_camera(
        width, height, _four(values, path, begin), model, numbers_of(lens, path, begin + "k1"), str(path)
    )
    scale = next((fields[name] for name in SCALES if name in fields), camera.depth_scale)
    scale = float(numbers_of([scale], path, SCALES[0])[0])
    if not LEAST_SCALE <= scale <= MOST_SCALE:
        raise RecordingError("the depth scale cannot be used", path, f"{scale:g}", "counts per metre")
    return replace(camera, depth_scale=scale)


def _read(path: Path) -> Fields:
    text = read_text(path, RecordingError, "the camera file")
    if any(mark in text for mark in OPENCV):
        return _of_opencv(text, path)
    lines = [line for line in text.split("\n") if not line.startswith("%")]
    first = "\n".join(lines).removeprefix("---\n").split("\n---")[0]  # `rostopic echo` ends each message so
    try:
        content = yaml.load(first, _Plain)
    except (yaml.YAMLError, RecursionError, ValueError) as problem:
        found = " ".join(str(problem).split())[:200]
        raise RecordingError("the camera file is no YAML", path, found, KNOWN) from problem
    if not isinstance(content, dict):
        raise RecordingError("the file holds no camera that is known", path, shown(content), KNOWN)
    return content


def _of_opencv(text: str, path: Path) -> Fields:
    try:
        storage = cv2.FileStorage(text, cv2.FILE_STORAGE_READ | cv2.FILE_STORAGE_MEMORY)
        root = storage.root()
        return {name: _node(root.getNode(name)) for name in root.keys()}  # noqa: SIM118
    except (cv2.error, SystemError) as problem:
        found = " ".join(str(problem.__cause__ or problem).split())[-200:]
        raise RecordingError("the camera file is broken", path, found, KNOWN) from problem


def _node(node: cv2.FileNode) -> Any:
    """A number, a text, a list of numbers, or a matrix."""
    if node.isReal() or node.isInt():
        return node.real()
    if node.isString():
        return node.string()
    if node.isSeq():
        return [_node(node.at(n)) for n in range(node.size())]
    return {} if node.mat() is None else node.mat()


def _four(values: Array, path: Path, name: str) -> tuple[float, float, float, float]:
    if len(values) != 4:
        raise RecordingError(f"{name} of the camera cannot be used", path, f"{len(values)} numbers", "fx, fy, cx, cy")
    return float(values[0]), float(values[1]), float(values[2]), float(values[3])
