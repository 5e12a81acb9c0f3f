"""What a Kinect v2 tells of its own calibration, and what follows from it for each pixel.

Rows are those of the sub-images, y; the finished images are turned over (see `decode`). Which of the two the camera's
cy counts in only hardware can tell: rows of the sub-images are taken, as the notes on the protocol have it.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.errors import DeviceError

WIDTH, HEIGHT = 512, 424
CAMERA_BYTES, PHASE_HEADER = 92, 32
PHASE_BYTES = PHASE_HEADER + 3 * (2 * WIDTH * HEIGHT + 4)
PER_CYCLE = 6250 / 3  # [mm] of range for one unit of phase, see `decode`
CLOSE, MOST = 16 * np.finfo(float).eps, 100  # of Newton's steps


@dataclass(frozen=True)
class KinectLens:
    """The depth camera [px], distortion in OpenCV's terms."""

    fx: float
    fy: float
    cx: float
    cy: float
    k1: float
    k2: float
    p1: float
    p2: float
    k3: float


@dataclass(frozen=True)
class KinectTables:
    """For each pixel of the sub-images (424, 512)."""

    phase: NDArray[np.float32]  # (3, 424, 512) float32 [rad], of the three frequencies
    x: NDArray[np.float32]  # (424, 512) float32 of the ray with z = 1, right of the axis
    # (424, 512) float32 [mm] of z for one unit of phase, without the lamp's offset; 0: no value
    per_phase: NDArray[np.float32]


def read_lens(data: bytes) -> KinectLens:
    """Reply 0x03. Raises DeviceError: too short, or no camera."""
    values = np.frombuffer(data[:CAMERA_BYTES], "<f4") if len(data) >= CAMERA_BYTES else np.zeros(0, np.float32)
    if not len(values) or not np.isfinite(values[:10]).all() or values[0] <= 0 or values[1] <= 0:
        raise DeviceError("the depth camera's parameters are none", "Kinect v2", f"{len(data)} bytes", "92, fx > 0")
    fx, fy, _, cx, cy, *bent = (float(value) for value in values[:10])
    return KinectLens(fx, fy, cx, cy, *bent)


def read_phases(data: bytes) -> NDArray[np.float32]:
    """Reply 0x02: (3, 424, 512) phase [rad] of each frequency. Raises DeviceError: too short."""
    if len(data) < PHASE_BYTES:
        raise DeviceError("the phase tables are cut off", "Kinect v2", f"{len(data)} bytes", f"{PHASE_BYTES}")
    words = np.frombuffer(data[PHASE_HEADER:PHASE_BYTES], "<u2").reshape(3, WIDTH * HEIGHT + 2)[:, 1:-1]
    stored = words.reshape(3, HEIGHT, WIDTH)[:, ::-1]  # upside down
    return (-0.000031 * np.pi * stored).astype(np.float32)


def made_tables(lens: KinectLens, phases: NDArray[np.float32]) -> KinectTables:
    """What is needed of each pixel."""
    v, u = np.mgrid[:HEIGHT, :WIDTH]
    x, y = undistorted(lens, (u + 0.5 - lens.cx) / lens.fx, (v + 0.5 - lens.cy) / lens.fy)
    per_phase = PER_CYCLE / np.sqrt(x**2 + y**2 + 1)
    return KinectTables(np.ascontiguousarray(phases), x.astype(np.float32), per_phase.astype(np.float32))


def undistorted(lens: KinectLens, xd: NDArray, yd: NDArray) -> tuple[NDArray, NDArray]:
    """Normalised coordinates without the lens's distortion, by Newton's method."""
    x, y = xd.copy(), yd.copy()
    for _ in range(MOST):
        r2 = x**2 + y**2
        radial = 1 + r2 * (lens.k1 + r2 * (lens.k2 + r2 * lens.k3))
        slope = lens.k1 + r2 * (2 * lens.k2 + 3 * r2 * lens.k3)  # of radial by r2
        off_x = x * radial + lens.p2 * (r2 + 2 * x**2) + 2 * lens.p1 * x * y - xd
        off_y = y * radial + lens.p1 * (r2 + 2 * y**2) + 2 * lens.p2 * x * y - yd
        xx = radial + 2 * x**2 * slope + 6 * lens.p2 * x + 2 * lens.p1 * y
        yy = radial + 2 * y**2 * slope + 6 * lens.p1 * y + 2 * lens.p2 * x
        xy = 2 * x * y * slope + 2 * lens.p2 * y + 2 * lens.p1 * x  # both mixed derivatives
        det = xx * yy - xy**2
        dx, dy = (yy * off_x - xy * off_y) / det, (xx * off_y - xy * off_x) / det
        x, y = x - dx, y - dy
        if max(np.abs(dx).max(), np.abs(dy).max()) < CLOSE:
            break
    return x, y
