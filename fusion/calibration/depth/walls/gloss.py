"""What a glossy board mirrors into the camera: light of a bright thing near it, which reads as a longer way.

It is the board's, not the camera's: fitted beside the law, so that the law need not bend to it, and not written into a
sensor model. IR and depth of the same picture give the light and the place of every surface that the camera sees.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Camera
from fusion.sensor.view import LIGHT_SPEED, MODULATIONS_HZ

FRESNEL = 0.04  # share that plastic, varnish and toner mirror: (n - 1)^2 / (n + 1)^2 with the index n = 1.5
LOBE = np.radians(10.0)  # of toner on paper (guess); 20 degrees explain as much
STEP = 4  # [px] between the pixels whose light is gathered
NEAR = 0.03  # [m] from the square: nearer is the board itself
EDGE_ON = 0.15  # cosine of the incidence below which a surface's area in a pixel is not known
BEHIND = 0.02  # cosine off the board's plane: below it lies the board, or what stands behind it
Array = NDArray[np.float64]


@dataclass(frozen=True)
class Surfaces:
    """What a picture shows, a pixel in 16: places (n, 3) [m], normals (n, 3), areas (n,) [m^2], light (n,) [count]."""

    place: Array
    normal: Array
    area: Array
    light: Array


def surfaces(depth: NDArray[np.floating], ir: NDArray, camera: Camera) -> Surfaces:
    """The surfaces in an image of depth [m], NaN where there is none, and of light (h, w) [count]."""
    with np.errstate(invalid="ignore"):
        points = np.asarray(camera.points(np.asarray(cv2.GaussianBlur(depth, (0, 0), 1.0), float)), float)
        normal = np.cross(np.gradient(points, axis=1), np.gradient(points, axis=0))
        area = np.linalg.norm(normal, axis=2)
        normal /= np.maximum(area, 1e-12)[..., None]
        facing = (normal * points).sum(axis=2) / np.linalg.norm(points, axis=2)
        used = np.zeros(camera.shape, bool)
        used[::STEP, ::STEP] = True
        used &= np.isfinite(area) & (np.abs(facing) > EDGE_ON) & np.isfinite(depth) & (ir > 0)
    normal *= -np.sign(facing)[..., None]
    place = np.asarray(camera.points(np.asarray(depth, float)), float)[used]
    return Surfaces(place, normal[used], area[used] * STEP**2, np.asarray(ir, float)[used])


def mirrored(
    point: Array, normal: Array, own: float, seen: Surfaces, frequencies: tuple[float, ...] = MODULATIONS_HZ
) -> float:
    """Change of the range [m] per unit of mirrored share: light in the lobe joins the direct light as a phasor.

    Its part across the direct light over `own`, which is both together, is the sine of the phase error: taken as the
    phase itself, which is 2 % too little at 0.3 rad (100 mm at 80 MHz).

    Args:
        point: (3,) of the board [m], in the camera frame.
        normal: (3,) of the board, towards the camera.
        own: light of the board there [count].
        seen: everything else.
        frequencies: modulations [Hz]; one with f counts f^2, as the phases of all are made into one range.
    """
    ray = point / np.linalg.norm(point)
    mirror = ray - 2 * (ray @ normal) * normal
    to = seen.place - point
    length = np.linalg.norm(to, axis=1)
    to /= np.maximum(length, 1e-9)[:, None]
    cosine = -(seen.normal * to).sum(axis=1)
    use = (to @ normal > BEHIND) & (length > NEAR) & (cosine > 0)
    off = np.arccos(np.clip(to @ mirror, -1, 1))
    lobe = np.exp(-0.5 * (off / LOBE) ** 2) / (2 * np.pi * LOBE**2)
    gathered = np.where(use, seen.light * seen.area * cosine / np.maximum(length, NEAR) ** 2 * lobe, 0.0)
    # from the lamp to the surface, to the square and back, less twice the square's range
    longer = np.linalg.norm(seen.place, axis=1) + length - np.linalg.norm(point)
    parts = [f * (gathered * np.sin(2 * np.pi * f * longer / LIGHT_SPEED)).sum() for f in frequencies]
    total = sum(f**2 for f in frequencies)
    return float(sum(parts)) / total * LIGHT_SPEED / (4 * np.pi) / max(own, 1.0)


def gloss_map(
    squares: NDArray[np.intp],
    stands: tuple[Array, Array],
    ir: NDArray[np.floating],
    seen: Surfaces,
    frequencies: tuple[float, ...] = MODULATIONS_HZ,
) -> Array:
    """(h, w) change of the range [m] per unit of mirrored share, the same all over a square; 0 outside.

    Args:
        squares: (h, w) number of the square that a pixel sees, -1 elsewhere.
        stands: middles (n, 3) of the squares [m] and normal (3,) of the board, in the camera frame.
        ir: (h, w) light [count].
        seen: the surfaces of the same picture.
        frequencies: modulations [Hz].
    """
    middles, normal = stands
    towards = normal if normal @ middles.mean(axis=0) < 0 else -normal
    out = np.zeros(squares.shape)
    for number in np.unique(squares[squares >= 0]):
        mine = squares == number
        out[mine] = mirrored(middles[number], towards, float(np.median(ir[mine])), seen, frequencies)
    return out
