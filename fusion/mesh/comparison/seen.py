"""Reference points that a camera saw, from a file."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fusion.errors import MeshError
from fusion.files.npy import NUMBERS, read_npy, read_npz
from fusion.mesh.files import LARGEST, read_mesh

WHAT = "the file of seen points"


def read_seen(path: Path) -> NDArray[np.float64]:
    """Points (n, 3) of an NPZ (its array `points`, or its only one), an NPY, or any mesh or point cloud file.

    Raises:
        MeshError: no such file, unreadable, or no points in it.
    """
    path = Path(path)
    if path.suffix.lower() not in (".npz", ".npy"):
        return read_mesh(path).vertices
    if path.suffix.lower() == ".npy":
        points = read_npy(path, MeshError, WHAT)
    else:
        (points,) = read_npz(path, MeshError, WHAT, only="points").values()
    if points.dtype.kind not in NUMBERS:
        raise MeshError("the seen points cannot be used", path, f"an array of {points.dtype}", "numbers")
    points = points.astype(np.float64)
    if points.ndim != 2 or points.shape[1] != 3:
        raise MeshError("the seen points cannot be used", path, f"an array {points.shape}", "points (n, 3)")
    points = points[np.isfinite(points).all(axis=1)]
    if points.size and np.abs(points).max() > LARGEST:
        found = f"{np.abs(points).max():.3g}"
        raise MeshError("the seen points are out of bounds", path, found, f"at most {LARGEST:g}", "check the unit")
    if not len(points):
        raise MeshError("the seen points cannot be used", path, "no finite point", "points (n, 3)")
    return points
