"""What kinds of mesh files mean by their numbers: STL is millimetres to slicers and CAD, glTF has its y axis up."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fusion.mesh.alignment.units import UNITS, times
from fusion.mesh.mesh import Mesh

STL_UNIT = "mm"
# z up to y up: what looked along y looks along -z (glTF 2.0, section 3.4)
Y_UP = (".glb", ".gltf", ".usdz")  # USDZ says its axis, this one
_Y_UP = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])


def for_file(mesh: Mesh, ending: str, unit: str = STL_UNIT) -> Mesh:
    """A mesh [m], z up, as a file of that ending holds it.

    Args:
        ending: such as ".stl".
        unit: of STL, which says none, one of `UNITS`.
    """
    return _turned(mesh, _Y_UP) if ending in Y_UP else times(mesh, 1 / _unit(ending, unit))


def from_file(mesh: Mesh, ending: str, unit: str = STL_UNIT) -> Mesh:
    """The mesh in metres, z up, that a file of that ending holds; arguments as of `for_file`."""
    return _turned(mesh, _Y_UP.T) if ending in Y_UP else times(mesh, _unit(ending, unit))


def _unit(ending: str, unit: str) -> float:
    return UNITS[unit] if ending == ".stl" else 1.0


def _turned(mesh: Mesh, rotation: NDArray[np.float64]) -> Mesh:
    normals = None if mesh.normals is None else np.asarray(mesh.normals @ rotation.T, np.float32)
    return replace(mesh, vertices=mesh.vertices @ rotation.T, normals=normals)
