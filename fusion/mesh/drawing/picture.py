"""A mesh as a small picture: from the front and from behind, both a little from above."""

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from fusion.geometry.pose import Array
from fusion.mesh.drawing.shading import CLAY, lit, picture, vertex_normals
from fusion.mesh.drawing.sight import SightSide, look, sides
from fusion.mesh.mesh import Mesh

PIXELS = 360  # of the mesh's longest edge
RISE = np.deg2rad(20)  # of the eye above the horizon
GAP = 20  # between the views [px]


def png(mesh: Mesh, up: ArrayLike = (0, 0, 1), front: ArrayLike = (1, 0, 0)) -> bytes | None:
    """A PNG with transparent background; None where there is nothing to see.

    Args:
        mesh: shown in its colours, else as clay.
        up: (3,) that points up in the picture.
        front: (3,) from the object to the eye of the first view.
    """
    level = sides(np.asarray(up, float), np.asarray(front, float))
    views = [shaded(mesh, raised(side), PIXELS) for side in (level[0], level[2])]
    if not any(view[..., 3].any() for view in views):
        return None
    height = max(len(view) for view in views)
    gap = np.zeros((height, GAP, 4), np.uint8)
    # all stand on the ground
    views = [np.pad(view, ((height - len(view), 0), (0, 0), (0, 0))) for view in views]
    return bytes(cv2.imencode(".png", np.hstack([views[0], gap, views[1]])[..., [2, 1, 0, 3]])[1])


def shaded(mesh: Mesh, side: SightSide, pixels: int) -> NDArray[np.uint8]:
    """RGBA (h, w, 4) from one side; `pixels` along the mesh's longest edge."""
    known = mesh.vertices[np.isfinite(mesh.vertices).all(axis=1)]
    longest = float(np.ptp(known, axis=0).max()) if len(known) else 1.0
    colors = np.broadcast_to(CLAY, mesh.vertices.shape) if mesh.colors is None else mesh.colors / 255
    # two looked-at pixels for each of the picture
    return picture(lit(look(mesh, side, longest / (2 * pixels)), vertex_normals(mesh)), colors)


def raised(side: SightSide) -> SightSide:
    """The same side, seen from above by RISE."""
    towards: Array = np.cos(RISE) * side.towards + np.sin(RISE) * side.up
    return SightSide(side.name, towards, np.cos(RISE) * side.up - np.sin(RISE) * side.towards)
