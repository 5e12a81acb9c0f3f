"""Cameras by name, for recordings that come without intrinsics."""

from pathlib import Path

from fusion.errors import RecordingError
from fusion.files.json_file import read_json
from fusion.files.schema import one_of
from fusion.geometry.camera import Camera
from fusion.geometry.principle import Principle
from fusion.recording.cameras.open3d_intrinsic import open3d_camera
from fusion.recording.native.camera_file import camera_content, camera_of


def _preset(
    size: tuple[int, int], matrix: tuple[float, float, float, float], scale: float, principle: Principle, sensor: str
) -> Camera:
    width, height = size
    fx, fy, cx, cy = matrix
    return Camera(width, height, fx, fy, cx, cy, depth_scale=scale, principle=principle, sensor=sensor)


_VGA, _WIDE = (640, 480), (848, 480)
_TUM, _STEREO = Principle.STRUCTURED_LIGHT, Principle.ACTIVE_STEREO
_D400_VIEW = "field of view of 87 degrees (+-3: 5 % of the focal length): Intel's datasheet 337029, as others cite it"
_TUM_SOURCE = "TUM RGB-D, file formats page; depth is registered to the colour image"

# name: (camera, where the numbers are from); of the recordings of data sets
DATA_SETS: dict[str, tuple[Camera, str]] = {
    "tum-fr1": (_preset(_VGA, (517.3, 516.5, 318.6, 255.3), 5000, _TUM, "kinect-v1"), _TUM_SOURCE),
    "tum-fr2": (_preset(_VGA, (520.9, 521.0, 325.1, 249.7), 5000, _TUM, "kinect-v1"), _TUM_SOURCE),
    "tum-fr3": (_preset(_VGA, (535.4, 539.2, 320.1, 247.6), 5000, _TUM, "asus-xtion"), _TUM_SOURCE),
    "7scenes": (
        _preset(_VGA, (585.0, 585.0, 320.0, 240.0), 1000, _TUM, "kinect-v1"),
        "Shotton et al., CVPR 2013, page of the RGB-D Dataset 7-Scenes",
    ),
}
# the same of devices: nominal, no unit is exactly like this
DEVICES: dict[str, tuple[Camera, str]] = {
    "kinect-v1": (
        _preset(_VGA, (575.8, 575.8, 319.5, 239.5), 1000, _TUM, "kinect-v1"),
        "libfreenect registration.c: reference plane 120 mm / (2 x pixel of 0.1042 mm)",
    ),
    "primesense": (
        _preset(_VGA, (525.0, 525.0, 319.5, 239.5), 1000, _TUM, "primesense"),
        "OpenNI's and Open3D's default for depth registered to colour",
    ),
    "kinect-v2": (
        _preset((512, 424), (365.456, 365.456, 254.878, 205.395), 1000, Principle.TIME_OF_FLIGHT, "kinect-v2"),
        "factory values of one unit, libfreenect2 tests; its distortion is left out",
    ),
    "asus-xtion": (
        _preset(_VGA, (570.3, 570.3, 319.5, 239.5), 1000, _TUM, "asus-xtion"),
        "OpenNI's default for depth that is not registered to colour",
    ),
    "structure-sensor": (
        _preset(_VGA, (577.3, 577.3, 319.5, 239.5), 1000, _TUM, "structure-sensor"),
        "field of view of 58 degrees: Occipital's data sheet, from memory; one of ScanNet's: 571.6 px (ScannerApp)",
    ),
    "iphone-truedepth": (
        _preset(_VGA, (591.6, 591.6, 319.5, 239.5), 1000, _TUM, "iphone-truedepth"),
        "front camera of 32 mm by the diagonal of 35 mm film: notes (EXIF) of its photos, from memory",
    ),
    "iphone-lidar": (
        _preset((256, 192), (209.2, 209.2, 123.6, 95.9), 1000, Principle.UNKNOWN, "iphone-lidar"),
        "ARKit's numbers of one phone for 1920 x 1440, stackoverflow.com/questions/66893907; phones differ by 7 %",
    ),
    "azure-kinect": (
        _preset((640, 576), (504.6, 504.7, 319.5, 287.5), 1000, Principle.TIME_OF_FLIGHT, "azure-kinect"),
        "narrow unbinned mode: factory values of one unit, github etiennedub/pyk4a; its lens is left out",
    ),
    "femto-bolt": (
        _preset((640, 576), (504.6, 504.7, 319.5, 287.5), 1000, Principle.TIME_OF_FLIGHT, "femto-bolt"),
        "the Azure Kinect's: Orbbec's documents of the Femto Bolt",
    ),
    "realsense-d405": (_preset(_WIDE, (446.8, 446.8, 423.5, 239.5), 10000, _STEREO, "realsense-d405"), _D400_VIEW),
    "realsense-d415": (
        _preset((1280, 720), (1004.5, 1004.5, 639.5, 359.5), 1000, _STEREO, "realsense-d415"),
        _D400_VIEW.replace("87", "65"),
    ),
    "realsense-d435": (
        _preset(_WIDE, (425.8, 425.8, 427.2, 237.7), 1000, _STEREO, "realsense-d435"),
        "factory values of one unit, github DLR-RM/3DObjectTracking",
    ),
    "realsense-d455": (_preset(_WIDE, (446.8, 446.8, 423.5, 239.5), 1000, _STEREO, "realsense-d455"), _D400_VIEW),
    "realsense-l515": (
        _preset((1024, 768), (731.2, 731.2, 511.5, 383.5), 4000, Principle.TIME_OF_FLIGHT, "realsense-l515"),
        "field of view of 70 degrees (+-3): Intel's product page, as others cite it",
    ),
    "oak-d": (
        _preset((1280, 800), (882.5, 882.5, 639.5, 399.5), 1000, _STEREO, "oak-d"),
        "docs.luxonis.com, stereo depth: field of view of 71.9 degrees",
    ),
}
PRESETS = DATA_SETS | DEVICES


def say_camera(like: str) -> str:
    """What to do where a recording states no camera; presets `like` this name come first."""
    numbers = "fx,fy,cx,cy (pixels; a fifth: counts per metre)"
    return f"pass --camera {numbers}, a camera.json or a preset, " + one_of(list(PRESETS), like)


def find_camera(camera: Camera | Path | str) -> Camera:
    """The camera itself, that of a `camera.json` or of Open3D's `intrinsic.json`, or that of a named preset.

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
    fields = read_json(Path(camera), RecordingError, "the camera file")
    if isinstance(fields, dict) and "intrinsic_matrix" in fields:
        return open3d_camera(camera_content(fields, camera))
    return camera_of(camera_content(fields, camera))
