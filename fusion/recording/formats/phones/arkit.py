"""What recordings of iPhones and iPads share: ARKit's axes, pixels and confidence."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Camera
from fusion.geometry.pose import Array, other_axes

# the smallest images of the LiDAR, longer side first; those of TrueDepth have 640 x 480 pixels
LIDAR = (256, 192)
COARSE = "depth of the phone's LiDAR (256 x 192): details below 1 to 2 cm are not resolved"
LOOKED_AT = 3  # frames that tell whether confidence says anything


def camera_of(width: int, height: int, fx: float, fy: float, ox: float, oy: float) -> Camera:
    """The camera of ARKit's intrinsics [px]: the principal point is given from the image's corner (Apple,
    ARCamera.intrinsics), half a pixel from the centre of the first pixel."""
    kind = "iphone-lidar" if max(width, height) == LIDAR[0] else ""
    return Camera(width, height, fx, fy, ox - 0.5, oy - 0.5, sensor=kind)


def depth_camera(color: Camera, width: int, height: int) -> Camera:
    """The camera of depth images that lie over the colour images, in another size."""
    resized = color.resized(width, height)
    return camera_of(width, height, resized.fx, resized.fy, resized.cx + 0.5, resized.cy + 0.5)


def same_shape(one: tuple[int, int], other: tuple[int, int]) -> bool:
    """True where one image is the other stretched evenly: sides in proportion, to a pixel of the smaller one."""
    (a, b), (c, d) = one, other
    return abs(a * d - b * c) <= max(min(a, c), min(b, d))


def from_arkit(rotation: Array, translation: Array) -> Array:
    """`T_world_camera` (..., 4, 4) of cameras whose y axis points up and that look along -z."""
    T = np.zeros((*rotation.shape[:-2], 4, 4))
    T[..., :3, :3], T[..., :3, 3], T[..., 3, 3] = rotation, translation, 1.0
    return other_axes(T)


def sure(depth: NDArray[np.float32], confidence: NDArray[np.uint8] | None) -> NDArray[np.float32]:
    """Depth (h, w) [m] with NaN where it is no length, and where ARKit's confidence is the lowest (0)."""
    good = np.isfinite(depth) & (depth > 0)
    if confidence is not None:
        good &= confidence > 0
    return np.where(good, depth, np.nan).astype(np.float32)


def says_something(confidence: Callable[[int], NDArray[np.uint8] | None], frames: int) -> tuple[bool, list[str]]:
    """Whether confidences tell pixels apart, from a few frames, and what is told about them."""
    looked = [confidence(int(i)) for i in np.unique(np.linspace(0, frames - 1, LOOKED_AT).astype(int))]
    there = [image for image in looked if image is not None]
    if not there:
        return False, []
    lowest = float(np.mean([np.mean(image == 0) for image in there]))
    if lowest == 1:
        return False, ["confidence is the lowest everywhere: not used"]
    return True, [f"pixels of the lowest confidence are taken as missing: {100 * lowest:.0f} %"] if lowest else []
