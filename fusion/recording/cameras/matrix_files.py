"""Camera files of other programs that hold a matrix: Open3D's `PinholeCameraIntrinsic`, and `K` with a resolution."""

from typing import Annotated

import numpy as np
from msgspec import Meta, Struct
from numpy.typing import NDArray

from fusion.files.content import Content
from fusion.geometry.camera import Camera
from fusion.recording.native.camera_file import DepthScale, Size, camera_of_matrix

# Open3D's depth_scale in the reconstruction system: millimetres
DEPTH_SCALE = 1000.0

Number = Annotated[float, Meta(gt=-1e6, lt=1e6)]
Numbers = list[Number | list[Number]]
BOUNDS = "[px], focal lengths from 0.01 to 1e6"


class Intrinsic(Struct, frozen=True, kw_only=True):
    """Open3D's camera; the depth's unit beside it is this program's own, Open3D is told it elsewhere."""

    width: Size
    height: Size
    intrinsic_matrix: Annotated[Numbers, Meta(description=f"9 numbers, column by column {BOUNDS}")]
    depth_scale: DepthScale = DEPTH_SCALE


class Resolved(Struct, frozen=True, kw_only=True):
    """A matrix as it is written on paper, and the sides of the images in either order."""

    K: Annotated[Numbers, Meta(description=f"9 numbers, row by row {BOUNDS}")]
    resolution: tuple[Size, Size]
    depth_scale: DepthScale = DEPTH_SCALE


def camera_of_others(content: Content) -> Camera:
    """The camera of such a file's content. Raises the content's kind of error."""
    if isinstance(content.value, dict) and "K" in content.value:
        return _of_resolved(content)
    given = content.as_type(Intrinsic)
    # row by row, as others write it, the last row holds the principal point
    K = _square(given.intrinsic_matrix).T
    found = camera_of_matrix(K, (int(given.width), int(given.height)), given.depth_scale)
    if found is None:
        raise content.wrong(Intrinsic, "intrinsic_matrix")
    return found


def _of_resolved(content: Content) -> Camera:
    given = content.as_type(Resolved)
    K = _square(given.K)
    one, other = (int(side) for side in given.resolution)
    # lenses look through the middle of their images
    size = min(((one, other), (other, one)), key=lambda s: abs(K[0, 2] - s[0] / 2) + abs(K[1, 2] - s[1] / 2))
    found = camera_of_matrix(K, size, given.depth_scale)
    if found is None:
        raise content.wrong(Resolved, "K")
    return found


def _square(numbers: Numbers) -> NDArray[np.float64]:
    try:
        return np.array(numbers, float).reshape(3, 3)
    except ValueError:  # not nine, or lists of different lengths
        return np.zeros((3, 3))
