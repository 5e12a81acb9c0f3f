"""`camera.json`: reading and writing a camera."""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np

from fusion.errors import RecordingError
from fusion.geometry.camera import Camera
from fusion.geometry.pose import is_rigid
from fusion.output import atomic_file
from fusion.recording.text_files import read_json

PRINCIPLES = ("structured_light", "itof", "active_stereo", "unknown")
# OpenCV's lengths; longer models (thin prism, tilt) are not those of CONTRACT's camera.json
DISTORTION_LENGTHS = (0, 4, 5, 8)


def read_camera(path: Path | str) -> Camera:
    """The camera of a `camera.json`; keys that are not known are ignored.

    Raises:
        RecordingError: the file cannot be read, or a field is absent, not a number, not finite or out of range.
    """
    return camera_from_dict(read_json(Path(path)), Path(path))


def write_camera(path: Path | str, camera: Camera) -> None:
    """Write a camera as `camera.json`, whole or not at all.

    >>> fusion.write_camera("camera.json", fusion.find_camera("tum-fr1"))
    """
    with atomic_file(Path(path)) as partial:
        partial.write_text(json.dumps(camera_to_dict(camera), indent=1) + "\n", encoding="utf-8")


def camera_from_dict(fields: dict[str, Any], where: object) -> Camera:
    """The camera of `camera.json`'s fields; `where` names them in errors. Raises RecordingError."""
    color = fields.get("color")
    if color is not None and not isinstance(color, dict):
        raise _wrong("color", where, color, "a JSON object with a camera's fields")
    principle = fields.get("principle", "unknown")
    if principle not in PRINCIPLES:
        raise _wrong("principle", where, principle, "one of " + ", ".join(PRINCIPLES))
    return Camera(
        width=_size(fields, "width", where),
        height=_size(fields, "height", where),
        fx=_number(fields, "fx", where, above=0),
        fy=_number(fields, "fy", where, above=0),
        cx=_number(fields, "cx", where),
        cy=_number(fields, "cy", where),
        distortion=_distortion(fields.get("distortion"), where),
        # the colour camera's block may leave it out
        depth_scale=_number({"depth_scale": 1000.0} | fields, "depth_scale", where, above=0),
        principle=str(principle),
        sensor=str(fields.get("sensor") or ""),
        serial=str(fields.get("serial") or ""),
        std=_std(fields.get("std"), where),
        color=None if color is None else camera_from_dict(color, f"{where} (color)"),
        T_color_depth=None if color is None else _rigid(color.get("T_color_depth"), where),
    )


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


def _wrong(name: str, where: object, found: object, expected: str) -> RecordingError:
    do = "correct the file or pass another with --camera"
    return RecordingError(f'"{name}" of the camera cannot be used', where, repr(found)[:80], expected, do)


def _is_number(value: object) -> bool:
    # a huge integer is a number in JSON but not a float
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    return abs(value) < 1e300 and math.isfinite(value)


def _number(fields: dict[str, Any], name: str, where: object, above: float | None = None) -> float:
    value = fields.get(name, "nothing")
    if not _is_number(value) or (above is not None and value <= above):
        raise _wrong(name, where, value, "a finite number" + (f" above {above:g}" if above is not None else ""))
    return float(value)


def _size(fields: dict[str, Any], name: str, where: object) -> int:
    value = _number(fields, name, where, above=0)
    # 65 535: the largest side of the image formats that a recording may hold
    if value != int(value) or value > 65535:
        raise _wrong(name, where, value, "a whole number of pixels up to 65535")
    return int(value)


def _distortion(values: object, where: object) -> tuple[float, ...]:
    values = [] if values is None else values
    if not isinstance(values, list) or not all(map(_is_number, values)) or len(values) not in DISTORTION_LENGTHS:
        raise _wrong("distortion", where, values, "OpenCV's 4, 5 or 8 finite numbers [k1, k2, p1, p2, k3, k4, k5, k6]")
    return tuple(float(value) for value in values)


def _std(values: object, where: object) -> dict[str, float]:
    values = {} if values is None else values
    if not isinstance(values, dict):
        raise _wrong("std", where, values, "a JSON object of field and standard deviation")
    for name, value in values.items():
        if not _is_number(value) or value < 0:
            raise _wrong(f"std.{name}", where, value, "a finite number, 0 or above")
    return {name: float(value) for name, value in values.items()}


def _rigid(values: object, where: object) -> np.ndarray | None:
    if values is None:
        return None
    try:
        T = np.array(values, float)
    except (TypeError, ValueError, OverflowError):
        T = np.zeros(0)
    if not is_rigid(T):
        raise _wrong("T_color_depth", where, values, "a rigid 4x4 matrix, metres")
    return T
