"""What recordings of iPhones and iPads share: ARKit's axes, pixels and confidence."""

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from fusion.errors import RecordingError
from fusion.geometry.camera import Camera, Principle
from fusion.geometry.pose import Array, other_axes

# the smallest images of the LiDAR, and those of TrueDepth, longer side first
LIDAR, TRUEDEPTH = (256, 192), (640, 480)
SENSORS = {LIDAR: ("iphone-lidar", Principle.UNKNOWN), TRUEDEPTH: ("iphone-truedepth", Principle.STRUCTURED_LIGHT)}
COARSE = "depth of the phone's LiDAR (256 x 192): details below 1 to 2 cm are not resolved"
LOOKED_AT = 3  # frames that tell whether confidence says anything
# noise of ARKit's middle confidence over that of the highest: at least this (a guess: Apple gives the levels no
# number), more where the recording shows more, and no more than leaves a hundredth of the weight
MIDDLE, MOST = 2.0, 10.0
ENOUGH = 500  # pixels of each level for a median that is sure to 5 %


@dataclass(frozen=True)
class Confidence:
    """What a recording's confidence is worth: whether it tells pixels apart, the noise of its middle level, words."""

    used: bool
    middle: float = 1.0
    told: tuple[str, ...] = ()


UNKNOWN = Confidence(True)  # not looked at yet


class Confident(Protocol):
    """Images that may say how sure they are."""

    def confidence(self, index: int) -> NDArray[np.uint8] | None: ...
    def depth(self, index: int) -> NDArray[np.float32]: ...


def camera_of(width: int, height: int, fx: float, fy: float, ox: float, oy: float) -> Camera:
    """The camera of ARKit's intrinsics [px]: the principal point is given from the image's corner (Apple,
    ARCamera.intrinsics), half a pixel from the centre of the first pixel."""
    sensor, principle = SENSORS.get((max(width, height), min(width, height)), ("", Principle.UNKNOWN))
    return Camera(width, height, fx, fy, ox - 0.5, oy - 0.5, sensor=sensor, principle=principle)


def depth_camera(color: Camera, width: int, height: int) -> Camera:
    """The camera of depth images that lie over the colour images, in another size."""
    resized = color.resized(width, height)
    return camera_of(width, height, resized.fx, resized.fy, resized.cx + 0.5, resized.cy + 0.5)


def sized(camera: Camera, shape: tuple[int, int]) -> Camera:
    """A camera that was said by four numbers alone with the (height, width) of the depth images; others as they are."""
    return camera if camera.width else replace(camera, width=shape[1], height=shape[0])


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


def confidence_of(images: Confident, frames: int) -> Confidence:
    """What confidences are worth, from a few frames. Raises RecordingError where none of those can be read."""
    looked = [int(i) for i in np.unique(np.linspace(0, frames - 1, LOOKED_AT).astype(int))]
    there = [(index, image) for index in looked if (image := images.confidence(index)) is not None]
    if not there:
        return Confidence(False)
    levels = np.concatenate([_levels(image).ravel() for _, image in there])
    lowest, middle = float(np.mean(levels == 0)), float(np.mean(levels == 1))
    if lowest == 1:
        return Confidence(False, told=("confidence is the lowest everywhere: not used",))
    told = [f"pixels of the lowest confidence are taken as missing: {100 * lowest:.0f} %"] if lowest else []
    if not middle:
        return Confidence(True, told=tuple(told))
    factor = _middle_noise([(depth, _levels(image)) for index, image in there for depth in _readable(images, index)])
    told.append(
        f"pixels of middle confidence count {100 / factor**2:.0f} % of the others ({factor:.1f} times their noise):"
        f" {100 * middle:.0f} %"
    )
    return Confidence(True, factor, tuple(told))


def noisier(confidence: NDArray[np.uint8] | None, middle: float) -> NDArray[np.float32] | None:
    """Factor (h, w) on the noise of each pixel, or None where confidence tells none apart."""
    if confidence is None or middle == 1:
        return None
    return np.where(_levels(confidence) == 1, np.float32(middle), np.float32(1))


def _levels(confidence: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """0, 1 or 2 of images that hold these, or 0, 127 and 255."""
    highest = (confidence == 2) | (confidence > 191)
    return np.where(confidence == 0, 0, np.where(highest, 2, 1)).astype(np.uint8)


def _readable(images: Confident, index: int) -> list[NDArray[np.float32]]:
    try:
        return [images.depth(index)]
    except RecordingError:  # told by the frame that is asked for
        return []


def _middle_noise(looked: list[tuple[NDArray[np.float32], NDArray[np.uint8]]]) -> float:
    """Noise of the middle level over that of the highest, as pixels differ from the mean of their four neighbours."""
    found: dict[int, list[NDArray]] = {1: [], 2: []}
    for depth, level in looked:
        if depth.shape != level.shape:
            continue
        ring = np.stack([depth[:-2, 1:-1], depth[2:, 1:-1], depth[1:-1, :-2], depth[1:-1, 2:]])
        same = [level[:-2, 1:-1], level[2:, 1:-1], level[1:-1, :-2], level[1:-1, 2:]]
        middle = depth[1:-1, 1:-1]
        off = (middle - ring.mean(axis=0)) / middle  # phones' noise grows with distance about evenly
        for kind, parts in found.items():
            alike = np.logical_and.reduce([level[1:-1, 1:-1] == kind, *(part == kind for part in same)])
            parts.append(np.abs(off[alike & np.isfinite(off)]))
    medium, high = (np.concatenate(parts) if parts else np.zeros(0) for parts in found.values())
    if min(len(medium), len(high)) < ENOUGH or not np.median(high) > 0:
        return MIDDLE
    return float(np.clip(np.median(medium) / np.median(high), MIDDLE, MOST))
