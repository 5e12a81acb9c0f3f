"""Every frame that reaches a tile is fused into it; tiles that do not fit are cut into smaller ones."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from fusion.errors import RecordingError
from fusion.geometry.camera import Camera
from fusion.geometry.pose import Array, transform
from fusion.progress import each, stage
from fusion.tiles.piece import Filed, piece_of
from fusion.tiles.tile import Tile, tiles_of
from fusion.volume.blocks import FullError
from fusion.volume.extraction.surface import extract
from fusion.volume.prepared import Prepared, fusible, fusing_weight
from fusion.volume.settings import BLOCK, VolumeSettings
from fusion.volume.volume import Volume

LEAST_WEIGHT = 1e-6  # of the voxels of a cell, as `Volume.surface` has it
FLAT = 2.5  # blocks that a flat surface takes for each block's face of it, at the usual truncation (see forecast.py)
FINE, COARSE = 8, 64  # [px] edge of a patch
BEHIND = 2.0  # truncations behind the surface that may change: one, and as much again for planes seen at a slant
ENDS = np.array(np.meshgrid([0, 1], [0, 1], [0, 1], indexing="ij")).reshape(3, 8)


class PreparedFrames(Protocol):
    """Frames made ready, by number; RecordingError where one cannot be read."""

    def __getitem__(self, index: int) -> Prepared: ...


@dataclass(frozen=True)
class Reached:
    """Where the frames show something."""

    tiles: list[Tile]  # that some frame has a surface in, in order
    boxes: dict[int, NDArray[np.float64]]  # of each frame used, by number, those in which it changes voxels
    cameras: dict[int, Camera]  # of these frames


def reached(frames: PreparedFrames, poses: Array, settings: VolumeSettings, folder: Path) -> Reached:
    """Look once at each frame that has a pose (n, 4, 4; NaN for none), and write what is fused of it into a folder.

    A tile reads it from there: making it ready again for each tile took two thirds of the time.
    """
    edge = settings.voxel * BLOCK
    across = int(np.sqrt(max(settings.max_bytes / settings.block_bytes / FLAT, 1.0)))
    tiles: set[Tile] = set()
    boxes, cameras = {}, {}
    for index in each(np.flatnonzero(np.isfinite(poses).all(axis=(1, 2))).tolist(), "tiles"):
        try:
            frame = frames[index]
        except RecordingError:  # as where all is fused at once, the others go on
            continue
        camera, T = frame.surface.camera, poses[index]
        depth = np.where(fusible(frame, settings.truncation), frame.depth, np.float32(np.nan))
        tiles |= tiles_of(shown(depth, camera, T, settings.truncation), edge, across)
        boxes[index], cameras[index] = changed(depth, camera, T, settings.truncation), camera
        np.save(_ready(folder, index), np.stack([frame.depth, fusing_weight(frame, settings.truncation)]))
    return Reached(sorted(tiles), boxes, cameras)


def _ready(folder: Path, index: int) -> Path:
    """The file of a frame's depth and weight (2, h, w)."""
    return folder / f"frame_{index}.npy"


@dataclass(frozen=True)
class TileJob:
    """A tile to be fused."""

    tile: Tile  # its core is what counts
    settings: VolumeSettings  # of the whole volume; `max_bytes` is for this tile
    # those that reach it, in order: number, camera and `T_world_camera` (4, 4)
    frames: tuple[tuple[int, Camera, Array], ...]
    folder: Path  # where what is fused of them lies, and where its piece belongs

    @property
    def path(self) -> Path:
        """Of its piece."""
        return self.folder / f"{self.tile.name}.npz"


class Outcome(Enum):
    """What became of a job."""

    MADE = "made"
    NOTHING = "nothing"  # there is no surface in it
    FULL = "full"  # the tile does not fit into its memory


Way = Callable[[list[TileJob]], Iterator[tuple[TileJob, Outcome]]]  # takes jobs from the list's end until none is left


def pieces(frames: PreparedFrames, poses: Array, settings: VolumeSettings, folder: Path, way: Way) -> list[Filed]:
    """Fuse tile by tile; a file in the folder for each piece of the surface, in the order of their tiles.

    The folder takes 8 bytes for each pixel of each frame too.

    Args:
        frames: of the recording.
        poses: (n, 4, 4) `T_world_camera`, NaN for frames that are left out.
        settings: of the whole volume; `max_bytes` is for one tile.
        folder: an empty one.
        way: how jobs are done.

    Raises:
        VolumeError: one block with those around it does not fit into `max_bytes`.
    """
    found = reached(frames, poses, settings, folder)

    def job(tile: Tile) -> TileJob:
        those = [i for i, boxes in found.boxes.items() if tile.reached(boxes, settings.voxel * BLOCK)]
        return TileJob(tile, settings, tuple((i, found.cameras[i], poses[i]) for i in those), folder)

    made: list[Filed] = []
    waiting = [job(tile) for tile in reversed(found.tiles)]
    with stage("fusing tiles", len(waiting)) as step:
        for one, outcome in way(waiting):
            if outcome is Outcome.FULL:
                if not one.tile.divisible:
                    raise FullError(
                        "a tile of one block does not fit into its memory", found=f"{settings.max_bytes} bytes",
                        expected=f"{27 * settings.block_bytes} bytes, with the blocks around", do="allow more memory",
                    )  # fmt: skip
                waiting += [job(part) for part in sorted(one.tile.parts(), reverse=True)]
                continue
            if outcome is Outcome.MADE:
                made.append(Filed(one.tile, one.path))
            step()
    return sorted(made)


def one_by_one(waiting: list[TileJob]) -> Iterator[tuple[TileJob, Outcome]]:
    """Jobs done here."""
    while waiting:
        job = waiting.pop()
        yield job, done(job)


def done(job: TileJob) -> Outcome:
    """Fuse a tile and write its piece."""
    own = job.tile.settings(job.settings)
    if own is None or not job.frames:
        return Outcome.NOTHING
    volume = Volume(own)
    try:
        for index, camera, T in job.frames:
            depth, weight = np.load(_ready(job.folder, index))
            volume.integrate(depth, camera, T, weight)
    except FullError:
        return Outcome.FULL
    piece = piece_of(volume, job.tile, extract(volume.blocks, LEAST_WEIGHT))
    if not len(piece.vertices) and not len(piece.faces):
        return Outcome.NOTHING
    piece.save(job.path)
    return Outcome.MADE


def shown(depth: NDArray[np.float32], camera: Camera, T_world_camera: Array, truncation: float) -> NDArray[np.float64]:
    """Boxes (n, 2, 3) [m, world] in which a frame has its surface and what is fused around it."""
    near, far, rays = _patches(depth, camera, FINE)
    return _boxes(np.maximum(near - BEHIND * truncation, 0.0), far + BEHIND * truncation, rays, T_world_camera)


def changed(
    depth: NDArray[np.float32], camera: Camera, T_world_camera: Array, truncation: float
) -> NDArray[np.float64]:
    """Boxes (n, 2, 3) [m, world] in which a frame changes voxels: there, and in all that is seen to be free."""
    near, far, rays = _patches(depth, camera, COARSE)
    return _boxes(np.zeros_like(near), far + BEHIND * truncation, rays, T_world_camera)


def _patches(depth: NDArray[np.float32], camera: Camera, edge: int) -> tuple[Array, Array, Array]:
    """Of the patches (n) that show a surface: nearest and farthest depth [m], and the least and largest x and y of
    their rays at depth 1 (n, 2, 2)."""
    known = np.isfinite(depth) & (depth > 0)

    def over(values: NDArray, empty: float, reduce: np.ufunc) -> Array:
        """Of each patch the least or largest value, (n, ...)."""
        filled = np.where(np.isnan(values), empty, values)
        rows = reduce.reduceat(filled, np.arange(0, camera.height, edge), axis=0)
        found = reduce.reduceat(rows, np.arange(0, camera.width, edge), axis=1)
        return found.reshape(-1, *values.shape[2:]).astype(float)

    near = over(np.where(known, depth, np.nan), np.inf, np.minimum)
    far = over(np.where(known, depth, np.nan), -np.inf, np.maximum)
    rays = camera.rays()
    side = 1.0 / min(camera.fx, camera.fy)  # a voxel belongs to the nearest pixel: half of one, and as much to be safe
    low, high = over(rays, np.inf, np.minimum) - side, over(rays, -np.inf, np.maximum) + side
    some = np.isfinite(near) & np.isfinite(low).all(axis=1)
    return near[some], far[some], np.stack([low, high], axis=1)[some]


def _boxes(near: Array, far: Array, rays: Array, T_world_camera: Array) -> Array:
    z = np.stack([near, far], axis=1)[:, ENDS[2]]
    corners = np.stack([rays[:, ENDS[0], 0] * z, rays[:, ENDS[1], 1] * z, z], axis=-1)
    world = transform(T_world_camera, corners)
    return np.stack([world.min(axis=1), world.max(axis=1)], axis=1)
