"""Reference points that a camera saw, from a file."""

import zipfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fusion.errors import MeshError
from fusion.mesh.files import read_mesh


def read_seen(path: Path) -> NDArray[np.float64]:
    """Points (n, 3) of an NPZ (its array `points`, or its only one), an NPY, or any mesh or point cloud file.

    Raises:
        MeshError: no such file, unreadable, or no points in it.
    """
    path = Path(path)
    if path.suffix.lower() not in (".npz", ".npy"):
        return read_mesh(path).vertices
    if not path.is_file():
        raise MeshError("no such file of seen points", path, do="check the path")
    try:
        loaded = np.load(path, allow_pickle=False)
        if isinstance(loaded, np.ndarray):
            points = loaded
        else:
            names = loaded.files
            points = loaded["points" if "points" in names or len(names) != 1 else names[0]]
        points = np.asarray(points, np.float64)
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
        reason = (str(error) or type(error).__name__).splitlines()[0][:150]
        raise MeshError("the seen points cannot be read", path, reason, "an array `points` (n, 3)") from error
    if points.ndim != 2 or points.shape[1] != 3:
        raise MeshError("the seen points cannot be used", path, f"an array {points.shape}", "points (n, 3)")
    points = points[np.isfinite(points).all(axis=1)]
    if not len(points):
        raise MeshError("the seen points cannot be used", path, "no finite point", "points (n, 3)")
    return points
