"""Seeing the volume from a camera: the first place on each ray where the field goes from outside to inside."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.compute.choice import either
from fusion.compute.shares import dealt
from fusion.geometry.camera import Camera
from fusion.geometry.pose import Array
from fusion.volume.blocks import Blocks
from fusion.volume.lens import eye
from fusion.volume.raycasting.cast import SPACING, Depths, Tiles, cast
from fusion.volume.raycasting.curve import COARSE, unseen
from fusion.volume.raycasting.image_pool import PooledImages
from fusion.volume.raycasting.shade import Ends, Written, shade, slants
from fusion.volume.raycasting.window import window


@dataclass(frozen=True)
class Raycast:
    """The surface as a camera sees it, in its own frame; NaN where nothing was seen. Read only: copy what to change."""

    depth: NDArray[np.float32]  # (h, w) float32, planar z [m]
    points: NDArray[np.float32]  # (h, w, 3) float32 [m]
    normals: NDArray[np.float32]  # (h, w, 3) float32 unit vectors towards the camera; NaN where nothing was hit
    colors: NDArray[np.uint8] | None = None  # (h, w, 3) uint8, 0 where unknown; None for a volume without colour


@either
def raycast(
    blocks: Blocks, camera: Camera, T_world_camera: Array, reach: tuple[float, float], images: PooledImages
) -> Raycast:
    """The surface seen by a camera at a pose (4, 4), between two depths `reach` = (near, far) [m].

    It is written to pooled images, which has the size of the camera's images.
    """
    h, w = camera.shape
    seen = window(blocks, camera, T_world_camera, (max(reach[0], 1e-4), reach[1]))
    field, here, voxel = seen.field(blocks), eye(camera, T_world_camera), blocks.settings.voxel
    down, across = np.nonzero(seen.last)
    tiles = Tiles(seen.first, seen.last, (down << 16 | across).astype(np.int32), len(down))
    # of the first step nothing is coarser; no kernel gets an array twice, as a card would have two copies of it
    coarse, fine = np.empty((1, 1), np.float32), unseen(h, w, COARSE)
    for step in (COARSE, 2, 1):
        farthest = SPACING * voxel * camera.fx / (2 * step)
        if step != COARSE:
            coarse, fine = fine, unseen(h, w, step)
        depths = Depths(coarse, fine, farthest)
        cast(step, field, camera.rays(), here, tiles, depths, dealt(), any(camera.distortion))
    colored = blocks.settings.color
    colors = np.zeros((h, w, 3) if colored else (1, 1, 3), np.uint8)
    ends = Ends(*slants(camera), fine.reshape(-1), fine.shape[1], camera.fx)
    out = Written(images.depth, images.points, images.normals, images.used, colors)
    shade(field, blocks.arrays.colors, ends, here.pose, out, dealt(), colored)
    depth, points, normals = images.shown()
    return Raycast(depth, points, normals, colors if colored else None)
