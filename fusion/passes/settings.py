"""What a merge may be told."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.errors import FusionError
from fusion.geometry.pose import is_rigid
from fusion.quantity import HOLES, check_volume


@dataclass(frozen=True)
class MergeSettings:
    """What a merge may be told.

    Attributes:
        transforms: (passes, 4, 4) that take each pass's object frame to that of the first, known from elsewhere: they
            are neither sought nor refined; None seeks them.
        voxel, truncation: [m]; None takes the finest voxel, and the widest truncation, of the passes.
        color: colour the mesh where recordings have colour images, and ask colour where shape does not decide.
        fill_holes: close holes up to this perimeter [m].
    """

    transforms: NDArray[np.float64] | None = None
    voxel: float | None = None
    truncation: float | None = None
    color: bool = True
    fill_holes: float = 0.03

    def __post_init__(self) -> None:
        check_volume(self.voxel, self.truncation, None)
        HOLES.check(self.fill_holes)
        if self.transforms is not None and not all(is_rigid(T) for T in self.transforms):
            raise FusionError("a transform is no rigid motion", "the transforms of the passes", expected="4x4 poses")
