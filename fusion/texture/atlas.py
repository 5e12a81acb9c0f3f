"""The surface laid flat: each triangle gets a place in one picture, by xatlas or, where that is missing, by Open3D."""

import importlib
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.mesh.comparison.surface_samples import face_areas, vertex_normals
from fusion.mesh.mesh import Mesh

GUTTER = 4  # [texels] between parts: halved twice they still do not mix
LARGEST = 4096  # [texels] along an edge: phones and old graphics cards take no more
FILLED = 0.6  # share of the picture that parts cover, as a first guess (measured 0.65 to 0.8)


@dataclass(frozen=True)
class Atlas:
    """A mesh with places in a picture."""

    mesh: Mesh  # with normals; a vertex at a seam is there once for each side
    of: NDArray[np.int64]  # (n,) the vertices of the mesh before
    uv: NDArray[np.float64]  # (n, 2) place of each vertex in the picture, 0 to 1, u to the right, v upwards
    # width, height: of the picture [texels]
    width: int
    height: int


def laid_flat(mesh: Mesh, texel: float) -> Atlas:
    """The triangles of a mesh side by side in a picture.

    Args:
        mesh: triangles [m].
        texel: edge of a texel on the surface [m]; it becomes larger where the picture would be too large.
    """
    texel = max(texel, float(np.sqrt(face_areas(mesh).sum() / FILLED)) / LARGEST)
    try:
        library = importlib.import_module("xatlas")
    except ModuleNotFoundError:
        corners, uv, faces, size = _by_open3d(mesh, texel)
    else:
        corners, uv, faces, size = _by_xatlas(library, mesh, texel)
    normals = mesh.normals if mesh.normals is not None else vertex_normals(mesh).astype(np.float32)
    split = Mesh(
        mesh.vertices[corners], faces.astype(np.int32), normals[corners],
        None if mesh.colors is None else mesh.colors[corners],
    )  # fmt: skip
    return Atlas(split, corners, np.clip(uv, 0, 1).astype(float), *size)


def _by_xatlas(library: Any, mesh: Mesh, texel: float) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any], Any]:
    for _ in range(4):
        atlas, how = library.Atlas(), library.PackOptions()
        # in texels: some of its limits are lengths
        atlas.add_mesh((mesh.vertices / texel).astype(np.float32), mesh.faces.astype(np.uint32))
        how.padding, how.texels_per_unit, how.bilinear = GUTTER, 1.0, True
        atlas.generate(pack_options=how)
        largest = max(atlas.width, atlas.height)
        if largest <= LARGEST:
            break
        texel *= 1.02 * largest / LARGEST
    corners, faces, uv = atlas[0]
    return corners.astype(np.int64), uv, faces, (int(atlas.width), int(atlas.height))


def _by_open3d(mesh: Mesh, texel: float) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any], Any]:
    import open3d as o3d

    size = int(np.clip(np.ceil(np.sqrt(face_areas(mesh).sum() / FILLED) / texel), 64, LARGEST))
    tensor: Any = mesh.to_open3d()
    with o3d.utility.VerbosityContextManager(o3d.utility.VerbosityLevel.Error):
        tensor.compute_uvatlas(size=size, gutter=float(GUTTER), parallel_partitions=1, nthreads=1)
    corner_uv = tensor.triangle["texture_uvs"].numpy().reshape(-1, 2)
    # a vertex for each place that its corners have
    rows, first, inverse = np.unique(
        np.column_stack([mesh.faces.reshape(-1), corner_uv]), axis=0, return_index=True, return_inverse=True
    )
    return mesh.faces.reshape(-1)[first].astype(np.int64), rows[:, 1:], inverse.reshape(-1, 3), (size, size)
