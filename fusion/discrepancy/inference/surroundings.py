"""Surroundings: depth is predicted in the middle of a pixel, and measured as a mean about it.

A pixel sees an area, and what filters each frame takes more of the neighbours, which end at the border of the image. On
a plane seen frontally that is the same; at a crease, on a ball and far out on a tilted plane it is not. Where an image
has few pixels the mean over the area is predicted already, and this is what a sensor may weigh otherwise.
"""

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.observe.frames import filter_window
from fusion.discrepancy.observe.observations import Observations
from fusion.discrepancy.observe.patch import Patch
from fusion.sensor.view import Image

AREA = 1.0 / 12.0  # [px^2] mean square of the distance to the middle of a pixel, along a side


def surroundings_columns(observations: Observations) -> NDArray[np.float64]:
    """(n, 2) by how much a mean over a pixel's area and one over a filter's window differ from the middle, in native
    units."""
    # one that keeps edges shows in the noise along a surface, and not down a steep one
    window = max(filter_window(patch.alike) for patch in observations.patches)
    window = window if window > AREA else 0.0  # narrower than the pixel itself it is no filter, and neighbours' chance
    return np.concatenate([np.column_stack(_columns(patch, window)) for patch in observations.patches])


def _columns(patch: Patch, window: float) -> list[NDArray[np.float64]]:
    depth = np.asarray(patch.depth, float)
    # a pixel at the border sees on, a filter has nothing more
    on, ends = np.pad(depth, 1, "reflect", reflect_type="odd"), np.pad(depth, 1, "edge")
    return [patch.tiles.mean(bent * patch.native) for bent in (AREA * _bent(on), window * _bent(ends))]


def _bent(depth: Image) -> Image:
    """(h, w) [m] mean about each pixel less its middle, of a window of a square pixel; over a crease the sum is exact.

    Args:
        depth: (h + 2, w + 2) [m] with what stands around it.
    """
    return 0.5 * (np.diff(depth, 2, axis=1)[1:-1] + np.diff(depth, 2, axis=0)[:, 1:-1])
