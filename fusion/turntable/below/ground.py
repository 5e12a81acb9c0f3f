"""The level surface below the object as seen from above, in every frame the same square of it."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Camera
from fusion.recording.ahead import ahead
from fusion.turntable.axis import Axis
from fusion.turntable.tones import contrast

Array = NDArray[np.float64]
Image = NDArray[np.float32]
WIDEST = 420  # [px] of a view from above: seconds of work for more, and no better angle (guess)
REACH = 3.0  # half of a side, in what the object reaches from its middle (guess)
LEVEL = 0.008  # of its distance to the camera: so far off the ground is still ground, which cameras bend (guess)
BORDER = 2  # [px] around what stands before the ground, whose colour may be its own


@dataclass(frozen=True)
class Ground:
    """A square of the level surface below the object."""

    upright: Axis  # its point the middle of the square, its direction out of it
    half: float  # half of a side [m]
    side: int  # [px]

    @property
    def pitch(self) -> float:
        """Side of a pixel [m]."""
        return 2 * self.half / self.side

    def seen(self, camera: Camera, depths: NDArray[np.float32], colors: NDArray[np.uint8]) -> NDArray[np.float32]:
        """(k, side, side) contrast of what frames show of the square; NaN where that is hidden or unknown.

        Columns go along `across()[0]` of the upright, rows along the other.

        Args:
            camera: of the frames.
            depths: (k, h, w) [m].
            colors: (k, h, w, 3) of the same pixels, black where unknown.
        """
        at = (np.arange(self.side) + 0.5) * self.pitch - self.half
        (first, second), middle, normal = self.upright.across(), self.upright.point, self.upright.direction
        places = middle + at[None, :, None] * first + at[:, None, None] * second
        u, v = camera.project(places.reshape(-1, 3)).T.reshape(2, self.side, self.side).astype(np.float32)
        rays = camera.rays()
        rising, limit = rays @ normal[:2] + normal[2], LEVEL * float(np.linalg.norm(middle))
        square = np.ones((2 * BORDER + 1, 2 * BORDER + 1), np.uint8)

        def view(k: int) -> Image:
            depth, color = depths[k], colors[k]
            with np.errstate(invalid="ignore"):
                level = np.abs(depth * rising - float(middle @ normal)) < limit
            level = cv2.morphologyEx(level.astype(np.uint8), cv2.MORPH_CLOSE, square)
            shown = np.asarray(cv2.remap(color, u, v, cv2.INTER_LINEAR), np.uint8)
            there = cv2.remap(level, u, v, cv2.INTER_NEAREST) * (shown.max(axis=2) > 0)
            return contrast(shown, cv2.erode(there, square) > 0)

        views = [seen() for seen in ahead(view, range(len(depths)))]
        return np.stack(views) if views else np.zeros((0, self.side, self.side), np.float32)


def ground_below(foot: tuple[Array, Array], points: Array, camera: Camera) -> Ground:
    """The square around the foot of the object.

    Args:
        foot: a point (3,) and the upward unit normal (3,) of what it stands on [m].
        points: (n, 3) of the object in all views [m].
        camera: that sees it.
    """
    a, normal = foot
    under = points - ((points - a) @ normal)[:, None] * normal
    middle = np.median(under, axis=0)
    half = REACH * float(np.percentile(np.linalg.norm(under - middle, axis=1), 95))
    return Ground(Axis(middle, normal), half, int(np.clip(2 * half * camera.fx / middle[2], 16, WIDEST)))
