"""Cameras as photogrammetrists write them: millimetres on the sensor, y up, Brown's correction of measured coordinates.

OpenCV's model runs the other way: it takes an undistorted ray and says where it is seen. Neither is the inverse of the
other, so one is fitted to the other over the pixels of the whole picture. The fit asks that the pixel differences have
no part along given shapes (those of Brown's terms), as many as there are unknowns. The same equations hold in both
directions, so going there and back returns the same numbers.
"""

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
from scipy.optimize import root

from fusion.errors import RecordingError
from fusion.geometry.camera import Camera
from fusion.geometry.pose import Array

ROUNDS = 60  # the correction is a few percent: each round gains a digit or more
GRID = (33, 25)  # pixels of the picture at which both forms are compared
# forms that differ by more are not one camera; in the corners Pagliari's differ by 0.16 and 0.11 px, a Kinect v2 by 1.4
MOST_PX = 3.0


@dataclass(frozen=True)
class PhotogrammetricCamera:
    """Interior orientation.

    A point measured at (x, y) from the principal point, r away, is corrected to
    x + x (K1 r^2 + K2 r^4 + K3 r^6) + P1 (r^2 + 2 x^2) + 2 P2 x y, and y alike with P2 and P1 exchanged.

    Attributes:
        width, height: [px].
        format_mm: (2,) width and height of the sensor [mm]; its pixels need not be square.
        focal_mm: principal distance [mm].
        principal_mm: (2,) principal point from the middle of the format [mm], x right, y up.
        K: K1, K2, K3 [mm^-2, mm^-4, mm^-6].
        P: P1, P2 [1/mm].
    """

    width: int
    height: int
    format_mm: tuple[float, float]
    focal_mm: float
    principal_mm: tuple[float, float] = (0.0, 0.0)
    K: tuple[float, float, float] = (0.0, 0.0, 0.0)
    P: tuple[float, float] = (0.0, 0.0)

    @property
    def pitch_mm(self) -> tuple[float, float]:
        """Width and height of a pixel [mm]."""
        return self.format_mm[0] / self.width, self.format_mm[1] / self.height

    def tangents(self, pixels: Array) -> Array:
        """(n, 2) x/z and y/z (y down, as OpenCV) of the rays that pixels (n, 2) see."""
        pitch = np.array(self.pitch_mm)
        middle = (np.array([self.width, self.height]) - 1) / 2
        x, y = ((pixels - middle) * pitch * [1, -1] - self.principal_mm).T
        r2 = x**2 + y**2
        radial = r2 * (self.K[0] + r2 * (self.K[1] + r2 * self.K[2]))
        dx = x * radial + self.P[0] * (r2 + 2 * x**2) + 2 * self.P[1] * x * y
        dy = y * radial + self.P[1] * (r2 + 2 * y**2) + 2 * self.P[0] * x * y
        return np.stack([x + dx, -(y + dy)], axis=1) / self.focal_mm

    def pixels(self, tangents: Array) -> Array:
        """(n, 2) pixels that see rays (n, 2) x/z and y/z: `tangents` inverted; NaN where the correction folds over."""
        pitch = np.array(self.pitch_mm)
        middle = (np.array([self.width, self.height]) - 1) / 2
        scale = self.focal_mm / pitch
        start = tangents * scale + middle + np.array(self.principal_mm) / pitch * [1, -1]
        pixels = start.copy()
        for _ in range(ROUNDS):
            step = (tangents - self.tangents(pixels)) * scale
            pixels = pixels + step
        return np.where(np.abs(step).max(axis=1, keepdims=True) < 1e-6, pixels, np.nan)


def to_opencv(camera: PhotogrammetricCamera) -> tuple[Camera, float]:
    """(camera, gap): the same camera in OpenCV's form with 5 distortion values, and the largest difference [px].

    The gap is a property of the two models: with strong decentring, neither OpenCV's 5 nor its 8 values can be Brown's
    correction exactly. `PhotogrammetricCamera.pixels` is exact.

    Raises:
        RecordingError: no 5 values describe it to MOST_PX.
    """
    pitch = np.array(camera.pitch_mm)
    fx, fy = camera.focal_mm / pitch
    cx = (camera.width - 1) / 2 + camera.principal_mm[0] / pitch[0]
    cy = (camera.height - 1) / 2 - camera.principal_mm[1] / pitch[1]
    plain = Camera(camera.width, camera.height, float(fx), float(fy), float(cx), float(cy))
    pixels = _grid(plain)
    tangents = camera.tangents(pixels)
    lens = _matched(lambda k: _projected(plain, tangents, k) - pixels, _shapes(plain, pixels))
    gap = np.inf if lens is None else _gap(plain, tangents, lens, pixels)
    if lens is None or gap > MOST_PX:
        raise _too_strong(gap)
    return Camera(plain.width, plain.height, plain.fx, plain.fy, plain.cx, plain.cy, tuple(lens)), gap


def to_photogrammetric(camera: Camera, format_mm: tuple[float, float]) -> tuple[PhotogrammetricCamera, float]:
    """(camera, gap): the same camera in photogrammetric form, and the largest difference [px].

    Args:
        camera: in OpenCV's form.
        format_mm: width and height of the sensor [mm]. Where fx and fy do not meet in one principal distance, the
            height follows from the width.

    Raises:
        RecordingError: Brown's correction cannot describe the lens to MOST_PX.
    """
    focal = camera.fx * format_mm[0] / camera.width
    form = (format_mm[0], focal / camera.fy * camera.height)
    principal = (
        (camera.cx - (camera.width - 1) / 2) * form[0] / camera.width,
        ((camera.height - 1) / 2 - camera.cy) * form[1] / camera.height,
    )
    pixels = _grid(camera)

    def made(values: Array) -> PhotogrammetricCamera:
        k = values / focal ** np.array([2, 4, 1, 1, 6])  # in units of the focal length all are of one size
        return PhotogrammetricCamera(
            camera.width, camera.height, form, focal, principal, (k[0], k[1], k[4]), (k[2], k[3])
        )

    lens = np.array(camera.distortion)
    values = _matched(lambda k: _projected(camera, made(k).tangents(pixels), lens) - pixels, _shapes(camera, pixels))
    gap = np.inf if values is None else _gap(camera, made(values).tangents(pixels), lens, pixels)
    if values is None or gap > MOST_PX:
        raise _too_strong(gap)
    return made(values), gap


def _gap(camera: Camera, tangents: Array, lens: Array, pixels: Array) -> float:
    """Largest distance [px] of the pixels from where the rays that they see are projected to."""
    return float(np.max(np.linalg.norm(_projected(camera, tangents, lens) - pixels, axis=1)))


def _too_strong(gap: float) -> RecordingError:
    found = f"{gap:.3g} px apart" if np.isfinite(gap) else "no solution"
    return RecordingError(
        "the lens cannot be written in the other form", found=found, expected=f"at most {MOST_PX:g} px"
    )


def _grid(camera: Camera) -> Array:
    """(n, 2) pixels over the whole picture, edges included."""
    u, v = np.meshgrid(np.linspace(0, camera.width - 1, GRID[0]), np.linspace(0, camera.height - 1, GRID[1]))
    return np.stack([u.ravel(), v.ravel()], axis=1)


def _projected(camera: Camera, tangents: Array, lens: Array) -> Array:
    rays = np.ascontiguousarray(np.hstack([tangents, np.ones((len(tangents), 1))]))
    lens = np.concatenate([lens, np.zeros(8 - len(lens))])
    return np.asarray(cv2.projectPoints(rays, np.zeros(3), np.zeros(3), camera.matrix, lens)[0], float).reshape(-1, 2)


def _shapes(camera: Camera, pixels: Array) -> Array:
    """(2n, 5) what each of OpenCV's terms moves, by the pixels' plain tangents: the same for both directions."""
    x, y = ((pixels - [camera.cx, camera.cy]) / [camera.fx, camera.fy]).T
    r2 = x**2 + y**2
    radial = [np.stack([x * r2**n, y * r2**n], axis=1) for n in (1, 2, 3)]
    tangential = [np.stack([2 * x * y, r2 + 2 * y**2], axis=1), np.stack([r2 + 2 * x**2, 2 * x * y], axis=1)]
    shapes = np.stack([radial[0], radial[1], *tangential, radial[2]], axis=2)
    return shapes.reshape(-1, 5) / np.linalg.norm(shapes.reshape(-1, 5), axis=0)


def _matched(difference: Callable[[Array], Array], shapes: Array) -> Array | None:
    """Values (k,) at which pixel differences (n, 2) have no part along shapes (2n, k); None if there are none."""
    basis, _ = np.linalg.qr(shapes)  # the same conditions, better told apart
    with np.errstate(all="ignore"):
        found = root(lambda k: basis.T @ difference(k).ravel(), np.zeros(shapes.shape[1]), tol=1e-13)
    # "not progressing" at the limit of the numbers is a success too
    return found.x if np.isfinite(found.x).all() and np.abs(found.fun).max() < 1e-7 else None
