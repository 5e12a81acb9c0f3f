"""
An effect of your own, in thirty lines
======================================

A cover glass bends under its own weight: behind it the image's middle is measured too near, less and less towards the
rim. The catalogue has no such error. As an effect it is a small frozen class: parameters with unit, bounds, meaning and
source, and what it does to the mean depth (``bias``), to its spread (``noise``) or to whether there is a value
(``dropout``). Simulation, correction and weights then follow from it.
"""

from dataclasses import dataclass
from typing import ClassVar

import matplotlib.pyplot as plt
import numpy as np

import fusion


@dataclass(frozen=True)
class BentGlass(fusion.Effect):
    """The middle of the image is too near by `sag`; the error falls to 0 with the square of the distance from it."""

    name: ClassVar[str] = "bent_glass"
    formula: ClassVar[str] = "z_measured = z - sag max(0, 1 - (radius / reach)^2)"
    variables: ClassVar[tuple[str, ...]] = ("radius",)

    sag: float = fusion.parameter("m", (0, 0.02), "depth that is missing in the middle", "this example", typical=0.004)
    reach: float = fusion.parameter("px", (10, 1000), "where it ends", "this example", neutral=200.0)

    def bias(self, depth: np.ndarray, view: fusion.View) -> np.ndarray:
        """Change of the mean depth (h, w) [m]."""
        left = np.maximum(0, 1 - (view.radius / self.reach) ** 2)
        return (-self.sag * left).astype(depth.dtype)


# %%
# A sensor that has it
# --------------------
# It acts behind the measuring of the distance and before its readout: noise and rounding of the Kinect come after it.

sensor = fusion.read_sensor("kinect-v2-indoors").having(BentGlass(sag=0.004))
camera = fusion.find_camera("kinect-v2")
wall = np.full(camera.shape, 1.0, np.float32)
frames = [fusion.sense(wall, camera, sensor, seed=1, index=i) for i in range(8)]
mean = np.nanmean([frame.depth for frame in frames], axis=0)
sensor

# %%
# A wall at 1 m as this sensor sees it, and what the correction makes of that. The Kinect's own typical errors stay:
# they are not known for this unit, and what is not known is not taken back.

corrected = sensor.correct(mean, camera)
plain = fusion.read_sensor("kinect-v2-indoors").predict(wall, camera)  # without the glass, without noise
figure, axes = plt.subplots(1, 2, figsize=(9, 3.5), sharey=True)
for ax, image, title in zip(axes, (mean, corrected), ("measured", "corrected"), strict=True):
    shown = ax.imshow(1e3 * (image - plain), cmap="RdBu_r", vmin=-5, vmax=5)
    ax.set_title(title)
figure.colorbar(shown, ax=axes, label="error by the glass [mm]")
middle = np.s_[202:222, 246:266]
print(f"middle: {1e3 * np.nanmean((mean - plain)[middle]):+.1f} mm, corrected", end=" ")
print(f"{1e3 * np.nanmean((corrected - plain)[middle]):+.1f} mm")
