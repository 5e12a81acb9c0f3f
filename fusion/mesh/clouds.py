"""Point cloud files: PCD (by Open3D) and XYZ text."""

from pathlib import Path

import numpy as np

from fusion.mesh.mesh import Mesh


def read_pcd(path: Path) -> Mesh:
    """Points, normals, colours of a PCD file; ValueError where its header promises more than the file can hold."""
    import open3d as o3d

    with path.open("rb") as file:
        head = file.read(4096).split(b"\nDATA", 1)
    points = [line.split() for line in head[0].splitlines() if line.startswith(b"POINTS")]
    if len(head) < 2 or len(points) != 1 or len(points[0]) != 2:
        raise ValueError("no PCD header")
    if int(points[0][1]) > 8 * path.stat().st_size:  # even compressed, 3 numbers a point take more than this
        raise ValueError(f"the header promises {int(points[0][1])} points")
    with o3d.utility.VerbosityContextManager(o3d.utility.VerbosityLevel.Error):
        cloud = o3d.io.read_point_cloud(path)
    if len(cloud.points) != int(points[0][1]):
        raise ValueError(f"{len(cloud.points)} of {int(points[0][1])} points could be read")
    return Mesh(
        vertices=np.asarray(cloud.points, np.float64),
        normals=np.asarray(cloud.normals, np.float32) if cloud.has_normals() else None,
        colors=np.rint(np.asarray(cloud.colors) * 255).astype(np.uint8) if cloud.has_colors() else None,
    )


def read_xyz(path: Path) -> Mesh:
    """Text with `x y z` per line, and perhaps three more: a normal, or a colour of 0-255; `#` and `//` comment."""
    with path.open(encoding="utf-8", errors="strict") as file:
        lines = (line.replace(",", " ").replace(";", " ") for line in file if line.strip())
        values = np.loadtxt(lines, comments=("#", "//"), ndmin=2, dtype=np.float64)
    if values.shape[1] < 3:
        raise ValueError(f"{values.shape[1]} columns")
    more = values[:, 3:6]
    normals = colors = None
    if more.shape[1] == 3:
        lengths = np.linalg.norm(more, axis=1)
        if np.abs(lengths - 1).max(initial=0) < 0.01:
            normals = more.astype(np.float32)
        elif (more == np.rint(more)).all() and (more >= 0).all() and (more <= 255).all():
            colors = more.astype(np.uint8)
    return Mesh(vertices=values[:, :3], normals=normals, colors=colors)


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
