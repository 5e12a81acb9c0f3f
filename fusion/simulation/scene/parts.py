"""The surfaces of a scene file: meshes, boxes, boards."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from fusion.calibration.lens.boards.board import DrawnBoard
from fusion.errors import SceneError
from fusion.files.content import Content
from fusion.files.json_file import read_json
from fusion.geometry.pose import transform
from fusion.mesh.files import read_mesh
from fusion.mesh.mesh import Mesh
from fusion.simulation.rendering.paint import Paint
from fusion.simulation.scene.board import PaintedBoard, board_paint, board_plate
from fusion.simulation.scene.scene import Part
from fusion.simulation.scene.shapes import box
from fusion.simulation.scene.source import PartFields, Rgb, SceneSource

GREY = (180.0, 180.0, 180.0)
DICTIONARY = "DICT_5X5_100"  # of a ChArUco board that does not say which


def read_parts(source: SceneSource, turns: bool) -> tuple[list[Part], list[Paint], PaintedBoard | None]:
    """Parts, patterns and the board (or None) of a scene's "mesh" and "parts".

    `turns`: what does not say whether it stands on the turntable does.
    """
    parts: list[Part] = []
    paints: list[Paint] = []
    board: PaintedBoard | None = None
    given = source.given
    if given.mesh is not None:
        # what a scan should give, unless the scene says otherwise
        mesh = _mesh(source.path(given.mesh, "mesh"), source)
        parts.append(Part(mesh, given.reflectance, turns))
    for index, entry in enumerate(given.parts or ()):
        fields = PartFields(mesh=entry) if isinstance(entry, str) else entry
        turning = turns if fields.turns is None else fields.turns
        if fields.board is None:
            parts.append(_part(fields, source, index, turning))
            continue
        board = _board(fields.board, source, index)
        T = source.pose(fields.pose, "parts", index, "pose")
        parts.append(board_plate(board, T, turning))
        paints.append(board_paint(board, T, turning))
    if not parts:
        found, must = "neither mesh nor parts", '"mesh": "object.ply"'
        raise SceneError("the scene has no surface", source.content.where, found, must)
    return parts, paints, board


def _board(given: str | DrawnBoard, source: SceneSource, index: int) -> PaintedBoard:
    """The board: the name of a `board.json`, or its fields."""
    if isinstance(given, str):
        path = source.path(given, "parts", index, "board")
        content = Content(read_json(path, SceneError, "the board file"), path, "the board", SceneError)
        source.notes.extend(content.unknown(DrawnBoard))
        given = content.as_type(DrawnBoard)
    dictionary = given.dictionary or (DICTIONARY if given.marker_m else "")
    return PaintedBoard(int(given.columns), int(given.rows), given.square_m, given.marker_m or 0.0, dictionary)


def _part(fields: PartFields, source: SceneSource, index: int, turns: bool) -> Part:
    if fields.box is not None:
        mesh = _box(fields, source, index)
    elif fields.mesh is not None:
        mesh = _mesh(source.path(fields.mesh, "parts", index, "mesh"), source, fields.color)
    else:
        raise source.wrong("parts", index, expected='"mesh", "box" or "board"')
    T = source.pose(fields.pose, "parts", index, "pose")
    mesh = replace(mesh, vertices=transform(T, mesh.vertices * (fields.scale or 1.0)))
    if mesh.normals is not None:
        mesh = replace(mesh, normals=(mesh.normals @ T[:3, :3].T).astype(np.float32))
    return Part(mesh, fields.reflectance, turns, fields.scanned is not False)


def _mesh(path: Path, source: SceneSource, color: Rgb | None = None) -> Mesh:
    mesh = read_mesh(path, source.notes)
    if not len(mesh.faces):
        raise SceneError("a point cloud cannot be seen", path, "no faces", "a mesh with triangles")
    if color is None:
        return mesh
    return replace(mesh, colors=np.tile(np.rint(color).astype(np.uint8), (len(mesh.vertices), 1)))


def _box(fields: PartFields, source: SceneSource, index: int) -> Mesh:
    try:
        low, high = np.array(fields.box, float).reshape(2, 3)
    except ValueError as problem:  # not six, or rows of different lengths
        raise source.wrong("parts", index, "box") from problem
    if not (high > low).all():
        raise source.wrong("parts", index, "box")
    color = np.rint(fields.color or GREY).astype(np.uint8)
    return box(tuple(low), tuple(high), tuple(int(c) for c in color))  # type: ignore[arg-type]
