"""3MF, what slicers take: millimetres, colours at the corners of triangles; by the consortium's own library, lib3mf."""

import io
import locale
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.errors import MeshError
from fusion.files.extra import extra
from fusion.files.limits import check_size
from fusion.files.reading import TEXT_TAKES
from fusion.mesh.mesh import Mesh

Array = NDArray[np.float64]
MILLIMETRE = 1e-3  # [m]
# [m] in the order of the standard's units (core specification, section 3.4): micron, mm, cm, inch, foot, metre
UNITS = (1e-6, 1e-3, 1e-2, 0.0254, 0.3048, 1.0)
FARTHEST = 1e6  # [m] the library takes no coordinate beyond 1e9 mm
MOST_PARTS = 10_000  # a few groups that name each other twice make more than any plate holds (guess)


def read_3mf(data: bytes, path: Path) -> Mesh:
    """What a file would print, in metres: all its parts at their places, as one mesh; with colours if all have them.

    Raises:
        MeshError: lib3mf is not installed, or the file asks for too much memory.
        ValueError: no 3MF file, or nothing to print in it.
    """
    library = threemf_library(path)
    with zipfile.ZipFile(io.BytesIO(data)) as file:
        check_size(TEXT_TAKES * sum(part.file_size for part in file.infolist()), path, MeshError, "the 3MF file")
        if damaged := file.testzip():  # the library does not look at the sums
            raise ValueError(f"a damaged part: {damaged[:60]}")
    model = library.get_wrapper().CreateModel()
    with _own_locale():
        model.QueryReader("3mf").ReadFromBuffer(data)
    parts: list[Mesh] = []
    for count, (thing, T) in enumerate(_placed(model)):
        if count == MOST_PARTS:
            raise ValueError(f"more than {MOST_PARTS:,} parts")
        if thing.IsMeshObject():
            parts.append(_part(library, model, model.GetMeshObjectByID(thing.GetUniqueResourceID()), T))
            check_size(sum(mesh.vertices.nbytes + mesh.faces.nbytes for mesh in parts), path, MeshError, "the 3MF file")
    if not parts:
        raise ValueError("nothing to print in it")
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in parts)])
    colors = [mesh.colors for mesh in parts if mesh.colors is not None]
    return Mesh(
        np.concatenate([mesh.vertices for mesh in parts]) * UNITS[int(model.GetUnit())],
        np.concatenate([mesh.faces + start for mesh, start in zip(parts, starts, strict=False)]).astype(np.int32),
        colors=np.concatenate(colors) if len(colors) == len(parts) else None,
    )


def write_3mf(path: Path, mesh: Mesh) -> None:
    """Triangles [m] in millimetres, with the colours of the vertices.

    Raises:
        MeshError: lib3mf is not installed, or takes no coordinates so far out.
    """
    library = threemf_library(path)
    if (largest := float(np.abs(mesh.vertices).max(initial=0.0))) > FARTHEST:
        found, do = f"coordinates up to {largest:.3g} m", "check the unit, or write PLY"
        raise MeshError("3MF holds no coordinates so far from the origin", path.name, found, f"{FARTHEST:.0g} m", do)
    wrapper = library.get_wrapper()
    model = wrapper.CreateModel()
    model.SetUnit(library.ModelUnit.MilliMeter)
    part = model.AddMeshObject()
    part.SetName("scan")
    places = np.ascontiguousarray(mesh.vertices / MILLIMETRE, np.float32)
    corners = np.ascontiguousarray(mesh.faces, np.uint32)
    part.SetGeometry(_rows(library.Position, places), _rows(library.Triangle, corners))
    if mesh.colors is not None:
        _paint(library, model, part, mesh)
    model.AddBuildItem(part, wrapper.GetIdentityTransform())
    with _own_locale():
        model.QueryWriter("3mf").WriteToFile(str(path))


def threemf_library(path: Path) -> Any:
    """lib3mf; MeshError where it is not installed."""
    return extra("lib3mf", "print", "a 3MF file", path, MeshError)


@contextmanager
def _own_locale() -> Iterator[None]:
    """The process keeps its locale: the library leaves it in C, where Python takes text without a name for ASCII."""
    own = locale.setlocale(locale.LC_ALL)
    try:
        yield
    finally:
        locale.setlocale(locale.LC_ALL, own)


def _placed(model: Any) -> Iterator[tuple[Any, Array]]:
    """Every object that is to be printed, groups and what they are made of, and its place (4, 3).

    A row of a point and 1 is multiplied with a place.
    """
    queue: list[tuple[Any, Array]] = []
    items = model.GetBuildItems()
    while items.MoveNext():
        item = items.GetCurrent()
        queue.append((item.GetObjectResource(), _matrix(item.GetObjectTransform())))
    while queue:
        thing, T = queue.pop(0)
        yield thing, T
        if thing.IsComponentsObject():
            group = model.GetComponentsObjectByID(thing.GetUniqueResourceID())
            for one in (group.GetComponent(index) for index in range(group.GetComponentCount())):
                inner = _matrix(one.GetTransform())
                queue.append((one.GetObjectResource(), np.vstack([inner[:3] @ T[:3], inner[3] @ T[:3] + T[3]])))


def _matrix(transform: Any) -> Array:
    return np.array([list(row) for row in transform.Fields], float)


def _part(library: Any, model: Any, part: Any, T: Array) -> Mesh:
    """Triangles at their place, in the file's unit."""
    places = _numbers(library.Position, part.GetVertices(), np.float32).reshape(-1, 3).astype(float)
    faces = _numbers(library.Triangle, part.GetTriangleIndices(), np.uint32).reshape(-1, 3).astype(np.int32)
    colors = _colors(library, model, part, faces, len(places))
    mirrored = np.linalg.det(T[:3]) < 0  # which turns faces inside out
    return Mesh(places @ T[:3] + T[3], faces[:, ::-1] if mirrored else faces, colors=colors)


def _colors(library: Any, model: Any, part: Any, faces: NDArray[Any], count: int) -> NDArray[np.uint8] | None:
    """(n, 3) of the vertices, where every triangle has colours from one table; None where not."""
    rows = _numbers(library.TriangleProperties, part.GetAllTriangleProperties(), np.uint32).reshape(-1, 4)
    tables = np.unique(rows[:, 0]).tolist()
    if len(rows) != len(faces) or len(tables) != 1 or not tables[0]:
        return None
    if model.GetPropertyTypeByID(tables[0]) != library.PropertyType.Colors:
        return None
    table = model.GetColorGroupByID(tables[0])
    names, of_corner = np.unique(rows[:, 1:], return_inverse=True)
    known = [table.GetColor(name) for name in names.tolist()]
    different = np.array([(color.Red, color.Green, color.Blue) for color in known], np.uint8)
    colors = np.full((count, 3), 255, np.uint8)
    colors[faces.ravel()] = different[of_corner.ravel()]
    return colors


def _paint(library: Any, model: Any, part: Any, mesh: Mesh) -> None:
    """Each corner takes the colour of its vertex, from one table of all different ones."""
    colors, of_vertex = np.unique(np.asarray(mesh.colors), axis=0, return_inverse=True)
    table = model.AddColorGroup()
    names = np.array([table.AddColor(library.Color(*color, 255)) for color in colors.tolist()], np.uint32)
    rows = np.empty((len(mesh.faces), 4), np.uint32)
    rows[:, 0], rows[:, 1:] = table.GetResourceID(), names[of_vertex.ravel()][mesh.faces]
    part.SetAllTriangleProperties(_rows(library.TriangleProperties, rows))
    part.SetObjectLevelProperty(int(rows[0, 0]), int(rows[0, 1]))  # without it slicers take no colour


def _rows(kind: Any, numbers: NDArray[Any]) -> Any:
    """An array of the library's structures from rows of the same bytes."""
    return (kind * len(numbers)).from_buffer_copy(numbers.tobytes())


def _numbers(kind: Any, rows: list[Any], number: type) -> NDArray[Any]:
    """And back, flat."""
    return np.frombuffer((kind * len(rows))(*rows), number)
