"""What is known of what one colour image looked at."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Camera
from fusion.geometry.pose import Array


@dataclass(frozen=True)
class SeenByImage:
    """What is known of what one colour image looked at.

    Attributes:
        camera: took the image.
        coarse: the same, halved some times: what stands in the way is judged in its pixels.
        T_world_camera: (4, 4).
        measured: (h, w) depth of the coarse pixels [m], NaN where none was measured.
    """

    camera: Camera
    coarse: Camera
    T_world_camera: Array
    measured: NDArray[np.float32]
