"""USDZ of a mesh: opened again by Pixar's library, size, axis, triangles and colours as they went in."""

import sys

import numpy as np
import pytest

from fusion import Mesh, read_mesh, write_mesh
from fusion.commands.main import main
from fusion.errors import MeshError

CORNERS = np.array([[0, 0, 0], [0.1, 0, 0], [0, 0.2, 0], [0, 0, 0.3]])  # [m], z up
FACES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], np.int32)
COLORS = np.array([[255, 0, 0], [0, 255, 0], [0, 0, 255], [188, 188, 188]], np.uint8)
SCAN = Mesh(CORNERS, FACES, colors=COLORS)


def opened(path):
    from pxr import Usd, UsdGeom

    stage = Usd.Stage.Open(str(path))
    (shape,) = [UsdGeom.Mesh(prim) for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh)]
    return stage, shape


def test_convert_makes_one_that_is_metres_and_y_up(tmp_path):
    from pxr import UsdGeom, UsdValidation

    write_mesh(tmp_path / "a.ply", SCAN)
    assert main(["convert", str(tmp_path / "a.ply"), str(tmp_path / "a.usdz")]) == 0
    stage, shape = opened(tmp_path / "a.usdz")
    assert UsdGeom.GetStageUpAxis(stage) == "Y" and UsdGeom.GetStageMetersPerUnit(stage) == 1
    points = np.asarray(shape.GetPointsAttr().Get())
    np.testing.assert_allclose(points, CORNERS[:, [0, 2, 1]] * [1, 1, -1], atol=1e-7)  # z is y, y is -z
    np.testing.assert_array_equal(np.asarray(shape.GetFaceVertexIndicesAttr().Get()).reshape(-1, 3), FACES)
    colors = np.asarray(shape.GetDisplayColorAttr().Get())
    np.testing.assert_allclose(colors[:3], np.eye(3), atol=1e-6)
    np.testing.assert_allclose(colors[3], 0.503, atol=0.001)  # half the light
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    errors = UsdValidation.ValidationContext(validators).Validate(stage)
    assert len(validators) > 20 and not [error.GetErrorAsString() for error in errors]


def test_what_cannot_be_is_one_line(tmp_path, monkeypatch, capsys):
    write_mesh(tmp_path / "a.ply", SCAN)
    with pytest.raises(MeshError, match="triangles only"):
        write_mesh(tmp_path / "b.usdz", Mesh(CORNERS, np.zeros((0, 3), np.int32)))
    (tmp_path / "c.usdz").write_bytes(b"PK")
    with pytest.raises(MeshError, match="only written"):
        read_mesh(tmp_path / "c.usdz")
    monkeypatch.setitem(sys.modules, "pxr", None)
    assert main(["convert", str(tmp_path / "a.ply"), str(tmp_path / "b.usdz")]) == 1
    assert "fusion-scan[usd]" in capsys.readouterr().err and not (tmp_path / "b.usdz").exists()
