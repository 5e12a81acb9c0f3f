"""Azure Kinect's `calibration.json`: its two cameras in the pixels of a mode.

Lengths and centres are told in parts of the sensor (depth) or of the image's width (colour), the lens as OpenCV's
rational one; how a mode cuts the sensor was seen with the maker's library (`tools/formats/samples/azure.py`).
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from msgspec import Meta, Struct, field

from fusion.errors import RecordingError
from fusion.files.content import Content
from fusion.geometry.camera import Camera
from fusion.geometry.pose import Array, inverse, is_rigid, pose
from fusion.recording.native.camera_file import are_focal

DEPTH, COLOR = "CALIBRATION_CameraLocationD0", "CALIBRATION_CameraLocationPV0"
# (width, height) of the depth images: the sensor's side in their pixels, and where they begin in it
MODES = {
    (320, 288): (512, (96, 90)),
    (640, 576): (1024, (192, 180)),
    (512, 512): (512, (0, 0)),
    (1024, 1024): (1024, (0, 0)),
}
DO = "pass --camera camera.json"
Number = Annotated[float, Meta(gt=-1e6, lt=1e6)]


class AzureIntrinsics(Struct, frozen=True):
    """The lens: cx, cy, fx, fy, k1 to k6, codx, cody, p2, p1."""

    parameters: Annotated[list[Number], Meta(min_length=14, max_length=15)] = field(name="ModelParameters")


class SensorPlace(Struct, frozen=True):
    """From the device's reference to a camera [m]."""

    rotation: Annotated[list[Number], Meta(min_length=9, max_length=9)] = field(name="Rotation")
    translation: Annotated[list[Number], Meta(min_length=3, max_length=3)] = field(name="Translation")


class OneCamera(Struct, frozen=True):
    """A camera of the file."""

    location: str = field(name="Location")
    intrinsics: AzureIntrinsics = field(name="Intrinsics")
    place: SensorPlace = field(name="Rt")
    radius: Annotated[float, Meta(ge=0)] = field(name="MetricRadius", default=0.0)


class AzureCalibration(Struct, frozen=True):
    """What is read of the file."""

    cameras: list[OneCamera] = field(name="Cameras")


class CalibrationFile(Struct, frozen=True):
    """`calibration.json`."""

    information: AzureCalibration = field(name="CalibrationInformation")


USUAL_RADIUS = 1.7  # where the file says 0 or nothing, as the maker's library takes it


@dataclass(frozen=True)
class Calibration:
    """The cameras of a recording."""

    depth: Camera  # of the depth images
    radius: float  # x/z and y/z of a ray beyond which the lens is not known
    color: Camera | None  # of the colour images, or None
    T_color_depth: Array  # (4, 4)


def cameras_of(content: Content, size: tuple[int, int], color_size: tuple[int, int] | None) -> Calibration:
    """The cameras in the pixels of images of these sizes (width, height) [px]. Raises RecordingError."""
    found = {one.location: one for one in content.as_type(CalibrationFile).information.cameras}
    if DEPTH not in found:
        raise RecordingError("the calibration has no depth camera", content.where, sorted(found), DEPTH, DO)
    if size not in MODES:
        known = ", ".join(f"{w} x {h}" for w, h in MODES)
        raise RecordingError("the size of the depth is of no known mode", content.where, f"{size}", known, DO)
    side, begin = MODES[size]
    depth = found[DEPTH]
    camera = _camera(depth, size, (side, side), begin, content)
    radius = depth.radius or USUAL_RADIUS
    if color_size is None or COLOR not in found:
        return Calibration(camera, radius, None, np.eye(4))
    color = found[COLOR]
    T = _place(color, content) @ inverse(_place(depth, content))
    return Calibration(camera, radius, _color(color, color_size, content), T)


def _color(one: OneCamera, size: tuple[int, int], content: Content) -> Camera:
    """Images of 16:9 are cut from those of 4:3, in which lengths are told."""
    width, height = size
    full = width * 3 // 4
    return _camera(one, size, (width, full), (0, (full - height) // 2), content)


def _camera(
    one: OneCamera, size: tuple[int, int], full: tuple[int, int], begin: tuple[int, int], content: Content
) -> Camera:
    """Pixel (0, 0) is the centre of the first, half a pixel from where the sensor begins."""
    cx, cy, fx, fy, k1, k2, k3, k4, k5, k6, codx, cody, p2, p1, *_ = one.intrinsics.parameters
    if not are_focal(fx * full[0], fy * full[1]) or codx or cody:
        found = f"fx {fx:g}, fy {fy:g} of the sensor, centre of distortion {codx:g}, {cody:g}"
        raise RecordingError("the camera's lens cannot be used", content.where, found, "lengths above 0, no centre", DO)
    return Camera(
        width=size[0],
        height=size[1],
        fx=fx * full[0],
        fy=fy * full[1],
        cx=cx * full[0] - begin[0] - 0.5,
        cy=cy * full[1] - begin[1] - 0.5,
        distortion=(k1, k2, p1, p2, k3, k4, k5, k6),
    )


def _place(one: OneCamera, content: Content) -> Array:
    T = pose(np.array(one.place.rotation).reshape(3, 3), np.array(one.place.translation))
    if not is_rigid(T):
        raise RecordingError("a camera's place is no rotation", content.where, one.location, "a rotation matrix", DO)
    return T
