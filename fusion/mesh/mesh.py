"""A triangle mesh as plain arrays."""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import open3d
    import trimesh


@dataclass(frozen=True)
class Mesh:
    """Triangles, or a point cloud when there are no faces.

    Attributes:
        vertices: (n, 3) float64 [m].
        faces: (m, 3) int32, counter-clockwise seen from outside; (0, 3) for a point cloud.
        normals: (n, 3) float32 unit vectors pointing outwards, or None.
        colors: (n, 3) uint8 RGB, or None.
        scalars: named values per vertex, each (n,) float32.
        notes: sentences on these; a PLY is written with them as comments.
    """

    vertices: NDArray[np.float64]
    faces: NDArray[np.int32] = field(default_factory=lambda: np.zeros((0, 3), np.int32))
    normals: NDArray[np.float32] | None = None
    colors: NDArray[np.uint8] | None = None
    scalars: dict[str, NDArray[np.float32]] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    def to_open3d(self) -> "open3d.t.geometry.TriangleMesh | open3d.t.geometry.PointCloud":
        """The same for Open3D, with normals, colours and scalars; a point cloud where there are no faces.

        >>> shown = fusion.read_mesh("ball.ply").to_open3d()
        >>> shown.vertex["sigma"].shape
        SizeVector[642, 1]
        >>> shown.to_legacy().is_watertight()  # for functions that take the older `open3d.geometry`
        True
        """
        from fusion.mesh.formats.exchange import to_open3d

        return to_open3d(self)

    def to_trimesh(self) -> "trimesh.Trimesh | trimesh.PointCloud":
        """The same for trimesh, with normals, colours and scalars; a point cloud where there are no faces.

        >>> round(1e6 * float(fusion.read_mesh("ball.ply").to_trimesh().volume))  # [cm^3]
        519
        """
        from fusion.mesh.formats.exchange import to_trimesh

        return to_trimesh(self)

    @staticmethod
    def from_open3d(geometry: Any) -> "Mesh":
        """From a mesh or point cloud of Open3D, `open3d.t.geometry` or `open3d.geometry`.

        >>> fusion.Mesh.from_open3d(open3d.t.io.read_triangle_mesh("ball.ply"))
        <Mesh: 642 vertices, 1,280 triangles, 100 x 100 x 100 mm; normals, colors>
        """
        from fusion.mesh.formats.exchange import from_open3d

        return from_open3d(geometry)

    @staticmethod
    def from_trimesh(geometry: Any) -> "Mesh":
        """From a mesh, point cloud or scene of trimesh.

        >>> fusion.Mesh.from_trimesh(trimesh.creation.box((0.1, 0.2, 0.3)))
        <Mesh: 8 vertices, 12 triangles, 100 x 200 x 300 mm>
        """
        from fusion.mesh.formats.exchange import from_trimesh

        return from_trimesh(geometry)

    def __repr__(self) -> str:
        known = self.vertices[np.isfinite(self.vertices).all(axis=1)]
        size = "" if not len(known) else " x ".join(f"{1e3 * x:.0f}" for x in np.ptp(known, axis=0))
        shape = f"{len(self.faces):,} triangles" if len(self.faces) else "no triangles"
        held = [name for name in ("normals", "colors") if getattr(self, name) is not None]
        told = ", ".join([*held, *self.scalars])
        return (
            f"<Mesh: {len(self.vertices):,} vertices, {shape}"
            + (f", {size} mm" * bool(size))
            + (f"; {told}>" if told else ">")
        )

    def _repr_png_(self) -> bytes | None:
        """A picture for notebooks, from both sides, z up."""
        from fusion.mesh.drawing.shading import png

        return png(self)
