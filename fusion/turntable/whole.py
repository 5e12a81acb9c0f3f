"""Which pixels of a frame a model of the object may meet: those along the rims, too."""

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.depth import PointMap
from fusion.turntable.views import STEEP, Region, before_wall, overlaid


def whole(depth: NDArray[np.float32], surface: PointMap, region: Region) -> NDArray[np.bool_]:
    """(h, w) pixels that a model of the object may meet: on the object, and not beside a step or hole themselves.

    The model has normals of its own, so a pixel needs none. Those that have none, two or three deep along the rim, see
    the surface turn away, where a turn changes their depth most: on a statue 35 pixels across they hold two thirds of
    what all tell of the angles (0.145 deg at best without, 0.083 with; tools/sets/fresh/angles.py, seed 446, unit 16).

    Args:
        depth: (h, w) [m] of what may be the object, NaN elsewhere.
        surface: all that the frame shows, in the window of the region.
        region: as of `usable`.
    """
    limit = STEEP / surface.camera.fx * depth + 3 * surface.sigma
    known = before_wall(surface, region) & np.isfinite(depth) & ~overlaid(surface)
    for axis in (0, 1):
        for way in (-1, 1):  # of NaN no comparison is true; what comes round the image's edge is no neighbour
            known &= np.abs(np.roll(depth, way, axis) - depth) < limit
    known[[0, -1]] = known[:, [0, -1]] = False
    return known if region.still is None else known & ~region.still
