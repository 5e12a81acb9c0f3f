"""One mesh file from its pieces, read one after the other: first all vertices, then all faces."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fusion.errors import VolumeError
from fusion.mesh.mesh import Mesh
from fusion.mesh.ply import exact_in_float32, face_rows, header, vertex_rows
from fusion.progress import each
from fusion.tiles.piece import Piece
from fusion.tiles.seams import seams

MOST = (1 << 31) - 1  # vertices that the faces of a PLY file can name


@dataclass(frozen=True)
class Streamed:
    """What was written.

    Attributes:
        vertices, faces: how many.
        parts: connected ones that were kept, and how many were left out as crumbs.
        area: of the surface [m^2].
        low, high: (3,) its box [m].
    """

    vertices: int
    faces: int
    parts: tuple[int, int]
    area: float
    low: tuple[float, float, float]
    high: tuple[float, float, float]


def stream(paths: Sequence[Path], path: Path, crumb: float) -> Streamed:
    """Write the mesh of all pieces as PLY, without connected parts whose box has a smaller diagonal than `crumb` [m].

    Raises:
        VolumeError: there is no surface, or more vertices than a PLY file can name.
    """
    if not paths:
        raise VolumeError("nothing was fused", found="no surface", do="check --box, --poses and --max-depth")
    joined = seams(paths)
    keep = joined.kept(crumb)
    vertices, faces = int(joined.vertices[keep].sum()), int(joined.faces[keep].sum())
    if vertices > MOST:
        do = "cut it into several with --box"
        raise VolumeError("the mesh is too large for one file", path, f"{vertices} vertices", f"at most {MOST}", do)
    wholes = np.unique(joined.whole[keep])
    low, high = joined.low[wholes].min(axis=0), joined.high[wholes].max(axis=0)
    single = exact_in_float32(np.stack([low, high]))
    number = np.zeros(max((int(some.max(initial=-1)) for some in joined.seam), default=-1) + 1, np.int64)
    begins = np.concatenate([[0], np.cumsum(np.where(keep, joined.vertices, 0))])[joined.first]
    with path.open("wb") as file:
        for index, one in enumerate(each(paths, "vertices")):
            piece = Piece.load(one)
            own = keep[joined.first[index] + piece.part[: len(piece.vertices)]]
            place = begins[index] + np.cumsum(own) - 1
            number[joined.seam[index]] = place[piece.seam]
            rows = vertex_rows(Mesh(piece.vertices[own], normals=piece.normals[own]), single)
            if index == 0:
                file.write(header(rows.dtype, vertices, faces))
            file.write(rows.tobytes())
        for index, one in enumerate(each(paths, "faces")):
            piece = Piece.load(one)
            part = joined.first[index] + piece.part
            own = keep[part[: len(piece.vertices)]]
            place = np.concatenate([begins[index] + np.cumsum(own) - 1, number[joined.foreign[index]]])
            file.write(face_rows(place[piece.faces[keep[part[piece.faces[:, 0]]]]].astype(np.int32)).tobytes())
    left_out = len(joined.area) - len(wholes)
    return Streamed(
        vertices, faces, (len(wholes), left_out), float(joined.area[wholes].sum()), _corner(low), _corner(high)
    )  # fmt: skip


def _corner(values: np.ndarray) -> tuple[float, float, float]:
    x, y, z = values.tolist()
    return x, y, z
