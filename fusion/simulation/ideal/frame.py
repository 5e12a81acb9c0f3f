"""IdealFrame: what a simulator without a sensor model gives of one moment."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from fusion.errors import SensorError
from fusion.geometry.camera import Camera
from fusion.sensor.moment import Moment
from fusion.sensor.view import Image


@dataclass(frozen=True)
class IdealFrame:
    """Perfect depth, and what else is known of the surfaces.

    Attributes:
        depth: (h, w) planar z [m]; NaN, 0, negative or infinite where there is nothing.
        normals: (h, w, 3) in the camera frame, of any length and on either side; None: from the depth.
        reflectance: (h, w) or one for all, in the sensor's light [1]; None: not known.
        segmentation: (h, w) whole numbers, another one for each thing: small steps of the depth between two of them
            are edges.
        moment: time [s], temperature, ambient light, table angle.
        rounding: step [m] to which the depth was rounded on its way, 0 where it was not.

    >>> wall = fusion.IdealFrame(np.full((480, 640), 1.5, np.float32), reflectance=0.6)
    """

    depth: Image
    normals: Image | None = None
    reflectance: Image | float | None = None
    segmentation: NDArray[np.integer] | None = None
    moment: Moment = field(default_factory=Moment)
    rounding: float = 0.0

    def __repr__(self) -> str:
        held = [name for name in ("normals", "reflectance", "segmentation") if getattr(self, name) is not None]
        shape = " x ".join(map(str, np.shape(self.depth)[::-1]))
        return f"<IdealFrame: {shape}; {', '.join(['depth', *held])}>"


def checked(frame: IdealFrame, camera: Camera) -> IdealFrame:
    """The frame with float32 depth, NaN where there is nothing. Raises SensorError: an array does not fit."""
    shapes = {"depth": camera.shape, "normals": (*camera.shape, 3), "segmentation": camera.shape}
    if np.ndim(frame.reflectance if frame.reflectance is not None else 0.0):
        shapes["reflectance"] = camera.shape
    for name, shape in shapes.items():
        value = getattr(frame, name)
        if value is not None and np.shape(value) != shape:
            expected = f"{shape} (height, width{', 3' * (len(shape) == 3)}), as the camera has"
            raise SensorError(f"the {name} does not fit the camera", found=np.shape(value), expected=expected)
    if frame.reflectance is not None:
        # NaN: not known there
        low, high = np.nanmin(frame.reflectance, initial=0.0), np.nanmax(frame.reflectance, initial=0.0)
        if low < 0 or high > 1:
            raise SensorError("a reflectance cannot be used", found=f"{low:g} to {high:g}", expected="0 to 1")
    depth = np.ascontiguousarray(frame.depth, np.float32)
    with np.errstate(invalid="ignore"):
        seen = (depth > 0) & (depth < np.inf)
    return IdealFrame(
        depth if seen.all() else np.where(seen, depth, np.float32(np.nan)),
        frame.normals,
        frame.reflectance,
        frame.segmentation,
        frame.moment,
        frame.rounding,
    )
