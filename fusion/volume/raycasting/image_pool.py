"""Images that raycasts are written to. They serve again once nobody holds them any longer: fresh ones would have to be
filled with NaN, most of which is still there where nothing was seen."""

from dataclasses import dataclass, field
from weakref import ref

import numpy as np
from numpy.typing import NDArray

PIECE = 32  # pixels of a row that are looked at in turn
MOST = 6  # kept, of all sizes together


@dataclass(frozen=True)
class PooledImages:
    """What a raycast fills in."""

    depth: NDArray[np.float32]  # (h, w) float32
    # points, normals: (3 h w,) float32
    points: NDArray[np.float32]
    normals: NDArray[np.float32]
    used: NDArray[np.int32]  # (h * pieces of a row,) int32, 0 where a piece of the three images is NaN
    # the arrays that the images were handed out as, as long as anyone holds them
    given: list[ref[NDArray[np.float32]]] = field(default_factory=list)

    def shown(self) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]]:
        """Depth (h, w), points and normals (h, w, 3), the caller's; read only, as what is NaN is not written again."""
        h, w = self.depth.shape
        # Every view that will be made of such an array holds it, so it lives as long as any of them; a view of ours
        # would not do: views of it hold our memory in its stead.
        depth, points, normals = (_lent(image) for image in (self.depth, self.points, self.normals))
        self.given[:] = [ref(image) for image in (depth, points, normals)]
        return depth.reshape(h, w), points.reshape(h, w, 3), normals.reshape(h, w, 3)

    def held(self) -> bool:
        """Whether anyone still holds an image that was handed out, or a view of one."""
        return any(image() is not None for image in self.given)


class ImagePool:
    """Of one volume: what was handed out, or is free again."""

    def __init__(self) -> None:
        self._kept: list[PooledImages] = []

    def take(self, h: int, w: int) -> PooledImages:
        """Images of h rows and w columns, in nobody else's hands; it is kept when it is given back."""
        for n, images in enumerate(self._kept):
            if images.depth.shape == (h, w) and not images.held():
                return self._kept.pop(n)
        depth, points, normals = (np.empty(shape, np.float32) for shape in ((h, w), h * w * 3, h * w * 3))
        return PooledImages(depth, points, normals, np.ones(h * -(-w // PIECE), np.int32))

    def give_back(self, images: PooledImages) -> None:
        """It may be taken again once its images were let go."""
        self._kept.append(images)
        del self._kept[:-MOST]


def _lent(image: NDArray[np.float32]) -> NDArray[np.float32]:
    """The same memory, flat and read only, as an array that views of it refer to."""
    return np.frombuffer(image.data.toreadonly(), np.float32)
