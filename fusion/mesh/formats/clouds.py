"""Point clouds: PCD (by Open3D) and XYZ text."""

import tempfile
from pathlib import Path

import numpy as np

from fusion.files.reading import decoded
from fusion.mesh.formats.pcd import checked_pcd
from fusion.mesh.formats.rows import filled, table
from fusion.mesh.mesh import Mesh

NINE_DIGITS = 1000.0  # [m] below this they are exact to half a micrometre


def read_pcd(data: bytes) -> Mesh:
    """Points, normals and colours; a point that was not measured is NaN, as it stands in the file."""
    import open3d as o3d

    whole, points = checked_pcd(data)
    with tempfile.NamedTemporaryFile(suffix=".pcd") as file:
        file.write(whole)
        file.flush()
        with o3d.utility.VerbosityContextManager(o3d.utility.VerbosityLevel.Error):
            cloud = o3d.io.read_point_cloud(Path(file.name), format="pcd")
    if len(cloud.points) != points:
        raise ValueError(f"{len(cloud.points)} of {points} points could be read")
    return Mesh(
        np.asarray(cloud.points, np.float64),
        normals=np.asarray(cloud.normals, np.float32) if cloud.has_normals() else None,
        colors=np.rint(np.asarray(cloud.colors) * 255).astype(np.uint8) if cloud.has_colors() else None,
    )


def read_xyz(data: bytes) -> Mesh:
    """Text with `x y z` per line, and perhaps three more: a normal, or a colour of 0-255; `#` and `//` comment.

    The first line may say how many points there are, as CloudCompare writes it if asked.

    Raises:
        ValueError: a line that does not fit, or another number of points than the first line promises.
    """
    text = decoded(data).replace(",", " ").replace(";", " ").replace("//", "#")
    lines = filled(text, "#")
    promised = lines[0][1].strip() if len(lines) > 1 else ""
    if promised.isdecimal():
        lines = lines[1:]
        if int(promised) != len(lines):
            raise ValueError(f"{len(lines)} of {promised} points")
    values = table(lines)
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
    near = np.abs(mesh.vertices).max(initial=0.0) < NINE_DIGITS
    place = "%.9g" if near else "%.15g"  # all that a double holds for certain
    np.savetxt(path, rows, fmt=[place] * 3 + ["%.9g"] * (rows.shape[1] - 3))
