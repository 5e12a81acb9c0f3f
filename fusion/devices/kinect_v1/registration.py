"""Where a Kinect v1 says that its depth pixels lie in the colour image, as a colour camera that says the same.

The device registers depth to colour by forward differences of a cubic polynomial and a shift that depends on depth. Of
both a pinhole with a lens beside the depth camera is made, since all else here knows cameras and places.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from fusion.geometry.camera import Camera
from fusion.recording.cameras.zero_plane import ZeroPlane

HEIGHT, WIDTH = 480, 640
NUMBERS = 29
NOMINAL_FOCAL = 525.0  # [px] of the colour camera: OpenNI's default
DISTANCES = (0.5, 0.8, 1.2, 2.0, 4.0)  # [m] at which both are compared
WORST = 2.0  # [px] rms beyond which the device's table is not believed (guess: what one sees as a fringe of colour)


def color_camera(
    depth: Camera, plane: ZeroPlane, numbers: Sequence[int], padding: Sequence[int] = ()
) -> tuple[Camera, str]:
    """The depth camera with its colour camera beside it, and a sentence on where that came from."""
    apart = np.eye(4)
    apart[0, 3] = -0.01 * plane.to_color  # the colour camera stands to the right
    nominal = replace(depth, fx=NOMINAL_FOCAL, fy=NOMINAL_FOCAL, color=None, T_color_depth=None, depth_scale=1000.0)
    if len(numbers) == NUMBERS and any(numbers):
        found, rms = _fitted(depth, nominal, apart, plane, numbers, padding[0] if padding else 0)
        if rms <= WORST:
            return found, f"the colour camera follows from the device's registration table, to {rms:.2f} px rms"
    return (
        replace(depth, color=nominal, T_color_depth=apart),
        "the colour camera is nominal: the device's registration table cannot be used",
    )


def table(numbers: Sequence[int]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(480, 640) column and row [px] of each depth pixel in the colour image, for things at the reference distance.

    Forward differences; sums of 64 bit, of which the first shift is taken in 32 bit as the device's fields are.
    """
    n = [int(value) for value in numbers]
    (_, ax, bx, cx, dx, x0, ay, by, cy, dy, y0) = n[:11]
    (xx0, xy0, yx0, yy0, xxx0, yxx0, xxy0, yxy0, _, yyx0, _, yyy0) = n[17:29]
    across = _sums(ax, bx, cx, dx, x0, xx0, yx0, xxx0, yxx0, yyx0)
    down = _sums(ay, by, cy, dy, y0, xy0, yy0, xxy0, yxy0, yyy0)
    v, u = np.mgrid[0:HEIGHT, 0:WIDTH]
    return u + across / 2**17 + 1, v + down / 2**17 + 1


def shift(plane: ZeroPlane, z: float) -> float:
    """How many columns [px] further right than `table` says a thing at a depth [m] is seen."""
    scale = 1 / (plane.pixel * 2 * 10)
    baseline, reference, far = 10 * plane.to_color * scale, 10 * plane.distance * scale, 1000 * z * scale
    return baseline * (far - reference) / far + 0.375


def _sums(a: int, b: int, c: int, d: int, x0: int, dx0: int, dy0: int, dxx0: int, dyx0: int, dyy0: int) -> NDArray:
    """(480, 640) of one coordinate: start, slopes along x and y, and theirs."""
    x, dx, dy = _field(x0, 13, 4), _field(dx0, 11, 3), _field(dy0, 11, 3)
    dxx, dyx, dyy = _field(dxx0, 5, 3), _field(dyx0, 5, 3), _field(dyy0, 5, 3)
    made = np.empty((HEIGHT, WIDTH))
    steps = np.arange(WIDTH, dtype=np.int64)
    for row in range(HEIGHT):
        dxx += c
        dx += dyx >> 8
        dyx += d
        x += dy >> 6
        dy += dyy >> 8
        dyy += b
        third = dxx + a * steps
        second = dx + _before(third >> 8)
        made[row] = x + _before(second >> 6)
    return made


def _before(steps: NDArray[np.int64]) -> NDArray[np.int64]:
    """Sum of the steps before each."""
    return np.concatenate([[0], np.cumsum(steps[:-1])])


def _field(value: int, left: int, right: int) -> int:
    """Shifted left in 32 bit with a sign, then right."""
    moved = (value << left) & 0xFFFFFFFF
    return (moved - (moved >> 31 << 32)) >> right


def _fitted(
    depth: Camera, nominal: Camera, apart: NDArray, plane: ZeroPlane, numbers: Sequence[int], start: int
) -> tuple[Camera, float]:
    """The camera whose images of points at several distances lie nearest to the device's table, and the rms [px].

    `start`: lines that the device cuts off the top of the colour image.
    """
    v, u = np.mgrid[20:HEIGHT:40, 20:WIDTH:40].reshape(2, -1)
    points = [depth.rays()[v, u] * z for z in DISTANCES]
    points = [np.column_stack([xy, np.full(len(xy), z)]) for xy, z in zip(points, DISTANCES, strict=True)]
    columns, rows = table(numbers)
    seen = [np.stack([columns[v, u] + shift(plane, z), rows[v, u] - start], axis=1) for z in DISTANCES]
    cloud = np.concatenate(points).astype(float)

    def made(x: NDArray) -> tuple[Camera, NDArray]:
        T = np.eye(4)
        T[:3, :3] = Rotation.from_rotvec(x[6:9]).as_matrix()
        T[:3, 3] = apart[:3, 3] + x[9:12]
        return replace(nominal, fx=x[0], fy=x[1], cx=x[2], cy=x[3], distortion=(x[4], x[5])), T

    def gaps(x: NDArray) -> NDArray:
        camera, T = made(x)
        return (camera.project(cloud @ T[:3, :3].T + T[:3, 3]) - np.concatenate(seen)).ravel()

    first = np.array([nominal.fx, nominal.fy, nominal.cx, nominal.cy, *[0.0] * 8])
    scale = np.array([100.0, 100.0, 10.0, 10.0, 0.1, 0.1, *[0.01] * 6])
    found = least_squares(gaps, first, x_scale=scale, max_nfev=60)
    camera, T = made(found.x)
    return replace(depth, color=camera, T_color_depth=T), float(np.sqrt(np.mean(found.fun**2) * 2))
