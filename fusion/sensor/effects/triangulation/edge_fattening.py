"""Edge fattening: the matching window sees the near thing before its middle reaches it, so near things grow."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from fusion.geometry.camera import TRIANGULATING, Principle
from fusion.sensor.effect import Effect
from fusion.sensor.parameter import Value, parameter
from fusion.sensor.view import Image, View


@dataclass(frozen=True)
class EdgeFattening(Effect):
    """Background closer than half a window to a nearer surface takes the depth of that surface."""

    name: ClassVar[str] = "edge_fattening"
    key: ClassVar[str] = "S2, S3"
    formula: ClassVar[str] = (
        "z_measured = z + clip(window_px / 2 - e + 0.5, 0, 1) (z_near - z), e = distance to the near thing [px]"
    )
    variables: ClassVar[tuple[str, ...]] = ("edge",)
    principles: ClassVar[tuple[Principle, ...]] = TRIANGULATING
    not_corrected: ClassVar[str] = "what the near thing hides of the background is not in the image"

    window_px: Value = parameter(
        "px", (0, 50), "width of the matching window", "9 x 9 px: github ankurhanda/simkinect", typical=5.0
    )

    def bias(self, depth: Image, view: View) -> Image:
        if view.edges is None or not np.any(self.window_px):
            return np.zeros((), depth.dtype)
        window = np.asarray(self.window_px, depth.dtype)
        # softened over one pixel; a window below one pixel never covers its neighbour fully
        reach = (window / 2 + 0.5 - view.edges.distance).astype(depth.dtype)
        share = np.clip(np.nan_to_num(reach, nan=0.0, neginf=0.0), 0, np.minimum(window, 1))
        return share * np.minimum(np.nan_to_num(view.edges.jump), 0).astype(depth.dtype)
