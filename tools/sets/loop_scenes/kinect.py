"""What a structured-light camera makes of true depth, and its colour camera of true colours.

Nguyen, Izadi and Lovell 2012 (3DIMPVT), equations 4 and 5: axial noise over depth and angle, lateral noise. Khoshelham
and Elberink 2012 (Sensors 12): disparities come in steps of an eighth of a pixel, so depth in steps that grow with its
square. Both for the Kinect's 640 x 480 at 575 to 585 px; a smaller image of the same field has the noise of the large
one, as if rows and columns were left out. A file holds millimetres.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter, maximum_filter, minimum_filter

from tools.sets.loop_scenes.place.prints import Array, Rng
from tools.sets.loop_scenes.place.scenery import Lens, View

BASELINE = 0.075  # [m] between projector and camera (Khoshelham and Elberink, table 1)
FULL = 640  # [px] the width that the published figures are of
STEP = 0.125  # [px] of disparity
NEAREST, FARTHEST = 0.45, 6.0  # [m]
GRAZING = np.deg2rad(80)  # beyond it no dots are found (Nguyen measured up to 80 deg)
JUMP = 0.04  # [m at 1 m] between neighbours: an edge
MATCHED = 1.2  # [px] over which neighbours share their noise: the matching window (guess)


@dataclass(frozen=True)
class Kinect:
    """Depth and colour of one lens, as a driver registers them."""

    lens: Lens

    @property
    def camera(self) -> dict[str, object]:
        """camera.json."""
        cx, cy = self.lens.centre
        one: dict[str, object] = {"width": self.lens.width, "height": self.lens.height}
        one |= {"fx": self.lens.f, "fy": self.lens.f, "cx": cx, "cy": cy, "distortion": [0.0] * 5}
        color = one | {"T_color_depth": np.eye(4).tolist()}
        return one | {"depth_scale": 1000, "principle": "structured_light", "sensor": "Kinect v1", "color": color}

    def depth(self, view: View, swept: Array, rng: Rng) -> Array:
        """(h, w) [m], 0 where there is none; `swept` (2,) [rad]: how far the picture moved while it was taken."""
        h, w = view.z.shape
        z, angle, gone = self._looked_at(view, rng)
        sharp = FULL / w
        with np.errstate(invalid="ignore", divide="ignore"):
            tilt = np.clip(angle, 0, GRAZING)
            sigma = 0.0012 + 0.0019 * (z - 0.4) ** 2 + 0.0001 / np.sqrt(z) * (tilt / (np.pi / 2 - tilt)) ** 2
            near = z + np.where(np.isfinite(z), sigma, 0) * self._grain((h, w), rng)
            steps = sharp * self.lens.f * BASELINE / near / STEP
            out = sharp * self.lens.f * BASELINE / (np.rint(steps) * STEP)
        gone |= ~np.isfinite(z) | (angle > GRAZING) | shaded(view.z, self.lens.f * BASELINE)
        gone |= edges(view.z) & (rng.random((h, w)) < 0.5)
        gone |= view.dark & (rng.random((h, w)) < 0.9)
        blurred = float(np.hypot(*swept)) * self.lens.f * sharp
        gone |= self._grain((h, w), rng, 3.0) > 3.5 - 0.15 * blurred  # smeared dots are not found, in patches (guess)
        return np.where(gone | (out < NEAREST) | (out > FARTHEST), 0.0, np.rint(out * 1000) / 1000)

    def picture(self, view: View, swept: Array, rng: Rng) -> NDArray[np.uint8]:
        """(h, w, 3), red first: smeared by motion, with noise."""
        blurred = cv2.GaussianBlur(view.colour, (0, 0), 0.6)
        length = float(np.hypot(*swept)) * self.lens.f
        if length > 1:
            blurred = cv2.filter2D(blurred, -1, line(swept * self.lens.f))
        return np.clip(blurred + 3.0 * rng.standard_normal(blurred.shape), 0, 255).astype(np.uint8)

    def nothing(self, rng: Rng) -> NDArray[np.uint8]:
        """A picture in which all is smeared away."""
        return np.clip(90 + 4 * rng.standard_normal((self.lens.height, self.lens.width, 3)), 0, 255).astype(np.uint8)

    def _looked_at(self, view: View, rng: Rng) -> tuple[Array, Array, NDArray[np.bool_]]:
        """Depth and angle where each pixel really looks: beside itself by Nguyen's lateral noise."""
        h, w = view.z.shape
        v, u = np.mgrid[:h, :w]
        tilt = np.clip(view.incidence, 0, GRAZING)
        spread = (0.8 + 0.035 * tilt / (np.pi / 2 - tilt)) * w / FULL
        dv, du = np.rint(spread * rng.standard_normal((2, h, w))).astype(int)
        at = (v + dv).clip(0, h - 1), (u + du).clip(0, w - 1)
        # on one surface the noise along the axis holds it all: only at edges does it matter what is beside
        edge = maximum_filter(edges(view.z), 3)
        z, angle = np.where(edge, view.z[at], view.z), np.where(edge, view.incidence[at], view.incidence)
        return z, angle, edge & ~np.isfinite(view.z[at])

    def _grain(self, shape: tuple[int, int], rng: Rng, wide: float = MATCHED) -> Array:
        """Noise of spread 1 that neighbours share."""
        size = wide * shape[1] / FULL
        smooth = gaussian_filter(rng.standard_normal(shape), size) if size > 0.3 else rng.standard_normal(shape)
        return np.asarray(smooth / smooth.std())


def edges(z: Array) -> NDArray[np.bool_]:
    """Where neighbours lie far behind one another."""
    filled = np.where(np.isfinite(z), z, 20.0)
    low, high = minimum_filter(filled, 3), maximum_filter(filled, 3)
    with np.errstate(invalid="ignore"):
        bent = np.abs(high + low - 2 * filled)  # 0 on a plane, however steep
    return np.asarray((high - low > JUMP * filled) & (bent > 0.5 * JUMP * filled))


def shaded(z: Array, fb: float) -> NDArray[np.bool_]:
    """What the projector, `fb` [px m] to the right, does not light: a nearer surface stands before it."""
    with np.errstate(divide="ignore"):
        column = np.arange(z.shape[1]) - fb / z
    first = np.minimum.accumulate(column[:, ::-1], axis=1)[:, ::-1]
    return np.asarray(column > first + 0.5)


def line(way: Array) -> Array:
    """A kernel that smears along `way` (2,) [px]."""
    half = int(np.ceil(np.abs(way).max() / 2))
    kernel = np.zeros((2 * half + 1, 2 * half + 1), np.float32)
    for s in np.linspace(-0.5, 0.5, 8 * half + 1):
        x, y = np.rint(half + s * way).astype(int)
        kernel[y, x] += 1
    return np.asarray(kernel / kernel.sum())
