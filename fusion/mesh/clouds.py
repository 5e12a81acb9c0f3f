"""Point clouds are written as PCD (by Open3D) and XYZ text."""

from pathlib import Path

import numpy as np

from fusion.mesh.mesh import Mesh


def write_pcd(path: Path, mesh: Mesh) -> None:
    """The vertices as a binary PCD file."""
    import open3d as o3d

    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(mesh.vertices))
    if mesh.normals is not None:
        cloud.normals = o3d.utility.Vector3dVector(mesh.normals.astype(np.float64))
    if mesh.colors is not None:
        cloud.colors = o3d.utility.Vector3dVector(mesh.colors / 255.0)
    if not o3d.io.write_point_cloud(path, cloud):
        raise OSError(f"cannot write {path}")


def write_xyz(path: Path, mesh: Mesh) -> None:
    """The vertices as text, with normals or else colours behind them where there are any."""
    more = mesh.normals if mesh.normals is not None else mesh.colors
    rows = mesh.vertices if more is None else np.hstack([mesh.vertices, more])
    np.savetxt(path, rows, fmt="%.9g")
