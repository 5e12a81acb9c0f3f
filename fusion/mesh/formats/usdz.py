"""USDZ, which phones of Apple show in a room: by Pixar's own library; metres, y up, and the file says so."""

import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.errors import MeshError
from fusion.files.extra import extra
from fusion.mesh.mesh import Mesh


def usd_library(where: Path) -> Any:
    """The library; MeshError where it is not installed."""
    return extra("pxr", "usd", "a USDZ file", where, MeshError)


def write_usdz(path: Path, mesh: Mesh) -> None:
    """One file with the mesh, y up, and the colours of its vertices.

    Raises:
        MeshError: usd-core is not installed, or refuses.
    """
    usd_library(path)
    with tempfile.TemporaryDirectory() as name:
        stage, shape = stage_of(Path(name) / "scan.usdc", mesh)
        if mesh.colors is not None:
            _color(shape, mesh.colors)
        stage.GetRootLayer().Save()
        path.write_bytes(packed(Path(name), path))


def stage_of(path: Path, mesh: Mesh) -> tuple[Any, Any]:
    """A scene of one mesh, y up, with its normals; and that mesh. It is not saved yet."""
    from pxr import Gf, Kind, Usd, UsdGeom, Vt

    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    root = UsdGeom.Xform.Define(stage, "/scan")
    Usd.ModelAPI(root).SetKind(Kind.Tokens.component)
    stage.SetDefaultPrim(root.GetPrim())
    shape = UsdGeom.Mesh.Define(stage, "/scan/mesh")
    shape.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(mesh.vertices.astype(np.float32)))
    shape.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(np.full(len(mesh.faces), 3, np.int32)))
    shape.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(np.ascontiguousarray(mesh.faces.ravel(), np.int32)))
    if mesh.normals is not None:
        shape.CreateNormalsAttr(Vt.Vec3fArray.FromNumpy(np.asarray(mesh.normals, np.float32)))
        shape.SetNormalsInterpolation(UsdGeom.Tokens.vertex)
    shape.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    shape.CreateExtentAttr([Gf.Vec3f(*map(float, low)), Gf.Vec3f(*map(float, high))])
    return stage, shape


def packed(folder: Path, path: Path) -> bytes:
    """The USDZ file of a folder's `scan.usdc` and what that names. Raises MeshError, which names `path`."""
    from pxr import UsdUtils

    # the library names the parts of the package by their places beside the first layer
    if not UsdUtils.CreateNewARKitUsdzPackage(str(folder / "scan.usdc"), str(folder / "out.usdz")):
        raise MeshError("the USDZ file could not be made", path, "usd-core refused")
    return (folder / "out.usdz").read_bytes()


def _color(shape: Any, colors: NDArray[np.uint8]) -> None:
    """Colours of vertices; USD's are linear light, bytes follow sRGB (IEC 61966-2-1)."""
    from pxr import UsdGeom, Vt

    given = colors / 255.0
    linear = np.where(given <= 0.04045, given / 12.92, ((given + 0.055) / 1.055) ** 2.4)
    told = shape.CreateDisplayColorPrimvar(UsdGeom.Tokens.vertex)
    told.Set(Vt.Vec3fArray.FromNumpy(np.asarray(linear, np.float32)))
