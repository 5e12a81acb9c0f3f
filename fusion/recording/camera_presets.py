"""Cameras by name, for recordings that come without intrinsics. Nominal: no unit is exactly like this."""

from pathlib import Path

from fusion.errors import RecordingError
from fusion.geometry.camera import Camera
from fusion.recording.camera_file import read_camera


def _preset(
    size: tuple[int, int], matrix: tuple[float, float, float, float], scale: float, principle: str, sensor: str
) -> Camera:
    width, height = size
    fx, fy, cx, cy = matrix
    return Camera(width, height, fx, fy, cx, cy, depth_scale=scale, principle=principle, sensor=sensor)


_VGA = (640, 480)
_TUM = "structured_light"
_TUM_SOURCE = "TUM RGB-D, file formats page; depth is registered to the colour image"

# name: (camera, where the numbers are from)
PRESETS: dict[str, tuple[Camera, str]] = {
    "tum-fr1": (_preset(_VGA, (517.3, 516.5, 318.6, 255.3), 5000, _TUM, "kinect-v1"), _TUM_SOURCE),
    "tum-fr2": (_preset(_VGA, (520.9, 521.0, 325.1, 249.7), 5000, _TUM, "kinect-v1"), _TUM_SOURCE),
    "tum-fr3": (_preset(_VGA, (535.4, 539.2, 320.1, 247.6), 5000, _TUM, "asus-xtion"), _TUM_SOURCE),
    "7scenes": (
        _preset(_VGA, (585.0, 585.0, 320.0, 240.0), 1000, _TUM, "kinect-v1"),
        "Shotton et al., CVPR 2013, page of the RGB-D Dataset 7-Scenes",
    ),
    "kinect-v1": (
        _preset(_VGA, (575.8, 575.8, 319.5, 239.5), 1000, _TUM, "kinect-v1"),
        "libfreenect registration.c: reference plane 120 mm / (2 x pixel of 0.1042 mm)",
    ),
    "primesense": (
        _preset(_VGA, (525.0, 525.0, 319.5, 239.5), 1000, _TUM, "primesense"),
        "OpenNI's and Open3D's default for depth registered to colour",
    ),
    "kinect-v2": (
        _preset((512, 424), (365.456, 365.456, 254.878, 205.395), 1000, "itof", "kinect-v2"),
        "factory values of one unit, libfreenect2 tests; its distortion is left out",
    ),
}


def find_camera(camera: Camera | Path | str) -> Camera:
    """The camera itself, that of a `camera.json`, or that of a named preset.

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
        expected = "a camera.json or one of " + ", ".join(PRESETS)
        raise RecordingError("the camera is not known", "--camera", camera, expected)
    return read_camera(Path(camera))
