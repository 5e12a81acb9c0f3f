"""Where a surface is open: its holes, how large they are and which way they look."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.pose import Array
from fusion.mesh.cleanup import border_loops
from fusion.mesh.mesh import Mesh

STEEP = 0.7  # cosine of 45 degrees: what looks more steeply up or down than sideways is top or bottom
BASE = 0.1  # share of the height, from below, in which a hole that looks down is the open base (guess)


@dataclass(frozen=True)
class Hole:
    """One closed border, as if a fan of triangles around its centre closed it.

    Attributes:
        perimeter: [m].
        area: of the fan [m^2].
        volume: signed volume of the cone from the origin over the fan [m^3].
        centre: (3,) mean of its corners [m].
        outwards: (3,) unit vector out of the body through the hole; zeros for a border without an area.
        where: "bottom", "top" or "side".
    """

    perimeter: float
    area: float
    volume: float
    centre: tuple[float, float, float]
    outwards: tuple[float, float, float]
    where: str


def holes(mesh: Mesh, up: Array) -> tuple[Hole, ...]:
    """All holes of a mesh, the longest border first; `up` (3,) is a unit vector."""
    loops = border_loops(mesh)
    if not loops:
        return ()
    lengths = np.array([len(loop) for loop in loops])
    first = np.cumsum(lengths) - lengths
    here = mesh.vertices[np.concatenate(loops)]
    index = np.arange(len(here))
    index[:-1] += 1
    index[first + lengths - 1] = first
    there = here[index]
    centre = np.add.reduceat(here, first) / lengths[:, None]
    middle = np.repeat(centre, lengths, axis=0)
    # against the border's direction, so that the fan looks out of the body
    fan = 0.5 * np.cross(there - middle, here - middle)
    area = np.add.reduceat(np.linalg.norm(fan, axis=1), first)
    volume = np.add.reduceat(np.einsum("ij,ij->i", middle, fan) / 3, first)
    perimeter = np.add.reduceat(np.linalg.norm(there - here, axis=1), first)
    whole = np.add.reduceat(fan, first)
    outwards = whole / np.maximum(np.linalg.norm(whole, axis=1, keepdims=True), 1e-300)
    where = _where(mesh, centre @ up, outwards @ up, up)
    order = np.argsort(-perimeter, kind="stable")
    return tuple(
        Hole(
            float(perimeter[k]), float(area[k]), float(volume[k]), tuple(centre[k].tolist()),
            tuple(outwards[k].tolist()), where[k],
        )
        for k in order
    )  # fmt: skip


def _where(mesh: Mesh, height: Array, steepness: Array, up: Array) -> NDArray[np.str_]:
    """Side (n,) of holes at a height [m] along `up` that look out with a cosine to it."""
    heights = mesh.vertices[np.unique(mesh.faces)] @ up
    base = heights.min() + BASE * np.ptp(heights)
    names = np.where(steepness > STEEP, "top", "side")
    return np.where((steepness < -STEEP) & (height <= base), "bottom", names)
