"""Cameras as people's own scripts write them: numbers or a matrix under any of their usual names.

RealSense's SDK calls the principal point ppx, ppy and its lens coeffs, and states the unit of depth in metres.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.errors import RecordingError
from fusion.files.json_file import shown
from fusion.geometry.camera import Camera
from fusion.recording.cameras.lens import FISHEYE, FORWARD, made_camera
from fusion.recording.native.camera_file import LEAST_SCALE, MOST_SCALE

Array = NDArray[np.float64]
Fields = Mapping[str, Any]
Size = Callable[[], tuple[int, int]]  # width, height

# what the same is called by those who write it
LENGTHS = (("fx", "fl_x"), ("fy", "fl_y"), ("cx", "ppx"), ("cy", "ppy"))
MATRIX = ("camera_matrix", "cameraMatrix", "Camera_Matrix", "intrinsic_matrix", "K", "M1", "mtx", "matrix")
LENS = (
    "distortion_coefficients", "distortionCoefficients", "Distortion_Coefficients", "distCoeffs", "dist_coeffs",
    "dist_coeff", "distortion", "coeffs", "D", "D1", "dist",
)  # fmt: skip
RADIAL = ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6")  # OpenCV's order
WIDTH, HEIGHT = ("image_width", "image_Width", "width", "w"), ("image_height", "image_Height", "height", "h")
SIZE = ("image_size", "imageSize", "resolution", "size")
SCALE = "depth_scale"
COARSEST = 0.1  # metres: no depth image counts in larger steps, so a scale below says metres and not counts per metre
# librealsense's rs2_distortion, by its numbers
MODELS = ("none", "modified brown conrady", "inverse brown conrady", "ftheta", "brown conrady", "kannala brandt4")
KNOWN = "kalibr's camchain, ROS's CameraInfo, OpenCV's camera_matrix, ORB-SLAM's Camera.fx, or fx, fy, cx, cy"


def is_of_a_script(fields: Fields) -> bool:
    """True where a `camera.json` has other names for it, or would pass over what stands beside it."""
    plain = all(names[0] in fields for names in LENGTHS)
    more = {*LENS, *RADIAL, "distortion_model"} - {"distortion"}
    scale = fields.get(SCALE)
    metres = isinstance(scale, float) and 1 / MOST_SCALE <= scale < COARSEST
    if plain:
        return metres or bool(more & fields.keys())
    its_own = any(name in fields for names in LENGTHS for name in names)  # a part is another camera then
    return _is_camera(fields) or (not its_own and any(_is_camera(part) for part in fields.values()))


def camera_of_fields(fields: Fields, where: object, size: Size | None = None) -> Camera:
    """The camera of such fields, or of the one part that holds them.

    Args:
        size: asked for width and height of the images where the fields state neither.

    Raises:
        RecordingError: they hold no camera or several, or one that cannot be used.
    """
    if not _is_camera(fields):
        fields, where = _only_part(fields, where)
    lengths = _lengths(fields, where)
    sides = [named(fields, names) for names in (WIDTH, HEIGHT)]
    stated = named(fields, SIZE) if None in sides else sides
    stated = size() if size is not None and stated is None and sides == [None, None] else stated
    width, height = pair_of(stated, where, "image_width, image_height")
    lens, model = _lens(fields, where)
    return _scaled(made_camera(width, height, lengths, model, lens, str(where)), fields.get(SCALE), where)


def _is_camera(part: object) -> bool:
    if not isinstance(part, Mapping):
        return False
    return named(part, MATRIX) is not None or all(named(part, names) is not None for names in LENGTHS)


def _only_part(fields: Fields, where: object) -> tuple[Fields, str]:
    parts = {name: part for name, part in fields.items() if _is_camera(part)}
    if not parts:
        raise RecordingError("the file holds no camera that is known", where, shown(list(fields)[:6]), KNOWN)
    if len(parts) > 1:
        found = "; ".join(
            f"{name}: {','.join(f'{x:.2f}' for x in _lengths(part, where))}" for name, part in parts.items()
        )
        do = "pass --camera with the four numbers of the camera whose pixels the depth images have (colour's, where "
        raise RecordingError(
            "the camera file holds several cameras", where, found, "one", do + "depth is aligned to it)"
        )
    ((name, part),) = parts.items()
    return part, f"{where}, {name}"


def _lengths(fields: Fields, where: object) -> tuple[float, float, float, float]:
    K = named(fields, MATRIX)
    if K is None:
        fx, fy, cx, cy = (number_of(named(fields, names), where, names[0]) for names in LENGTHS)
        return fx, fy, cx, cy
    K = numbers_of(K, where, "camera_matrix")
    if K.size != 9:
        raise RecordingError("the camera matrix cannot be used", where, f"{K.size} numbers", "9, row by row")
    return float(K[0]), float(K[4]), float(K[2]), float(K[5])


def _lens(fields: Fields, where: object) -> tuple[Array, str]:
    """Coefficients in OpenCV's order, and the name of their model."""
    model = _model(fields)
    listed = named(fields, LENS)
    if listed is not None:
        return numbers_of(listed, where, "distortion_coefficients"), model
    if "k4" in fields and not {"p1", "p2"} & fields.keys():
        return numbers_of([fields.get(f"k{n}", 0.0) for n in (1, 2, 3, 4)], where, "k1"), model or "k1 to k4, no p1, p2"
    return numbers_of([fields.get(name, 0.0) for name in RADIAL], where, "k1"), model


def _model(fields: Fields) -> str:
    """The lens model's name; what "model" says may as well be the name of the device."""
    for key in ("distortion_model", "model", "camera_model"):
        told = fields.get(key)
        name = str(told or "").rsplit(".", 1)[-1].strip().lower()
        if isinstance(told, int):
            name = MODELS[told] if 0 <= told < len(MODELS) else f"number {told}"
        name = "fisheye" if "fisheye" in name else name
        if told is not None and (key == "distortion_model" or isinstance(told, int) or name in (*FORWARD, *FISHEYE)):
            return name
    return ""


def _scaled(camera: Camera, scale: object, where: object) -> Camera:
    if scale is None:
        return camera
    value = number_of(scale, where, SCALE)
    value = 1 / value if 0 < value < COARSEST else value
    if not LEAST_SCALE <= value <= MOST_SCALE:
        expected = "counts per metre, or metres per count"
        raise RecordingError("the depth scale cannot be used", where, shown(scale), expected)
    nearest = round(value)  # 0.0010000000474974513 is a millimetre in 32 bits
    return replace(camera, depth_scale=float(nearest) if abs(value / nearest - 1) < 1e-6 else value)


def named(fields: Fields, names: Sequence[str]) -> Any:
    """What stands under the first of the names that is there, of OpenCV's and ROS's matrices their numbers."""
    found = next((fields[name] for name in names if fields.get(name) is not None), None)
    return found["data"] if isinstance(found, Mapping) and "data" in found else found


def numbers_of(value: Any, where: object, name: str) -> Array:
    """Finite numbers, in one row. Raises RecordingError: something else."""
    try:
        found = np.array(value, float).ravel()  # text as well: YAML takes 1e-05 for one
    except (TypeError, ValueError, OverflowError):
        found = np.full(1, np.nan)
    if not np.isfinite(found).all():
        raise RecordingError(f"{name} of the camera cannot be used", where, listed(value), "numbers")
    return found


def number_of(value: Any, where: object, name: str) -> float:
    """One finite number. Raises RecordingError: something else."""
    found = numbers_of(value, where, name)
    if len(found) != 1:
        raise RecordingError(f"{name} of the camera cannot be used", where, listed(value), "a number")
    return float(found[0])


def pair_of(value: Any, where: object, name: str) -> tuple[int, int]:
    """Width and height. Raises RecordingError: something else."""
    found = "nothing" if value is None or None in list(np.ravel(value)) else listed(value)
    sides = np.zeros(0) if found == "nothing" else numbers_of(value, where, name)
    if len(sides) != 2 or (sides != np.round(sides)).any() or (np.abs(sides) > 65535).any():
        raise RecordingError(
            f"{name} of the camera cannot be used", where, found, "width and height in pixels", "add it to the file"
        )
    return int(sides[0]), int(sides[1])


def listed(value: Any) -> str:
    """Some numbers, for a message."""
    return shown(np.array(value, dtype=object).ravel().tolist()[:9])
