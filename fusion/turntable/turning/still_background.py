"""Which parts of the background do not turn with the object, told by the axis: turned, they would stand in the way.

A plate and a round foot stand still in every image and turn all the same. A wall that reaches into the circle of the
object does not: at some angle it would lie before what the camera saw.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Camera
from fusion.turntable.axis import Axis

Array = NDArray[np.float64]
TURNS = 12  # looked at: a wall within the circle comes to its front in several of them
CLEAR = 0.01  # [m] nearer than what was seen: a tilted axis and a bent camera move a plate by less
OFTEN = 3  # turns in which it is so: two may fall on the rims
RIM = 3  # [px]


def standing(wall: NDArray[np.float32], camera: Camera, axis: Axis, radius: float) -> NDArray[np.bool_]:
    """(h, w) bool: pixels whose background is no part of what turns.

    Args:
        wall: (h, w) depth from which on a pixel shows the background [m], NaN where none is known.
        camera: of that image.
        axis: that the object turns about.
        radius: of what turns [m]: farther off nothing is asked, nor fused.
    """
    points = camera.points(wall).reshape(-1, 3).astype(float)
    asked = np.flatnonzero(np.isfinite(points[:, 2]))
    asked = asked[axis.distance(points[asked])[0] < radius]
    # turned to the rim of what is round, a point may fall beside it
    around = np.nan_to_num(wall, nan=np.inf).astype(np.float32)
    nearest = cv2.erode(around, np.ones((2 * RIM + 1, 2 * RIM + 1), np.uint8))
    before = np.zeros(len(asked), int)
    for angle in np.arange(1, TURNS) * 2 * np.pi / TURNS:
        T = axis.turn(float(angle))
        turned = points[asked] @ T[:3, :3].T + T[:3, 3]
        u, v = np.rint(np.clip(camera.project(turned), -9, 99999)).astype(int).T
        seen = (turned[:, 2] > 0.05) & (u >= 0) & (u < camera.width) & (v >= 0) & (v < camera.height)
        behind = np.zeros(len(asked))
        behind[seen] = nearest[v[seen], u[seen]]
        before += (turned[:, 2] < behind - CLEAR) & np.isfinite(behind)
    found = np.zeros(wall.size, bool)
    found[asked[before >= OFTEN]] = True
    return found.reshape(wall.shape)
