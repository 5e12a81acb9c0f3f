"""Where a frame sees the surface of a model that it took part in: on it, before it, or behind it."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.geometry.pose import Array
from fusion.volume.prepared import Prepared
from fusion.volume.volume import Raycast, Volume

STEEPEST = np.deg2rad(70)  # a surface seen flatter says little of its depth
RIM = 2  # [px] beside steps and holes of either image, where a camera mixes or matches both sides
STEP = 0.02  # [m] from one surface to another, within the rim's width: above the noise of any camera nearby
TOLERANCE = 3.0  # standard deviations of what noise and voxel let expect


@dataclass(frozen=True)
class Beside:
    """Pixels (h, w) of a frame beside a model.

    Attributes:
        seen: the model, as the frame's camera sees it.
        off: by how much the frame lies behind the model [m]; NaN where either shows nothing.
        limit: more than noise and voxels let expect [m].
        facing: cosine between the model's normal and the way back to the camera.
        calm: neither image has a step or a hole nearby.
        shown: the frame says something of the model there.
    """

    seen: Raycast
    off: NDArray[np.float32]
    limit: Array
    facing: Array
    calm: NDArray[np.bool_]
    shown: NDArray[np.bool_]


def beside(volume: Volume, frame: Prepared, T_world_camera: Array) -> Beside:
    """A frame at a pose (4, 4) beside the model in a volume."""
    seen = volume.raycast(frame.surface.camera, T_world_camera)
    off = frame.depth - seen.depth
    facing = _facing(seen)
    spread = np.hypot(frame.surface.sigma, volume.settings.voxel / 2)
    limit = TOLERANCE * spread / np.maximum(facing, np.cos(STEEPEST))
    calm = ~(_rim(frame.depth) | _rim(seen.depth))
    return Beside(seen, off, limit, facing, calm, calm & np.isfinite(off) & (facing > np.cos(STEEPEST)))


def _facing(seen: Raycast) -> Array:
    along = np.einsum("vuk,vuk->vu", seen.normals, seen.points)
    return np.asarray(-along / np.linalg.norm(seen.points, axis=-1))


def _rim(depth: NDArray[np.float32]) -> NDArray[np.bool_]:
    """(h, w) pixels beside a step or a hole of a depth image [m]."""
    around = np.ones((2 * RIM + 1, 2 * RIM + 1), np.uint8)
    filled = np.nan_to_num(depth)
    return np.asarray(cv2.dilate(filled, around) - cv2.erode(filled, around) > STEP)
