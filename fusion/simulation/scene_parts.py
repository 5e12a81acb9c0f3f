"""The surfaces of a scene file: meshes, boxes, boards."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from fusion.errors import FusionError, SceneError
from fusion.files.json_file import read_json
from fusion.geometry.pose import Array, transform
from fusion.mesh.files import read_mesh
from fusion.mesh.mesh import Mesh
from fusion.simulation.board import Board, board_paint, board_plate
from fusion.simulation.paint import Paint
from fusion.simulation.scene import Part
from fusion.simulation.scene_values import Values
from fusion.simulation.shapes import box

SMALLEST = 1e-9


def read_parts(scene: Values, folder: Path, turns: bool, notes: list[str]) -> tuple[list[Part], list[Paint], Any]:
    """Parts, patterns and the content of `board.json` (or None) of a scene's "mesh" and "parts"."""
    entries: list[Any] = []
    if "mesh" in scene:
        # what a scan should give, unless the scene says otherwise
        entries.append({"mesh": scene.any("mesh"), "reflectance": scene.any("reflectance")})
    more = scene.any("parts")
    if more is not None and not isinstance(more, list):
        raise scene.wrong("parts", "a list")
    entries += more or []
    if not entries:
        raise SceneError("the scene has no surface", scene.where, "neither mesh nor parts", '"mesh": "object.ply"')
    parts: list[Part] = []
    paints: list[Paint] = []
    board: Board | None = None
    for index, entry in enumerate(entries):
        entry = {"mesh": entry} if isinstance(entry, str) else entry
        values = Values(entry, f"{scene.where}, part {index}", notes)
        if "board" in values:
            board = read_board(values, folder, notes)
            T, turning = _pose(values), values.truth("turns", turns)
            parts.append(board_plate(board, T, turning))
            paints.append(board_paint(board, T, turning))
        else:
            parts.append(_part(values, folder, turns, notes))
        values.done()
    return parts, paints, None if board is None else board.to_dict()


def read_board(values: Values, folder: Path, notes: list[str]) -> Board:
    """The board under "board": the name of a `board.json`, or its fields."""
    content = values.any("board")
    where = f"{values.where}, board"
    if isinstance(content, str):
        content = values.text("board")
        where = str(folder / content)
        content = read_json(folder / content, SceneError, "the board file")
    fields = Values(content, where, notes)
    return Board(
        columns=fields.whole("columns", None, 1, 1000),
        rows=fields.whole("rows", None, 1, 1000),
        square_m=fields.number("square_m", None, SMALLEST, 100.0),
        marker_m=fields.number("marker_m", 0.0, 0.0, 100.0),
        dictionary=fields.text("dictionary", "DICT_5X5_100" if "marker_m" in fields else ""),
    )


def _part(values: Values, folder: Path, turns: bool, notes: list[str]) -> Part:
    if "box" in values:
        mesh = _box(values)
    else:
        name = values.text("mesh")
        if not name:
            raise SceneError("a part of the scene has no shape", values.where, "nothing", '"mesh", "box" or "board"')
        mesh = _mesh(folder / name, values, notes)
    reflectance = values.number("reflectance", -1.0, 0.0, 1.0) if "reflectance" in values else None
    mesh = replace(mesh, vertices=transform(_pose(values), mesh.vertices * values.number("scale", 1.0, SMALLEST)))
    if mesh.normals is not None:
        mesh = replace(mesh, normals=(mesh.normals @ _pose(values)[:3, :3].T).astype(np.float32))
    return Part(mesh, reflectance, values.truth("turns", turns), values.truth("scanned", True))


def _mesh(path: Path, values: Values, notes: list[str]) -> Mesh:
    try:
        mesh = read_mesh(path, notes)
    except FusionError as error:
        raise SceneError(error.what, error.where, error.found, error.expected, error.do) from error
    if not len(mesh.faces):
        raise SceneError("a point cloud cannot be seen", path, "no faces", "a mesh with triangles")
    if "color" in values:
        return replace(mesh, colors=np.tile(_color(values), (len(mesh.vertices), 1)))
    return mesh


def _box(values: Values) -> Mesh:
    corners = values.any("box")
    try:
        low, high = np.array(corners, float).reshape(2, 3)
    except (TypeError, ValueError, OverflowError):
        raise values.wrong("box", "two corners, [[x, y, z], [x, y, z]]") from None
    if not (np.isfinite([low, high]).all() and (high > low).all() and np.abs([low, high]).max() < 1e6):
        raise values.wrong("box", "two corners, the lower first, metres")
    color = _color(values) if "color" in values else np.full(3, 180, np.uint8)
    return box(tuple(low), tuple(high), tuple(int(c) for c in color))  # type: ignore[arg-type]


def _color(values: Values) -> np.ndarray:
    color = np.array(values.vector("color"))
    if not ((color >= 0) & (color <= 255)).all():
        raise values.wrong("color", "red, green and blue, 0 to 255")
    return np.rint(color).astype(np.uint8)


def _pose(values: Values) -> Array:
    T = values.pose("pose")
    return np.eye(4) if T is None else T
