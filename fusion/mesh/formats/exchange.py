"""Meshes for Open3D and trimesh, and back: points, triangles, normals, colours and all values per vertex."""

import io
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fusion.mesh.mesh import Mesh

if TYPE_CHECKING:
    import open3d
    import trimesh

_OWN = {"positions", "normals", "colors"}  # of Open3D's vertex attributes; all others are scalars


def to_open3d(mesh: Mesh) -> "open3d.t.geometry.TriangleMesh | open3d.t.geometry.PointCloud":
    """Open3D's tensor mesh, or its point cloud where there are no faces; positions are float32 there."""
    import open3d as o3d

    tensor = o3d.core.Tensor.from_numpy
    out: Any = o3d.t.geometry.TriangleMesh() if len(mesh.faces) else o3d.t.geometry.PointCloud()
    values = out.vertex if len(mesh.faces) else out.point
    if len(mesh.faces):
        out.triangle.indices = tensor(mesh.faces.astype(np.int64))
    values.positions = tensor(mesh.vertices.astype(np.float32))
    if mesh.normals is not None:
        values.normals = tensor(mesh.normals.astype(np.float32))
    if mesh.colors is not None:
        values.colors = tensor(mesh.colors.astype(np.float32) / 255)  # bytes would be taken as they are by to_legacy
    for name, scalar in mesh.scalars.items():
        values[name] = tensor(scalar.astype(np.float32)[:, None])  # as Open3D's own readers keep them
    return out


def from_open3d(geometry: Any) -> Mesh:
    """From a mesh or point cloud of Open3D, of its tensors or of its older `open3d.geometry`."""
    import open3d as o3d

    if isinstance(geometry, o3d.geometry.TriangleMesh):
        geometry = o3d.t.geometry.TriangleMesh.from_legacy(geometry, o3d.core.float64)
    elif isinstance(geometry, o3d.geometry.PointCloud):
        geometry = o3d.t.geometry.PointCloud.from_legacy(geometry, o3d.core.float64)
    flat = isinstance(geometry, o3d.t.geometry.PointCloud)
    values = {name: value.cpu().numpy() for name, value in (geometry.point if flat else geometry.vertex).items()}
    bare = flat or "indices" not in geometry.triangle
    return Mesh(
        vertices=values["positions"].astype(np.float64),
        faces=_indices(np.zeros((0, 3)) if bare else geometry.triangle.indices.cpu().numpy()),
        normals=values["normals"].astype(np.float32) if "normals" in values else None,
        colors=_bytes(values["colors"]) if "colors" in values else None,
        scalars={
            name: value.reshape(-1).astype(np.float32)
            for name, value in values.items()
            if name not in _OWN and value.size == len(value)
        },
    )


def to_trimesh(mesh: Mesh) -> "trimesh.Trimesh | trimesh.PointCloud":
    """trimesh's mesh, or its point cloud where there are no faces (which holds points and colours only)."""
    import trimesh

    if not len(mesh.faces):
        return trimesh.PointCloud(mesh.vertices, colors=mesh.colors)
    out = trimesh.Trimesh(
        mesh.vertices,
        mesh.faces,
        vertex_normals=None if mesh.normals is None else mesh.normals.astype(np.float64),
        vertex_colors=mesh.colors,
        process=False,  # nothing is merged: vertex i stays vertex i
    )
    out.vertex_attributes.update(mesh.scalars)
    return out


def from_trimesh(geometry: Any) -> Mesh:
    """From a mesh or point cloud of trimesh; a scene becomes one mesh, its parts placed as it says.

    Raises:
        ValueError: there is no surface and no point in it.
    """
    import trimesh

    if isinstance(geometry, trimesh.Scene):
        geometry = trimesh.util.concatenate(geometry.dump())
    if not hasattr(geometry, "vertices"):
        raise ValueError("no surface in it")
    cloud = not hasattr(geometry, "faces")
    colors = geometry.colors if cloud else getattr(geometry.visual, "vertex_colors", None)
    defined = cloud or getattr(geometry.visual, "kind", None) == "vertex"
    values = {} if cloud else geometry.vertex_attributes
    return Mesh(
        vertices=np.array(geometry.vertices, np.float64),
        faces=_indices(np.zeros((0, 3)) if cloud else np.asarray(geometry.faces)),
        # normals that the mesh was given; those that trimesh would compute are no part of it
        normals=np.array(geometry.vertex_normals, np.float32) if "vertex_normals" in geometry._cache else None,
        colors=np.array(colors, np.uint8)[:, :3] if defined and colors is not None and len(colors) else None,
        scalars={
            name: np.asarray(value, np.float32)
            for name, value in values.items()
            if np.shape(value) == (len(geometry.vertices),)
        },
    )


def by_trimesh(data: bytes, ending: str, resolver: Any = None) -> Mesh:
    """The mesh in a file's bytes; a resolver gives the files that they name. Raises all kinds where they break."""
    import trimesh

    with np.errstate(all="ignore"):  # numbers out of bounds are found where the mesh is checked
        return from_trimesh(
            trimesh.load(io.BytesIO(data), ending[1:], resolver=resolver, process=False, skip_materials=True)
        )


def _indices(faces: NDArray) -> NDArray[np.int32]:
    """Faces (m, 3) as a mesh holds them; an index that is out of bounds stays so and does not wrap round."""
    return np.clip(faces, -1, np.iinfo(np.int32).max).astype(np.int32)


def _bytes(colors: NDArray) -> NDArray[np.uint8]:
    """RGB as bytes, of bytes or of numbers from 0 to 1."""
    if colors.dtype == np.uint8:
        return colors
    return np.rint(np.clip(colors, 0, 1) * 255).astype(np.uint8)
