"""Where a surface is open: its holes, how large they are and which way they look."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.pose import Array
from fusion.mesh.cleanup import border_loops
from fusion.mesh.mesh import Mesh

STEEP = 0.7  # cosine of 45 degrees: what looks more steeply up or down than sideways is top or bottom
BASE = 0.1  # share of the height, from below, in which at least half of the border of the open base lies (guess): the
# rest may run up a slit that no camera looked into


@dataclass(frozen=True)
class Hole:
    """One closed border, as if a fan of triangles around its centre closed it."""

    perimeter: float  # [m]
    area: float  # of the fan [m^2]
    volume: float  # signed volume of the cone from the origin over the fan [m^3]
    centre: tuple[float, float, float]  # (3,) mean of its corners [m]
    # (3,) unit vector out of the body through the hole; zeros for a border without an area
    outwards: tuple[float, float, float]
    where: str  # "bottom", "top" or "side"


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
    where = _where(_at_base(mesh, here, first, whole, up), outwards @ up)
    order = np.argsort(-perimeter, kind="stable")
    return tuple(
        Hole(
            float(perimeter[k]), float(area[k]), float(volume[k]), tuple(centre[k].tolist()),
            tuple(outwards[k].tolist()), where[k],
        )
        for k in order
    )  # fmt: skip


def _at_base(mesh: Mesh, here: Array, first: NDArray[np.intp], whole: Array, up: Array) -> Array:
    """Share (n,) of the border corners (m, 3) of each hole that lie at the base of the mesh.

    What looks down says where down is: an object may stand on a plate that is not square to `up`.
    """
    steep = whole @ up < -STEEP * np.linalg.norm(whole, axis=1)
    down = whole[steep].sum(axis=0)
    size = float(np.linalg.norm(down))
    upright = -down / size if size > 0 else up
    heights = mesh.vertices[np.unique(mesh.faces)] @ upright
    low = here @ upright <= heights.min() + BASE * np.ptp(heights)
    return np.asarray(np.add.reduceat(low, first, dtype=float) / np.diff(first, append=len(here)))


def _where(low: Array, steepness: Array) -> NDArray[np.str_]:
    """Side (n,) of holes of whose border a share lies at the base, and that look out with a cosine to upright."""
    names = np.where(steepness > STEEP, "top", "side")
    return np.where((steepness < -STEEP) & (low >= 0.5), "bottom", names)
