"""Before the start: which voxel and truncation fit, and how much memory a volume will take."""

import numpy as np
from numpy.typing import NDArray

from fusion.errors import VolumeError
from fusion.geometry.camera import Camera
from fusion.volume.settings import BLOCK, VolumeSettings


def choose_voxel(distance: float, camera: Camera, room: bool = False) -> float:
    """Voxel size [m] that suits a distance [m]: what a pixel covers there, in steps of 0.25 mm.

    Objects get 1 to 2 mm; a room gets at least 5 mm, and at most 2 cm.

    Raises:
        VolumeError: the distance is not a positive number.
    """
    if not (np.isfinite(distance) and distance > 0):
        raise VolumeError("no distance to choose a voxel size from", found=distance, expected="metres above 0")
    step = 0.25e-3
    pixel = distance / min(camera.fx, camera.fy)
    low, high = (5e-3, 20e-3) if room else (1e-3, 2e-3)
    return float(np.clip(round(pixel / step) * step, low, high))


def choose_truncation(voxel: float, sigma: float) -> float:
    """Truncation [m]: three standard deviations of the depth noise [m], but 4 to 16 voxels.

    Four voxels keep a full 2 x 2 x 2 cell valid on both sides at any slant (guess, as in the peers' defaults);
    more than 16 only costs memory and closes gaps between thin walls.
    """
    noise = 3.0 * sigma if np.isfinite(sigma) else 0.0
    return float(np.clip(noise, 4.0 * voxel, 16.0 * voxel))


def forecast_bytes(
    settings: VolumeSettings,
    depth: NDArray[np.floating] | None = None,
    camera: Camera | None = None,
    area: float | None = None,
) -> int:
    """Memory [bytes] that a surface will take, from its area [m^2] or from what one depth image (h, w) [m] shows.

    A flat surface of area A with a band of t voxels on both sides, in blocks of 8 voxels and at a random slant,
    meets about A / block^2 * (1.5 + 2 t / 8) blocks: 1.5 is the mean of |nx| + |ny| + |nz| over all directions.

    Raises:
        VolumeError: neither an area nor an image with its camera was given.
    """
    if area is None:
        if depth is None or camera is None:
            raise VolumeError(
                "nothing to forecast the memory from", expected="an area, or a depth image with its camera"
            )
        area = seen_area(depth, camera)
    block = settings.voxel * BLOCK
    blocks = area / block**2 * (1.5 + 2 * settings.truncation / block)
    return int(np.ceil(blocks)) * settings.block_bytes


def seen_area(depth: NDArray[np.floating], camera: Camera) -> float:
    """Surface area [m^2] in a depth image (h, w) [m]: every pixel's patch, at most 5 times its cross-section."""
    points = camera.points(np.where(np.isfinite(depth) & (depth > 0), depth, np.nan)).astype(float)
    du, dv = points[:-1, 1:] - points[:-1, :-1], points[1:, :-1] - points[:-1, :-1]
    patch = np.linalg.norm(np.cross(du, dv), axis=-1)
    cross = points[:-1, :-1, 2] ** 2 / (camera.fx * camera.fy)
    return float(np.nansum(np.minimum(patch, 5 * cross)))
