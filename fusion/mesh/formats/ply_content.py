"""What is taken from the body of a PLY file."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from fusion.mesh.formats.ply_header import Element, Property

INDICES = ("vertex_indices", "vertex_index")


@dataclass
class Content:
    """Columns (n,) of the vertices by name, and the faces' corners in groups (k, corners) of equal length."""

    vertex: dict[str, NDArray] = field(default_factory=dict)
    faces: list[NDArray[np.integer]] = field(default_factory=list)


def _index_list(element: Element) -> Property | None:
    """The property that holds the corners of faces: by its name, else the only list."""
    lists = [one for one in element.properties if one.length]
    named = [one for one in lists if one.name in INDICES]
    return (named or lists)[0] if len(named or lists) == 1 else None


def wanted_list(element: Element) -> Property | None:
    """The list that is needed of an element; ValueError where faces have none."""
    if element.name != "face" or not element.count:
        return None
    index = _index_list(element)
    if index is None or index.type[0] == "f" or index.length[0] == "f":
        raise ValueError("faces without a list of whole numbers vertex_indices")
    return index
