"""Cameras by name, for recordings that come without intrinsics: `presets.toml` beside this file has their numbers."""

import tomllib
from dataclasses import replace
from pathlib import Path

from fusion.errors import RecordingError
from fusion.files.json_file import read_json
from fusion.files.schema import one_of
from fusion.geometry.camera import Camera, Principle
from fusion.recording.cameras.matrix_files import camera_of_others
from fusion.recording.cameras.named_numbers import Size, camera_of_fields, is_of_a_script
from fusion.recording.native.camera_file import camera_content, camera_of

_TABLES = tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8"))


def _read(kind: str) -> dict[str, tuple[Camera, str]]:
    """Name to camera and where its numbers are from."""
    read = {}
    for name, table in _TABLES[kind].items():
        more = {key: value for key, value in table.items() if key not in ("size", "matrix", "source", "modes")}
        more = {"sensor": name} | more | {"principle": Principle(table["principle"])}
        read[name] = (Camera(*table["size"], *table["matrix"], **more), table["source"])
    return read


def _cut(camera: Camera, width: int, height: int, ratio: float) -> Camera:
    """The camera of images cut from the same imager, of `ratio` times its focal length, about the same place."""
    cx = (width - 1) / 2 + ratio * (camera.cx - (camera.width - 1) / 2)
    cy = (height - 1) / 2 + ratio * (camera.cy - (camera.height - 1) / 2)
    return replace(camera, width=width, height=height, fx=camera.fx * ratio, fy=camera.fy * ratio, cx=cx, cy=cy)


DATA_SETS, DEVICES = _read("data_sets"), _read("devices")
PRESETS = DATA_SETS | DEVICES
# of each name the images that it makes but for evenly resized ones, its own first
MODES = {
    name: (camera, *(_cut(camera, *mode) for mode in (_TABLES["devices"].get(name, {})).get("modes", ())))
    for name, (camera, _) in PRESETS.items()
}
LARGEST = 1 << 20  # [B] of a file that is looked into for a camera
CALIBRATIONS = (".yaml", ".yml", ".xml")  # endings of files by programs that calibrate


def say_camera(like: str, folder: Path | None = None, size: Size | None = None) -> str:
    """What to do where a recording states no camera: a file that lies in its folder and holds one (of images of that
    `size`, where it says none), or numbers, or a preset, of which those `like` this name come first."""
    numbers = "fx,fy,cx,cy (pixels; a fifth: counts per metre)"
    others = f"{numbers}, a camera.json or a preset, " + one_of(list(PRESETS), like)
    lying = next((path for path in sorted(folder.iterdir()) if _holds_a_camera(path, size)), None) if folder else None
    return f"pass --camera {others}" if lying is None else f"pass --camera {lying} if depth is its, or {others}"


def _holds_a_camera(path: Path, size: Size | None) -> bool:
    if path.suffix.lower() not in (".json", *CALIBRATIONS) or not path.is_file() or path.stat().st_size > LARGEST:
        return False
    try:
        return bool(find_camera(path, size))
    except RecordingError:
        return False


def find_camera(camera: Camera | Path | str, size: Size | None = None) -> Camera:
    """The camera itself, that of a `camera.json`, of Open3D's `intrinsic.json`, of JSON that scripts write (fx or a
    matrix, ppx or cx), of a YAML file of kalibr, ROS, OpenCV or ORB-SLAM, or of a named preset.

    Args:
        size: asked for width and height [px] of the images where a file of others states neither.

    Raises:
        RecordingError: neither a file nor the name of a preset, or a file that cannot be used.

    >>> fusion.find_camera("my_scan/camera.json").shape
    (120, 160)
    """
    if isinstance(camera, Camera):
        return camera
    if str(camera) in PRESETS:
        return PRESETS[str(camera)][0]
    if not Path(camera).is_file():
        expected = "a camera.json or " + one_of(list(PRESETS), camera)
        raise RecordingError("the camera is not known", "--camera", camera, expected)
    if Path(camera).suffix.lower() in CALIBRATIONS:
        from fusion.recording.cameras.calibration_files import camera_of_calibration  # PyYAML is loaded for these alone

        return camera_of_calibration(Path(camera), size)
    fields = read_json(Path(camera), RecordingError, "the camera file")
    if isinstance(fields, dict) and ("intrinsic_matrix" in fields or {"K", "resolution"} <= fields.keys()):
        return camera_of_others(camera_content(fields, camera))
    if isinstance(fields, dict) and is_of_a_script(fields):
        return camera_of_fields(fields, camera, size)
    if size and isinstance(fields, dict) and "fx" in fields and not {"width", "height"} & fields.keys():
        fields = fields | dict(zip(("width", "height"), size(), strict=True))
    return camera_of(camera_content(fields, camera))
