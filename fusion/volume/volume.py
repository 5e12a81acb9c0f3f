"""The volume: a sparse truncated signed distance field that depth images are fused into."""

from pathlib import Path
from threading import RLock

import numpy as np
from numpy.typing import NDArray

from fusion.compute.spare import Spare
from fusion.compute.start import start
from fusion.errors import VolumeError
from fusion.geometry.camera import Camera
from fusion.geometry.pose import Array, is_rigid
from fusion.mesh.mesh import Mesh
from fusion.volume import store
from fusion.volume.blocks import Blocks
from fusion.volume.dense import Box, DenseField, dense
from fusion.volume.extraction.surface import surface
from fusion.volume.integration.frame import FrameImages, work
from fusion.volume.integration.integrate import integrate
from fusion.volume.raycasting.image_pool import ImagePool
from fusion.volume.raycasting.raycast import Raycast, raycast
from fusion.volume.sample import sample
from fusion.volume.settings import VolumeSettings

__all__ = ["Raycast", "Volume", "VolumeSettings"]


class Volume:
    """Fused depth. Voxels hold sum(weight * distance) and sum(weight), so volumes add up exactly.

    Several threads may use one volume: what they ask for is done one after the other.

    Attributes:
        settings: voxel size, truncation and limits.
        blocks: the storage.
    """

    def __init__(self, settings: VolumeSettings) -> None:
        start()
        self.settings = settings
        self.blocks = Blocks(settings)
        self._scratch = Scratch()

    def __repr__(self) -> str:
        s = self.settings
        size = f"{self.block_count:,} blocks of 8 x 8 x 8 voxels, {self.bytes / 2**20:.0f} MiB"
        color = ", colour" * s.color
        return f"<Volume: voxels of {s.voxel * 1e3:g} mm, truncated at {s.truncation * 1e3:g} mm{color}; {size}>"

    @property
    def block_count(self) -> int:
        """Number of 8 x 8 x 8 blocks in use."""
        return self.blocks.count

    @property
    def bytes(self) -> int:
        """Memory of the volume [bytes]."""
        return self.blocks.bytes

    def integrate(
        self,
        depth: NDArray[np.floating],
        camera: Camera,
        T_world_camera: Array,
        weight: NDArray[np.floating] | None = None,
        color: NDArray[np.uint8] | None = None,
    ) -> None:
        """Fuse a frame.

        Args:
            depth: (h, w) planar z [m]; NaN, infinite, zero and negative are missing: they add and carve nothing.
            camera: of the depth image; its lens distortion is applied to every voxel.
            T_world_camera: (4, 4).
            weight: (h, w), one over variance for instance; pixels without a positive weight are missing. None = 1.
                The cosine at which the surface is seen is multiplied on in any case.
            color: (h, w, 3) uint8 in the depth camera's pixels; used when the settings ask for colour.

        Raises:
            VolumeError: shapes that do not fit, a pose that is not rigid, or blocks that do not fit into memory;
                nothing is fused then.
        """
        _check_shape("depth", depth, camera.shape)
        _check_pose(T_world_camera)
        if weight is not None:
            _check_shape("weight", weight, camera.shape)
        if color is not None:
            _check_shape("colour", color, (*camera.shape, 3))
            color = np.asarray(color, np.uint8)
        images = FrameImages(np.ascontiguousarray(depth, np.float32), weight, color)
        with self._scratch.turn, self._scratch.frames.taken(camera) as frame:
            integrate(self.blocks, images, camera, np.asarray(T_world_camera, float), frame)

    def raycast(self, camera: Camera, T_world_camera: Array, near: float = 0.1, far: float = 10.0) -> Raycast:
        """The surface as a camera at a pose (4, 4) sees it between the depths near and far [m].

        Raises:
            VolumeError: the pose is not rigid.
        """
        _check_pose(T_world_camera)
        with self._scratch.turn:
            images = self._scratch.pool.take(*camera.shape)
            seen = raycast(self.blocks, camera, np.asarray(T_world_camera, float), (near, far), images)
            self._scratch.pool.give_back(images)
        return seen

    def sample(self, points: Array) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]]:
        """Trilinear distance (n,) [m], its gradient (n, 3) and weight (n,) at world points (n, 3) [m].

        NaN, NaN and 0 where one of the eight voxels around was never seen.
        """
        with self._scratch.turn:
            distance, gradient, weight = sample(self.blocks, points)
        return distance, gradient, weight

    def to_numpy(self, box: Box | None = None) -> DenseField:
        """Distances and weights of all voxels in a box as plain arrays; None takes all that is in use.

        Raises:
            VolumeError: corners that are no box, or arrays larger than `settings.max_bytes`.

        >>> volume = fusion.Volume(fusion.VolumeSettings(voxel=0.01, truncation=0.04))
        >>> volume.integrate(np.ones((48, 64)), fusion.Camera(64, 48, 60.0, 60.0, 31.5, 23.5), np.eye(4))
        >>> field = volume.to_numpy(box=((-0.06, -0.06, 0.9), (0.06, 0.06, 1.1)))
        >>> field.distance.shape, field.origin.round(3).tolist()
        ((13, 13, 21), [-0.06, -0.06, 0.9])
        >>> print(field.distance[6, 6, 8:13].round(2))  # from 2 cm before a wall at 1 m to 2 cm behind it
        [ 0.02  0.01  0.   -0.01 -0.02]
        """
        with self._scratch.turn:
            return dense(self.blocks, box)

    def surface(self, min_weight: float = 1e-6) -> Mesh:
        """The zero surface as a welded mesh with outward normals; cells with a corner below min_weight are left out."""
        with self._scratch.turn:
            return surface(self.blocks, min_weight)

    def add(self, other: "Volume") -> None:
        """Add what another volume of the same voxel size and truncation has seen.

        Raises:
            VolumeError: the settings differ, or the blocks do not fit into memory; nothing is added then.
        """
        ours, theirs = self.settings, other.settings
        if (ours.voxel, ours.truncation, ours.color) != (theirs.voxel, theirs.truncation, theirs.color):
            raise VolumeError(
                "the volumes do not add up",
                found=f"voxel {theirs.voxel} m, truncation {theirs.truncation} m, colour {theirs.color}",
                expected=f"voxel {ours.voxel} m, truncation {ours.truncation} m, colour {ours.color}",
            )
        first, second = sorted((self, other), key=id)  # two threads may add two volumes to each other
        with first._scratch.turn, second._scratch.turn:
            self._add(other.blocks)

    def _add(self, others: Blocks) -> None:
        coordinates = others.coordinates[: others.count]
        self.blocks.insert(coordinates[self.blocks.find(coordinates) < 0])
        ids = self.blocks.find(coordinates)
        self.blocks.voxels[ids] += others.voxels[: others.count]
        self.blocks.mark(ids)
        if self.settings.color:
            self.blocks.colors[ids] += others.colors[: others.count]

    def save(self, path: Path | str) -> None:
        """Write to a .npz file, whole or not at all."""
        with self._scratch.turn:
            store.save(self.blocks, Path(path))

    @classmethod
    def load(cls, path: Path | str) -> "Volume":
        """Read what `save` wrote. VolumeError: the file is missing or no volume."""
        start()
        blocks = store.load(Path(path))
        volume = cls(blocks.settings)
        volume.blocks = blocks
        return volume


def _check_shape(name: str, image: NDArray, shape: tuple[int, ...]) -> None:
    if np.shape(image) != shape:
        raise VolumeError(f"the {name} image does not fit the camera", found=np.shape(image), expected=shape)


def _check_pose(T: Array) -> None:
    if not is_rigid(np.asarray(T, float)):
        raise VolumeError("the camera pose is not a rigid motion", found=np.asarray(T).tolist(), expected="a 4x4 pose")


class Scratch:
    """A volume's scratch images, and whose turn it is.

    Attributes:
        turn: held by the thread that works on the volume; others wait.
        frames: images that frames are worked on in, by camera.
        canvases: images that raycasts are written to.
    """

    def __init__(self) -> None:
        self.turn = RLock()
        self.frames = Spare(work, most=2)  # a depth camera, and one of another size
        self.pool = ImagePool()

    def __reduce__(self) -> tuple[type, tuple[()]]:
        """A copy of a volume has scratch of its own."""
        return Scratch, ()
