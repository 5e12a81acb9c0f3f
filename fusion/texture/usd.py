"""USDZ, which phones of Apple show in a room: by Pixar's own library."""

import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from fusion.errors import MeshError
from fusion.files.extra import extra
from fusion.files.publish import atomic_file
from fusion.mesh.conventions import for_file
from fusion.texture.files import png
from fusion.texture.textured import Textured


def usd_library(where: Path) -> Any:
    """The library; MeshError where it is not installed."""
    return extra("pxr", "usd", "a USDZ file", where, MeshError)


def write_usdz(path: Path, made: Textured) -> None:
    """One file with the picture in it; metres, y up, and the file says so.

    Raises:
        MeshError: usd-core is not installed, or refuses.
    """
    usd_library(path)
    from pxr import UsdUtils

    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "texture.png").write_bytes(png(made))
        _stage(folder / "scan.usdc", made)
        with atomic_file(path) as partial:
            # the library names the parts of the package by their places beside the first layer
            if not UsdUtils.CreateNewARKitUsdzPackage(str(folder / "scan.usdc"), str(folder / "out.usdz")):
                raise MeshError("the USDZ file could not be made", path, "usd-core refused")
            partial.write_bytes((folder / "out.usdz").read_bytes())


def _stage(path: Path, made: Textured) -> None:
    """The scene: one mesh with a material whose colour is the picture."""
    from pxr import Gf, Kind, Sdf, Usd, UsdGeom, UsdShade, Vt

    mesh = for_file(made.mesh, ".glb")  # y up
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
    shape.CreateNormalsAttr(Vt.Vec3fArray.FromNumpy(np.asarray(mesh.normals, np.float32)))
    shape.SetNormalsInterpolation(UsdGeom.Tokens.vertex)
    shape.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    shape.CreateExtentAttr([Gf.Vec3f(*map(float, low)), Gf.Vec3f(*map(float, high))])
    places = UsdGeom.PrimvarsAPI(shape).CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, UsdGeom.Tokens.vertex)
    places.Set(Vt.Vec2fArray.FromNumpy(made.uv.astype(np.float32)))
    material = UsdShade.Material.Define(stage, "/scan/material")
    reader = UsdShade.Shader.Define(stage, "/scan/material/st")
    reader.CreateIdAttr("UsdPrimvarReader_float2")
    reader.CreateInput("varname", Sdf.ValueTypeNames.String).Set("st")
    picture = UsdShade.Shader.Define(stage, "/scan/material/picture")
    picture.CreateIdAttr("UsdUVTexture")
    picture.CreateInput("file", Sdf.ValueTypeNames.Asset).Set("texture.png")
    picture.CreateInput("st", Sdf.ValueTypeNames.Float2).ConnectToSource(
        reader.CreateOutput("result", Sdf.ValueTypeNames.Float2)
    )
    surface = UsdShade.Shader.Define(stage, "/scan/material/surface")
    surface.CreateIdAttr("UsdPreviewSurface")
    surface.CreateInput("roughness", Sdf.ValueTypeNames.Float).Set(1.0)
    surface.CreateInput("metallic", Sdf.ValueTypeNames.Float).Set(0.0)
    surface.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).ConnectToSource(
        picture.CreateOutput("rgb", Sdf.ValueTypeNames.Float3)
    )
    material.CreateSurfaceOutput().ConnectToSource(surface.CreateOutput("surface", Sdf.ValueTypeNames.Token))
    UsdShade.MaterialBindingAPI.Apply(shape.GetPrim()).Bind(material)
    stage.GetRootLayer().Save()
