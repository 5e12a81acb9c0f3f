"""What a volume is made of: voxel size, truncation, colour, limits."""

from dataclasses import dataclass

import numpy as np

from fusion.errors import VolumeError

BLOCK = 8  # voxels along the edge of a block
VOXELS = BLOCK**3
LATTICE = 1 << 20  # block coordinates lie in [-LATTICE, LATTICE): 21 bits each in one 64-bit key


@dataclass(frozen=True)
class VolumeSettings:
    """Settings of a volume; two volumes add up when voxel and truncation are equal.

    Attributes:
        voxel: edge of a voxel [m]. Voxel (i, j, k) is the sample at (i, j, k) * voxel in the world.
        truncation: half width of the band around the surface [m]; at least one voxel.
        color: True to fuse colour too (five times the memory).
        bounds: two corners (3,), (3,) [m] of a world-aligned box; surface outside of it takes no memory.
        max_bytes: limit of the volume's memory.

    Raises:
        VolumeError: a value that makes no sense.
    """

    voxel: float
    truncation: float
    color: bool = False
    bounds: tuple[tuple[float, float, float], tuple[float, float, float]] | None = None
    max_bytes: int = 4 << 30

    def __post_init__(self) -> None:
        if not (np.isfinite(self.voxel) and self.voxel > 0):
            raise VolumeError("the voxel size is not usable", found=self.voxel, expected="a length in metres above 0")
        if not (np.isfinite(self.truncation) and self.voxel <= self.truncation <= 64 * self.voxel):
            raise VolumeError(
                "the truncation is not usable",
                found=f"{self.truncation} m with voxels of {self.voxel} m",
                expected="1 to 64 voxels, best 3 to 5",
            )
        if self.bounds is not None:
            low, high = (tuple(float(x) for x in corner) for corner in self.bounds)
            if len(low) != 3 or len(high) != 3 or not np.less(low, high).all():
                raise VolumeError(
                    "the bounds are not a box", found=self.bounds, expected="low and high corner, low < high"
                )
            object.__setattr__(self, "bounds", (low, high))

    @property
    def block_bytes(self) -> int:
        """Memory of one block with its share of the index [bytes]."""
        return block_bytes(self.color)


def block_bytes(color: bool) -> int:
    """Bytes of one block: voxels (8 B, 24 B with colour), position, neighbours as ids and bits, index at half load."""
    return VOXELS * (8 + 16 * color) + 3 * 4 + 28 * 4 + 4 * 12
