"""How far the table has turned, from poses of the camera about the object."""

import numpy as np
from scipy.spatial.transform import Rotation

from fusion.geometry.pose import Array
from fusion.live.state import SECTORS

SURE = np.deg2rad(3.0)  # a turn from which on its direction tells the axis (guess: ten times what noise turns)


class Turned:
    """Adds up turns about one axis.

    Attributes:
        angle: [rad] since the first pose, with a sign.
        seen: (36,) sectors of the turn in which a frame was placed.
    """

    def __init__(self) -> None:
        self.angle = 0.0
        self.seen = np.zeros(SECTORS, bool)
        self._first: Array | None = None
        self._last: Array | None = None
        self._axis: Array | None = None
        self._at: list[float] = []

    def placed(self, T_object_camera: Array) -> None:
        """A frame's pose (4, 4)."""
        R = T_object_camera[:3, :3]
        if self._first is None or self._last is None:
            self._first = self._last = R
        if self._axis is None:
            whole = Rotation.from_matrix(R @ self._first.T).as_rotvec()
            size = float(np.linalg.norm(whole))
            self._axis = whole / size if size > SURE else None
            self.angle = size
        else:
            self.angle += float(Rotation.from_matrix(R @ self._last.T).as_rotvec() @ self._axis)
        self._last = R
        self.seen[int(np.floor(self.angle / (2 * np.pi) * SECTORS)) % SECTORS] = True
