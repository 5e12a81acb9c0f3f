"""E57 (ASTM E2807): the clouds of scanners that measure parts and rooms, as a reference."""

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from fusion.errors import MeshError
from fusion.files.extra import extra
from fusion.files.limits import check_size
from fusion.mesh.mesh import Mesh

_CARTESIAN = ("cartesianX", "cartesianY", "cartesianZ")
_SPHERICAL = ("sphericalRange", "sphericalAzimuth", "sphericalElevation")
_COLORS = ("colorRed", "colorGreen", "colorBlue")
_BYTES = 8 * (3 + 3 + 1) * 2  # of a point while it is read: place, colour and state, as read and as made of it


def read_e57(data: bytes, path: Path) -> Mesh:
    """The points of all scans in a file [m], each brought to its place; colours where every scan has them.

    Points that a scan marks as invalid are left out.

    Raises:
        MeshError: the library that reads E57 is not installed, or the file asks for too much memory.
        ValueError: no scan, no points, or fewer than promised.
    """
    library = extra("pye57", "e57", "an E57 file", path, MeshError)
    # a copy: the library takes names only, and tries to remove a file that it cannot open
    with tempfile.NamedTemporaryFile(suffix=".e57") as file:
        file.write(data)
        file.flush()
        with library.E57(file.name) as opened:
            scans = [opened.get_header(index) for index in range(opened.scan_count)]
            check_size(_BYTES * sum(scan.point_count for scan in scans), path, MeshError, "the E57 file")
            parts = [_scan(opened, scan, library.libe57) for scan in scans if scan.point_count]
    if not parts:
        raise ValueError("no scan with points")
    colors = [color for _, color in parts if color is not None]
    together = np.concatenate(colors) if len(colors) == len(parts) else None
    return Mesh(np.concatenate([points for points, _ in parts]), colors=together)


def _scan(opened: Any, scan: Any, library: Any) -> tuple[NDArray[np.float64], NDArray[np.uint8] | None]:
    fields = set(scan.point_fields)
    names = next((names for names in (_CARTESIAN, _SPHERICAL) if fields.issuperset(names)), None)
    if names is None:
        raise ValueError(f"no coordinates among {', '.join(sorted(fields))}"[:150])
    state = "cartesianInvalidState" if names == _CARTESIAN else "sphericalInvalidState"
    colored = _COLORS if fields.issuperset(_COLORS) else ()
    columns = _columns(opened, scan, (*names, *colored, *([state] if state in fields else [])), library)
    if state in fields:
        columns = columns[:, columns[-1] == 0]
    points = columns[:3] if names == _CARTESIAN else _from_angles(*columns[:3])
    colors = None
    if colored:
        largest = np.array([[_number(scan.node, ("colorLimits", f"{name}Maximum"), 255.0)] for name in _COLORS])
        with np.errstate(invalid="ignore", divide="ignore"):
            colors = np.nan_to_num(np.clip(np.rint(columns[3:6] / largest * 255), 0, 255)).astype(np.uint8).T
    return _placed(scan.node, points.T), colors


def _columns(opened: Any, scan: Any, names: Sequence[str], library: Any) -> NDArray[np.float64]:
    """(names, n) numbers of all points."""
    columns = np.empty((len(names), scan.point_count))
    buffers = library.VectorSourceDestBuffer()
    for name, column in zip(names, columns, strict=True):
        buffers.append(library.SourceDestBuffer(opened.image_file, name, column, len(column), True, True))
    count = scan.points.reader(buffers).read()
    if count != columns.shape[1]:
        raise ValueError(f"{count} of {columns.shape[1]} points")
    return columns


def _from_angles(
    distance: NDArray[np.float64], azimuth: NDArray[np.float64], elevation: NDArray[np.float64]
) -> NDArray[np.float64]:
    flat = distance * np.cos(elevation)
    return np.array([flat * np.cos(azimuth), flat * np.sin(azimuth), distance * np.sin(elevation)])


def _placed(node: Any, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Points (n, 3) of a scan where its pose puts them; a part of the pose that is not said changes nothing."""
    turn = [_number(node, ("pose", "rotation", name), float(name == "w")) for name in "wxyz"]
    shift = [_number(node, ("pose", "translation", name), 0.0) for name in "xyz"]
    if not np.isfinite([*turn, *shift]).all() or not any(turn):
        raise ValueError(f"the pose of a scan is no pose: rotation {turn}, translation {shift}")
    return np.asarray(Rotation.from_quat(turn, scalar_first=True).apply(points) + shift)


def _number(node: Any, names: Sequence[str], otherwise: float) -> float:
    """A number deep in a node."""
    for name in names:
        if not node.isDefined(name):
            return otherwise
        node = node[name]
    return float(node.value())
