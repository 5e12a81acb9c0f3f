"""`camera.json`: what it may hold, reading and writing a camera."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from msgspec import Meta, Struct
from numpy.typing import NDArray

from fusion.errors import RecordingError
from fusion.files.content import Content, Name, Rigid
from fusion.files.json_file import read_json
from fusion.files.output.publish import atomic_file
from fusion.geometry.camera import Camera, Principle
from fusion.geometry.pose import is_rigid

# OpenCV's lengths; longer models (thin prism, tilt) have no place in camera.json
DISTORTION_LENGTHS = (0, 4, 5, 8)
DO = "correct the file or pass another with --camera"

# 65 535: the largest side of the image formats that a recording may hold
Size = Annotated[float, Meta(ge=1, le=65535, multiple_of=1, description="pixels")]
# a hundredth of a pixel, a million: no lens and no image comes near, and all that is computed of it stays finite
SHORTEST, LONGEST = 1e-2, 1e6
Focal = Annotated[float, Meta(ge=SHORTEST, le=LONGEST, description="focal length [px]")]
Centre = Annotated[float, Meta(gt=-1e6, lt=1e6, description="where the axis meets the image [px]")]
# written by Kinects 1000, TUM 5000, RealSense 1000 to 10000, BOP up to 10000; a count of a kilometre or of
# a ten thousandth of a millimetre is no depth image
LEAST_SCALE, MOST_SCALE = 1e-3, 1e7
DepthScale = Annotated[
    float, Meta(ge=LEAST_SCALE, le=MOST_SCALE, description="counts per metre; 1000: a count is a millimetre")
]
Std = Annotated[float, Meta(ge=0, lt=1e6, description="standard deviation, in the field's unit")]
Distortion = Annotated[
    list[Annotated[float, Meta(gt=-1e6, lt=1e6)]],
    Meta(
        max_length=8,
        description="OpenCV's 4, 5 or 8 finite numbers [k1, k2, p1, p2, k3, k4, k5, k6]",
        # said to others here; looked at in `camera_of`
        extra_json_schema={"not": {"anyOf": [{"minItems": 1, "maxItems": 3}, {"minItems": 6, "maxItems": 7}]}},
    ),
]


def are_focal(*lengths: float) -> bool:
    """True where these can be focal lengths [px]."""
    return all(SHORTEST <= length <= LONGEST for length in lengths)


def camera_of_matrix(K: NDArray[np.float64], size: tuple[int, int], depth_scale: float) -> Camera | None:
    """The camera of a matrix (3, 3) [px] and (width, height); None where it is not one: fx 0 cx, 0 fy cy, 0 0 1."""
    if K.shape != (3, 3) or not are_focal(K[0, 0], K[1, 1]) or K[2].tolist() != [0.0, 0.0, 1.0]:
        return None
    return Camera(*size, K[0, 0], K[1, 1], K[0, 2], K[1, 2], depth_scale=depth_scale)


class Pinhole(Struct, frozen=True, kw_only=True):
    """The fields that a depth and a colour camera share."""

    width: Size
    height: Size
    fx: Focal
    fy: Focal
    cx: Centre
    cy: Centre
    distortion: Distortion | None = None
    depth_scale: DepthScale = 1000.0  # the colour camera's block may leave it out
    principle: Principle = Principle.UNKNOWN
    sensor: Name = None
    serial: Name = None
    std: dict[str, Std] | None = None


class ColorCamera(Pinhole, frozen=True, kw_only=True):
    """The camera beside the depth camera."""

    T_color_depth: Rigid | None = None


class CameraFile(Pinhole, frozen=True, kw_only=True):
    """A camera: `camera.json`."""

    color: ColorCamera | None = None


def read_camera(path: Path | str) -> Camera:
    """The camera of a `camera.json`; keys that are not known are ignored.

    Raises:
        RecordingError: the file cannot be read, or a field is absent, not a number, not finite or out of range.
    """
    return camera_of(camera_content(read_json(path, RecordingError, "the camera file"), path))


def write_camera(path: Path | str, camera: Camera) -> None:
    """Write a camera as `camera.json`, whole or not at all.

    >>> fusion.write_camera("camera.json", fusion.find_camera("tum-fr1"))
    """
    with atomic_file(Path(path)) as partial:
        partial.write_text(json.dumps(camera_to_dict(camera), indent=1) + "\n", encoding="utf-8")


def camera_content(fields: object, where: object) -> Content:
    """The content of a `camera.json`; `where` names it in errors."""
    return Content(fields, where, "the camera", RecordingError, DO)


def camera_of(content: Content) -> Camera:
    """The camera of a file's content, or of a part of it. Raises the content's kind of error."""
    given = content.as_type(CameraFile)
    if len(given.distortion or ()) not in DISTORTION_LENGTHS:
        raise content.wrong(CameraFile, "distortion")
    if given.color is None:
        return _camera(given)
    T = given.color.T_color_depth
    if len(given.color.distortion or ()) not in DISTORTION_LENGTHS:
        raise content.wrong(CameraFile, "color", "distortion")
    if T is not None and not is_rigid(np.array(T)):
        raise content.wrong(CameraFile, "color", "T_color_depth")
    return replace(_camera(given), color=_camera(given.color), T_color_depth=None if T is None else np.array(T))


def camera_to_dict(camera: Camera) -> dict[str, Any]:
    """`camera.json`'s fields of a camera."""
    k = list(camera.distortion)
    fields: dict[str, Any] = {
        "width": camera.width,
        "height": camera.height,
        "fx": camera.fx,
        "fy": camera.fy,
        "cx": camera.cx,
        "cy": camera.cy,
        "distortion": k if any(k[5:]) else k[:5],
        "depth_scale": camera.depth_scale,
        "principle": camera.principle,
        "sensor": camera.sensor,
    }
    fields |= {"serial": camera.serial} if camera.serial else {}
    fields |= {"std": dict(camera.std)} if camera.std else {}
    if camera.color is not None:
        T = np.eye(4) if camera.T_color_depth is None else camera.T_color_depth
        fields["color"] = camera_to_dict(camera.color) | {"T_color_depth": np.asarray(T).tolist()}
    return fields


def _camera(given: Pinhole) -> Camera:
    return Camera(
        width=int(given.width),
        height=int(given.height),
        fx=given.fx,
        fy=given.fy,
        cx=given.cx,
        cy=given.cy,
        distortion=tuple(given.distortion or ()),
        depth_scale=given.depth_scale,
        principle=given.principle,
        sensor=str(given.sensor or ""),
        serial=str(given.serial or ""),
        std=dict(given.std or {}),
    )
