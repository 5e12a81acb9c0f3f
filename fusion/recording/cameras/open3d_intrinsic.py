"""Open3D's camera file: width, height and a matrix written column by column (`PinholeCameraIntrinsic`)."""

from typing import Annotated

import numpy as np
from msgspec import Meta, Struct

from fusion.files.content import Content
from fusion.geometry.camera import Camera
from fusion.recording.native.camera_file import DepthScale, Size, camera_of_matrix

# its depth_scale in the reconstruction system: millimetres
DEPTH_SCALE = 1000.0

Number = Annotated[float, Meta(gt=-1e6, lt=1e6)]
ABOUT = "9 numbers, column by column [px], focal lengths from 0.01 to 1e6"


class Intrinsic(Struct, frozen=True, kw_only=True):
    """Open3D's camera; the depth's unit beside it is this program's own, Open3D is told it elsewhere."""

    width: Size
    height: Size
    intrinsic_matrix: Annotated[list[Number | list[Number]], Meta(description=ABOUT)]
    depth_scale: DepthScale = DEPTH_SCALE


def open3d_camera(content: Content) -> Camera:
    """The camera of such a file's content. Raises the content's kind of error."""
    given = content.as_type(Intrinsic)
    try:
        K = np.array(given.intrinsic_matrix, float).reshape(3, 3).T  # column by column
    except ValueError:  # not nine, or lists of different lengths
        K = np.zeros((3, 3))
    # row by row, as others write it, the last row holds the principal point
    found = camera_of_matrix(K, (int(given.width), int(given.height)), given.depth_scale)
    if found is None:
        raise content.wrong(Intrinsic, "intrinsic_matrix")
    return found
