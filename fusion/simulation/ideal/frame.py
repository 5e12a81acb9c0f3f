"""IdealFrame: what a simulator without a sensor model gives of one moment."""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from fusion.errors import SensorError
from fusion.geometry.camera import Camera
from fusion.sensor.moment import Moment
from fusion.sensor.view import Image

CHANNELS = ("normals", "reflectance", "segmentation", "rows", "columns", "lit")


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
        rows: (h, n w) depth [m] n times as fine along the rows: of a camera with n fx, n w and the principal point
            n cx + n // 2, so that of the n values of each pixel the one at n // 2 is its own. Tells where between two
            pixels an edge runs; with `columns`.
        columns: (n h, w) the same along the columns.
        lit: (h, w) share of each pixel that the sensor's projector or lamp reaches [1], as a renderer's shadow pass
            tells; None: cast along the rows.

    >>> wall = fusion.IdealFrame(np.full((480, 640), 1.5, np.float32), reflectance=0.6)
    """

    depth: Image
    normals: Image | None = None
    reflectance: Image | float | None = None
    segmentation: NDArray[np.integer] | None = None
    moment: Moment = field(default_factory=Moment)
    rounding: float = 0.0
    rows: Image | None = None
    columns: Image | None = None
    lit: Image | None = None

    def __repr__(self) -> str:
        held = [name for name in CHANNELS if getattr(self, name) is not None]
        shape = " x ".join(map(str, np.shape(self.depth)[::-1]))
        return f"<IdealFrame: {shape}; {', '.join(['depth', *held])}>"


def checked(frame: IdealFrame, camera: Camera) -> IdealFrame:
    """The frame with float32 depth, NaN where there is nothing. Raises SensorError: an array does not fit."""
    shapes = dict.fromkeys(("depth", "segmentation", "lit"), camera.shape) | {"normals": (*camera.shape, 3)}
    if np.ndim(frame.reflectance if frame.reflectance is not None else 0.0):
        shapes["reflectance"] = camera.shape
    for name, shape in shapes.items():
        value = getattr(frame, name)
        if value is not None and np.shape(value) != shape:
            expected = f"{shape} (height, width{', 3' * (len(shape) == 3)}), as the camera has"
            raise SensorError(f"the {name} does not fit the camera", found=np.shape(value), expected=expected)
    for name in ("reflectance", "lit"):
        value = getattr(frame, name)
        # NaN: not known there
        low, high = (0, 0) if value is None else (np.nanmin(value, initial=0.0), np.nanmax(value, initial=0.0))
        if low < 0 or high > 1:
            raise SensorError(f"a {name} cannot be used", found=f"{low:g} to {high:g}", expected="0 to 1")
    _check_finer(frame, camera)
    rows, columns = (None if image is None else _seen(image) for image in (frame.rows, frame.columns))
    return replace(frame, depth=_seen(frame.depth), rows=rows, columns=columns)


def _seen(depth: Image) -> Image:
    depth = np.ascontiguousarray(depth, np.float32)
    with np.errstate(invalid="ignore"):
        seen = (depth > 0) & (depth < np.inf)
    return depth if seen.all() else np.where(seen, depth, np.float32(np.nan))


def _check_finer(frame: IdealFrame, camera: Camera) -> None:
    """Depth between the pixels is there for both axes, as many times as fine along each."""
    if (frame.rows is None) != (frame.columns is None):
        raise SensorError("rows and columns belong together", found="one of both", expected="both or none")
    if frame.rows is None or frame.columns is None:
        return
    n = np.shape(frame.rows)[-1] // camera.width
    expected = f"{camera.shape} (height, width) with n times the width, and n times the height"
    if n < 2 or np.shape(frame.rows) != (camera.height, n * camera.width):
        raise SensorError("the rows do not fit the camera", found=np.shape(frame.rows), expected=expected)
    if np.shape(frame.columns) != (n * camera.height, camera.width):
        raise SensorError("the columns do not fit the rows", found=np.shape(frame.columns), expected=expected)
