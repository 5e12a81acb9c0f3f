"""One camera for frames that state one each: phones move the lens to hold the picture still, and focus."""

from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Camera
from fusion.geometry.pose import Array

# [px] at the image's corners: half of the 0.2 px that a recording's geometry is held to
SAME = 0.1
# of the depth: more between what stands half a pixel apart is the rim of something and no slope (80 degrees: 1.4 %)
RIM = 0.02


def common_camera(camera: Camera, stated: Array) -> tuple[Camera, dict[int, Camera], list[str]]:
    """The camera that serves all frames best, and those of the frames that see otherwise.

    Args:
        stated: (n, 4) fx, fy, cx, cy [px] of each frame.

    Returns:
        the camera with the medians; by frame the cameras that differ from it by more than 0.1 px somewhere; what to
        tell about it.
    """
    fx, fy, cx, cy = (float(value) for value in np.median(stated, axis=0))
    common = replace(camera, fx=fx, fy=fy, cx=cx, cy=cy)
    corners = np.array([[0.0, 0.0], [camera.width - 1, 0], [0, camera.height - 1], [camera.width - 1] * 2])
    corners[3, 1] = camera.height - 1
    rays = (corners - [cx, cy]) / [fx, fy]
    off = np.abs(rays * stated[:, None, :2] + stated[:, None, 2:] - corners).max(axis=(1, 2))
    other = {}
    for index in np.flatnonzero(off > SAME):
        fx, fy, cx, cy = (float(value) for value in stated[index])
        other[int(index)] = replace(common, fx=fx, fy=fy, cx=cx, cy=cy)
    if not other:
        return common, other, []
    told = f"{len(other)} of {len(stated)} frames state another camera, by up to {off.max():.1f} px: their images are"
    return common, other, [f"{told} brought into the pixels of one camera"]


def depth_in(depth: NDArray[np.float32], own: Camera, common: Camera) -> NDArray[np.float32]:
    """Depth (h, w) [m] that one camera saw, in the pixels of another at the same place; NaN where it saw nothing.

    Between pixels 1 / depth goes on evenly, as it does over a plane; at rims the nearest pixel counts.
    """
    u, v = _seen_at(own, common)
    nowhere = float("nan")
    nearest = cv2.remap(depth, u, v, cv2.INTER_NEAREST, borderMode=cv2.BORDER_CONSTANT, borderValue=nowhere)
    even = 1 / cv2.remap(1 / depth, u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT, borderValue=nowhere)
    smooth = np.abs(even - nearest) <= RIM * nearest  # not where one is NaN
    return np.where(smooth, even, nearest).astype(np.float32)


def nearest_in(image: NDArray[np.float32], own: Camera, common: Camera) -> NDArray[np.float32]:
    """An image (h, w) whose values are no lengths, in the pixels of the other camera: the nearest pixel counts."""
    u, v = _seen_at(own, common)
    return np.asarray(cv2.remap(image, u, v, cv2.INTER_NEAREST, borderMode=cv2.BORDER_REPLICATE), np.float32)


def color_in_pixels(image: NDArray[np.uint8], own: Camera, common: Camera) -> NDArray[np.uint8]:
    """The same for a colour image (h, w, 3); black where nothing was seen."""
    u, v = _seen_at(own, common)
    return np.asarray(cv2.remap(image, u, v, cv2.INTER_LINEAR), np.uint8)


def _seen_at(own: Camera, common: Camera) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """(h, w) u and v in the own image of each pixel of the common one."""
    u = (np.arange(common.width) - common.cx) / common.fx * own.fx + own.cx
    v = (np.arange(common.height) - common.cy) / common.fy * own.fy + own.cy
    across, down = np.meshgrid(u.astype(np.float32), v.astype(np.float32))
    return across, down
