"""What the view needs is compiled before the first frame comes: it takes as long as some seventy frames do."""

import numpy as np

from fusion.devices.source import SourceFrame
from fusion.geometry.camera import Camera
from fusion.live.grow import Grower
from fusion.live.looking import SURE
from fusion.turntable.views import Region

DISTANCE, SIZE = 0.7, 0.2  # [m] of a ball that nobody sees


def get_ready(camera: Camera) -> None:
    """Let a view of its own take two frames of a ball before this camera, and show what it made."""
    grower = Grower(camera)
    middle = np.array([0.0, 0.0, DISTANCE])
    grower.looking.region, grower.looking.finds = Region(middle - SIZE, middle + SIZE), SURE
    v, u = np.mgrid[: camera.height, : camera.width]
    across, down = (u - camera.width / 2) * DISTANCE / camera.fx, (v - camera.height / 2) * DISTANCE / camera.fy
    height = SIZE**2 / 4 - across**2 - down**2
    depth = np.where(height > 0, DISTANCE - np.sqrt(np.maximum(height, 0)), np.nan).astype(np.float32)
    for index in range(2):
        grower.take(SourceFrame(index, index / 30, depth))
    grower.surface()
