"""A take through Microsoft's own recorder (libk4arecord by ctypes); its library also says where each pixel looks.

LIBRARIES: the folder of the unpacked wheel of pyk4a-bundle 1.5. What tools/formats/samples/azure.py set up is used
again.
"""

import ctypes
import json
from pathlib import Path

import numpy as np

from tools.formats.samples import azure as azure_sample
from tools.formats.samples.azure import FPS_30, MJPG, MODES, Configuration, good
from tools.formats.take import Array, Lens, Take
from tools.formats.writers.phones import jpeg

COLOR = "720P"
SCALE_CROP = {"NFOV_2X2BINNED": (512, 96, 90), "NFOV_UNBINNED": (1024, 192, 180), "WFOV_2X2BINNED": (512, 0, 0)}


def stated(mode: str) -> Lens:
    """The depth camera in OpenCV's words, by the formula of ../shared/FORMATS.md that was checked with the library."""
    cx, cy, fx, fy, k1, k2, k3, k4, k5, k6, _, _, p2, p1 = azure_sample.LENS_DEPTH
    size, left, above = SCALE_CROP[mode]
    _, width, height = MODES[mode]
    place = cx * size - left - 0.5, cy * size - above - 0.5
    return Lens(width, height, fx * size, fy * size, *place, (k1, k2, p1, p2, k3, k4, k5, k6))


def color_camera() -> tuple[Lens, Array]:
    """The colour camera in the 16:9 mode, by the same formula, and points of the depth camera in its frame, (4, 4)."""
    cx, cy, fx, fy, k1, k2, k3, k4, k5, k6, _, _, p2, p1 = azure_sample.LENS_COLOR
    _, width, height = azure_sample.COLORS[COLOR]
    place = cx * width - 0.5, cy * width * 3 / 4 - width * 3 / 32 - 0.5
    lens = Lens(width, height, fx * width, fy * width * 3 / 4, *place, (k1, k2, p1, p2, k3, k4, k5, k6))
    T, c, s = np.eye(4), np.cos(azure_sample.ANGLE), np.sin(azure_sample.ANGLE)
    T[:3, :3], T[:3, 3] = [[1, 0, 0], [0, c, -s], [0, s, c]], azure_sample.SHIFT
    return lens, T


def rays(libraries: Path, mode: str) -> Array:
    """(h, w, 2) by the library, NaN where it has none."""
    k4a, _ = azure_sample.load(libraries)
    return azure_sample.oracle(k4a, raw(), mode, COLOR)


def raw() -> bytes:
    """calibration.json as the unit would hold it."""
    return json.dumps(azure_sample.calibration()).encode() + b"\0"


def write(
    take: Take, path: Path, libraries: Path, mode: str, picture: np.ndarray | None = None, infrared: bool = True
) -> Path:
    """The recording; `picture` (n, 720, 1280, 3) is in the colour camera's pixels."""
    k4a, record = azure_sample.load(libraries)
    handle = ctypes.c_void_p()
    settings = Configuration(MJPG, azure_sample.COLORS[COLOR][0], MODES[mode][0], FPS_30)
    good(record.k4a_record_create(str(path).encode(), None, settings, ctypes.byref(handle)))
    good(record.k4a_record_add_tag(handle, b"K4A_DEVICE_SERIAL_NUMBER", b"000123"))
    held = raw()
    good(record.k4a_record_add_attachment(handle, b"calibration.json", held, ctypes.c_size_t(len(held) - 1)))
    good(record.k4a_record_add_tag(handle, b"K4A_CALIBRATION_FILE", b"calibration.json"))
    good(record.k4a_record_write_header(handle))
    counts_of = take.counts(0.001)
    for i in range(len(take.stamps)):
        counts = counts_of[i % len(counts_of)]
        parts = [(azure_sample.DEPTH16, "depth_image", counts, 0)]
        if infrared:
            parts.append((azure_sample.IR16, "ir_image", np.where(counts > 0, 800, 0).astype(np.uint16), 0))
        if picture is not None:
            parts.append((MJPG, "color_image", np.frombuffer(jpeg(picture[i]), np.uint8), azure_sample.LATE_US))
        azure_sample.write(k4a, record, handle, parts, round(take.stamps[i] * 1e6))
    good(record.k4a_record_flush(handle))
    record.k4a_record_close(handle)
    return path
