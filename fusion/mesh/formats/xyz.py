"""XYZ: text with a point a line."""

import numpy as np

from fusion.files.reading import decoded
from fusion.mesh.formats.rows import filled, table
from fusion.mesh.mesh import Mesh


def read_xyz(data: bytes) -> Mesh:
    """Text with `x y z` per line, and perhaps three more: a normal, or a colour of 0-255; `#` and `//` comment."""
    text = decoded(data).replace(",", " ").replace(";", " ").replace("//", "#")
    values = table(filled(text, "#"))
    if values.shape[1] < 3:
        raise ValueError(f"{values.shape[1]} columns")
    more = values[:, 3:6]
    normals = colors = None
    if more.shape[1] == 3:
        with np.errstate(over="ignore"):
            lengths = np.linalg.norm(more, axis=1)
        if np.abs(lengths - 1).max(initial=0) < 0.01:
            normals = more.astype(np.float32)
        elif (more == np.rint(more)).all() and (more >= 0).all() and (more <= 255).all():
            colors = more.astype(np.uint8)
    return Mesh(vertices=values[:, :3], normals=normals, colors=colors)
