"""An Azure Kinect recording of a rendered scene by the maker's own library, without a camera.

    python -m tools.formats.samples.azure LIBRARIES OUT.mkv OUT.json

LIBRARIES: the folder with libk4a.so and libk4arecord.so, as it lies in the unpacked wheel of pyk4a-bundle 1.5 (glibc
2.35 or later). The depth is of tests/recording/bags/box_scene.py along the rays that the library computes, and OUT.json
holds what the library says of some pixels: no formula of the program is in either. The sample of
tests/recording/samples was made so, and packed by gzip.
"""

import ctypes
import json
import sys
from pathlib import Path

import cv2
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[3] / "tests" / "recording" / "bags"))
import box_scene

MJPG, DEPTH16, IR16 = 0, 4, 5  # k4atypes.h
MODES = {"NFOV_2X2BINNED": (1, 320, 288), "NFOV_UNBINNED": (2, 640, 576), "WFOV_2X2BINNED": (3, 512, 512)}
COLORS = {"720P": (1, 1280, 720), "1536P": (4, 2048, 1536)}
FPS_30 = 2
DEPTH, COLOR = 0, 1
FRAMES, STEP_US, FIRST_US, LATE_US = 3, 33_333, 1_500_000, 211
# cx, cy, fx, fy, k1 to k6, codx, cody, p2, p1 over the sensor: sizes as of a real unit, none of its numbers
LENS_DEPTH = [0.508, 0.493, 0.4921, 0.4924, 0.61, 0.08, 0.012, 0.93, 0.19, 0.05, 0, 0, -7e-5, 1.1e-4]
LENS_COLOR = [0.497, 0.506, 0.4765, 0.6357, 0.55, -2.7, 1.6, 0.43, -2.5, 1.5, 0, 0, -2e-4, 3e-4]
ANGLE, SHIFT = 0.1, [-0.032, -0.002, 0.004]  # from the depth to the colour camera: about x, and [m]


class Configuration(ctypes.Structure):
    """k4a_device_configuration_t."""

    _fields_ = [
        ("color_format", ctypes.c_int), ("color_resolution", ctypes.c_int), ("depth_mode", ctypes.c_int),
        ("camera_fps", ctypes.c_int), ("synchronized_images_only", ctypes.c_bool),
        ("depth_delay_off_color_usec", ctypes.c_int32), ("wired_sync_mode", ctypes.c_int),
        ("subordinate_delay_off_master_usec", ctypes.c_uint32), ("disable_streaming_indicator", ctypes.c_bool),
    ]  # fmt: skip


def main() -> None:
    """Write the recording and what the library says of it."""
    libraries, mkv, told = (Path(word) for word in sys.argv[1:4])
    k4a, record = load(libraries)
    mode, color = "NFOV_2X2BINNED", "720P"
    raw = json.dumps(calibration()).encode() + b"\0"
    seen = oracle(k4a, raw, mode, color)
    told.write_text(json.dumps(table(k4a, raw, mode, color)) + "\n", encoding="utf-8")
    handle, configured = ctypes.c_void_p(), Configuration(MJPG, COLORS[color][0], MODES[mode][0], FPS_30)
    good(record.k4a_record_create(str(mkv).encode(), None, configured, ctypes.byref(handle)))
    good(record.k4a_record_add_tag(handle, b"K4A_DEVICE_SERIAL_NUMBER", b"000123"))
    good(record.k4a_record_add_attachment(handle, b"calibration.json", raw, ctypes.c_size_t(len(raw) - 1)))
    good(record.k4a_record_add_tag(handle, b"K4A_CALIBRATION_FILE", b"calibration.json"))
    good(record.k4a_record_write_header(handle))
    for number in range(FRAMES):
        write(k4a, record, handle, images(number, seen, COLORS[color][1:]), FIRST_US + number * STEP_US)
    good(record.k4a_record_flush(handle))
    record.k4a_record_close(handle)


def load(folder: Path) -> tuple[ctypes.CDLL, ctypes.CDLL]:
    """The two libraries; what they call is loaded before them. Their names carry a hash in the wheel."""
    names = ("libudev", "libk4a", "libk4arecord")
    files = [next(folder.rglob(f"{name}-*.so*"), None) or next(folder.rglob(f"{name}.so*")) for name in names]
    _, k4a, record = (ctypes.CDLL(str(file), ctypes.RTLD_GLOBAL) for file in files)
    return k4a, record


def calibration() -> dict:
    """calibration.json of a unit that is made up."""
    c, s = float(np.cos(ANGLE)), float(np.sin(ANGLE))
    still, turned = [1.0, 0, 0, 0, 1, 0, 0, 0, 1], [1.0, 0, 0, 0, c, -s, 0, s, c]
    return {
        "CalibrationInformation": {
            "Cameras": [
                camera("D0", "Depth", LENS_DEPTH, (1024, 1024), still, [0.0, 0, 0]),
                camera("PV0", "PhotoVideo", LENS_COLOR, (4096, 3072), turned, SHIFT),
            ],
            "InertialSensors": [inertial("Gyro"), inertial("Accelerometer")],
            "Metadata": {"SerialId": "000123", "Version": {"Major": 1, "Minor": 2}},
        }
    }


def camera(place: str, purpose: str, lens: list[float], size: tuple[int, int], R: list[float], t: list[float]) -> dict:
    """One camera of calibration.json."""
    return {
        "Intrinsics": {
            "ModelParameterCount": len(lens),
            "ModelParameters": lens,
            "ModelType": "CALIBRATION_LensDistortionModelBrownConrady",
        },
        "Location": f"CALIBRATION_CameraLocation{place}",
        "Purpose": f"CALIBRATION_CameraPurpose{purpose}",
        "MetricRadius": 1.74 if place == "D0" else 1.7,
        "Rt": {"Rotation": R, "Translation": t},
        "SensorWidth": size[0],
        "SensorHeight": size[1],
        "Shutter": "CALIBRATION_ShutterTypeUndefined",
        "ThermalAdjustmentParams": {"Params": [0.0] * 12},
    }


def inertial(kind: str) -> dict:
    """A sensor of motion, without which the library takes no calibration."""
    return {
        "BiasTemperatureModel": [0.0] * 12, "BiasUncertainty": [0.0] * 3, "Id": f"CALIBRATION_InertialSensorId_{kind}",
        "MixingMatrixTemperatureModel": [0.0] * 36, "ModelTypeMask": 16, "Noise": [0.0] * 6,
        "Rt": {"Rotation": [1.0, 0, 0, 0, 1, 0, 0, 0, 1], "Translation": [0.0, 0, 0]}, "SecondOrderScaling": [0.0] * 9,
        "SensorType": f"CALIBRATION_InertialSensorType_{kind}", "TemperatureBounds": [5.0, 60.0], "TemperatureC": 0.0,
    }  # fmt: skip


def read_in(k4a: ctypes.CDLL, raw: bytes, mode: str, color: str) -> ctypes.Array:
    """k4a_calibration_t, as bytes."""
    out = ctypes.create_string_buffer(65536)
    words = ctypes.create_string_buffer(raw)
    good(k4a.k4a_calibration_get_from_raw(words, ctypes.c_size_t(len(raw)), MODES[mode][0], COLORS[color][0], out))
    return out


def unprojected(k4a: ctypes.CDLL, held: ctypes.Array, u: float, v: float, mm: float) -> list[float] | None:
    """[mm] in the depth camera, None where the library has no ray."""
    pixel, point, valid = (ctypes.c_float * 2)(u, v), (ctypes.c_float * 3)(), ctypes.c_int()
    good(k4a.k4a_calibration_2d_to_3d(held, pixel, ctypes.c_float(mm), DEPTH, DEPTH, point, ctypes.byref(valid)))
    return list(point) if valid.value else None


def oracle(k4a: ctypes.CDLL, raw: bytes, mode: str, color: str) -> np.ndarray:
    """(h, w, 2) rays of the depth camera by the library, NaN where there are none."""
    held, (_, width, height) = read_in(k4a, raw, mode, color), MODES[mode]
    rays = np.full((height, width, 2), np.nan)
    for v in range(height):
        for u in range(width):
            point = unprojected(k4a, held, u, v, 1000.0)
            if point is not None:
                rays[v, u] = point[0] / 1000, point[1] / 1000
    return rays


def table(k4a: ctypes.CDLL, raw: bytes, mode: str, color: str) -> dict:
    """Of each mode, pixels with the points [m] that the library puts there at 1 m, and their pixels in colour."""
    out = {}
    for name, (_, width, height) in MODES.items():
        for size in COLORS:
            held, rows = read_in(k4a, raw, name, size), []
            for u, v in [(10, 20), (width // 2, height // 2), (width - 40, 60), (70, height - 30), (width // 3, 100)]:
                point = unprojected(k4a, held, u, v, 1000.0)
                pixel, valid = (ctypes.c_float * 2)(), ctypes.c_int()
                if point is not None:
                    source = (ctypes.c_float * 3)(*point)
                    where = (source, DEPTH, COLOR, pixel, ctypes.byref(valid))
                    good(k4a.k4a_calibration_3d_to_2d(held, *where))
                rows.append({"pixel": [u, v], "point": point and [x / 1000 for x in point],
                             "color": list(pixel) if valid.value else None})  # fmt: skip
            out[f"{name} {size}"] = rows
    return {"calibration": calibration(), "modes": out}


def images(number: int, rays: np.ndarray, size: tuple[int, int]) -> list[tuple[int, str, np.ndarray, int]]:
    """Format, setter, pixels and lateness [us] of one capture's pictures; the second has no colour."""
    z = np.nan_to_num(box_scene.depth(np.nan_to_num(rays), number)) * np.isfinite(rays[..., 0])
    depth = np.rint(1000 * z).astype(np.uint16)
    ir = np.where(depth > 0, 300 + 10 * number + np.arange(depth.shape[1]), 0).astype(np.uint16)
    v, u = np.mgrid[: size[1], : size[0]]
    rgb = np.stack([u * 255 // size[0], v * 255 // size[1], np.full_like(u, 40 * number)], axis=-1).astype(np.uint8)
    jpeg = cv2.imencode(".jpg", rgb[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 60])[1].ravel()
    made = [(DEPTH16, "depth_image", depth, 0), (IR16, "ir_image", ir, 0), (MJPG, "color_image", jpeg, LATE_US)]
    return made[:2] if number == 1 else made


def write(k4a: ctypes.CDLL, record: ctypes.CDLL, handle: ctypes.c_void_p, parts: list, stamp: int) -> None:
    """One capture."""
    capture, held = ctypes.c_void_p(), []
    good(k4a.k4a_capture_create(ctypes.byref(capture)))
    for form, setter, pixels, late in parts:
        image, data = ctypes.c_void_p(), np.ascontiguousarray(pixels)
        h, w = data.shape if data.ndim == 2 else (COLORS["720P"][2], COLORS["720P"][1])
        stride = 2 * w if data.ndim == 2 else 0
        buffer = ctypes.create_string_buffer(data.tobytes(), data.nbytes)
        size = ctypes.c_size_t(data.nbytes)
        good(k4a.k4a_image_create_from_buffer(form, w, h, stride, buffer, size, None, None, ctypes.byref(image)))
        k4a.k4a_image_set_device_timestamp_usec(image, ctypes.c_uint64(stamp + late))
        getattr(k4a, f"k4a_capture_set_{setter}")(capture, image)
        held.append((image, buffer))
    good(record.k4a_record_write_capture(handle, capture))
    good(record.k4a_record_flush(handle))
    for image, _ in held:
        k4a.k4a_image_release(image)
    k4a.k4a_capture_release(capture)


def good(result: int) -> None:
    """K4A_RESULT_SUCCEEDED is 0."""
    if result:
        raise RuntimeError("the library refused; K4A_ENABLE_LOG_TO_STDOUT=1 K4A_LOG_LEVEL=w tells why")


if __name__ == "__main__":
    main()
