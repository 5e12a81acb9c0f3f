"""Cameras as others state them: ROS's CameraInfo, and lens models by the names of ROS, kalibr and RealSense."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from fusion.errors import RecordingError
from fusion.geometry.camera import Camera
from fusion.geometry.lens_forms import fisheye, with_lens
from fusion.geometry.pose import Array
from fusion.recording.native.camera_file import are_focal

# OpenCV's model and order of coefficients, by the names that recorders use. RealSense's "inverse" and "modified" ones
# are projected by its SDK as OpenCV's, but for products of radial and tangential terms (below 0.01 px in its cameras)
FORWARD = (
    "plumb_bob",
    "rational_polynomial",
    "none",
    "radtan",
    "",
    *(
        f"{kind}brown{between}conrady"
        for kind in ("", "inverse ", "inverse_", "modified ", "modified_")
        for between in " _"
    ),
)
# Kannala's and Brandt's: ROS's name, kalibr's, RealSense's
FISHEYE = ("equidistant", "fisheye", "kannala_brandt", "kannala_brandt4", "kannala brandt4")


def camera_of_info(info: Mapping[str, Any], where: str, rectified: bool = False) -> Camera:
    """The camera of a CameraInfo message.

    Args:
        info: its values by name, in small letters.
        where: names it in errors.
        rectified: the images are those that P describes (their lens is taken out), not those of K and D.

    Raises:
        RecordingError: focal lengths that are none, or a lens model that is not known.
    """
    k, p, d = (np.asarray(info.get(name, ()), float) for name in "kpd")
    if rectified and len(p) == 12 and p[0] > 0:
        fx, fy, cx, cy, d = p[0], p[5], p[2], p[6], np.zeros(0)
    else:
        fx, fy, cx, cy = (k[0], k[4], k[2], k[5]) if len(k) == 9 else (0.0,) * 4
    width, height, fx, fy, cx, cy = _window(info, fx, fy, cx, cy)
    return made_camera(width, height, (fx, fy, cx, cy), str(info.get("distortion_model", "")), d, where)


def made_camera(
    width: int, height: int, lengths: tuple[float, float, float, float], model: str, d: Array, where: str
) -> Camera:
    """A camera of fx, fy, cx, cy [px] and a lens by its model's name. Raises RecordingError."""
    fx, fy, cx, cy = (float(value) for value in lengths)
    if not (np.isfinite([fx, fy, cx, cy]).all() and are_focal(fx, fy) and max(abs(cx), abs(cy)) < 1e6):
        found = f"fx {fx:g} fy {fy:g} cx {cx:g} cy {cy:g}"
        raise RecordingError("the camera cannot be used", where, found, "focal lengths in pixels", "pass --camera")
    if not (0 < width < 65536 and 0 < height < 65536) or not np.isfinite(d).all() or (np.abs(d) > 1e6).any():
        raise RecordingError("the camera cannot be used", where, f"{width} x {height}, {d}", do="pass --camera")
    camera = Camera(width, height, fx, fy, cx, cy)
    name = model.strip().lower()
    if not np.any(d) and name not in FISHEYE:
        return camera
    if name in FORWARD and len(d) <= 8:
        return replace(camera, distortion=tuple(float(value) for value in d))
    if name in FISHEYE and not np.any(d[4:]):
        try:
            return with_lens(camera, fisheye([*d[:4].tolist(), 0.0, 0.0, 0.0][:4]))[0]
        except ValueError as problem:
            raise RecordingError("the lens cannot be used", where, problem, do="pass --camera") from problem
    expected = "plumb_bob, rational_polynomial, equidistant, Brown Conrady, Kannala Brandt4"
    raise RecordingError("the lens model is not known", where, f"{model[:40]!r}, {len(d)} numbers", expected)


def _window(info: Mapping[str, Any], fx: float, fy: float, cx: float, cy: float) -> tuple:
    """Size and lengths of the images as they are sent: CameraInfo is of the whole sensor, of which they may be a part.

    A pixel (0, 0) of an image binned by two lies between the first four of the sensor.
    """
    width, height = int(info.get("width", 0)), int(info.get("height", 0))
    roi = info.get("roi", {})
    if roi.get("width") and roi.get("height"):
        width, height = int(roi["width"]), int(roi["height"])
        cx, cy = cx - int(roi["x_offset"]), cy - int(roi["y_offset"])
    bx, by = (max(1, int(info.get(name, 1) or 1)) for name in ("binning_x", "binning_y"))
    return width // bx, height // by, fx / bx, fy / by, (cx + 0.5) / bx - 0.5, (cy + 0.5) / by - 0.5
