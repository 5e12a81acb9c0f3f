"""USDZ with the picture in it, which phones of Apple show in a room."""

import tempfile
from pathlib import Path

import numpy as np

from fusion.files.output.publish import atomic_file
from fusion.mesh.formats.conventions import for_file
from fusion.mesh.formats.usdz import packed, stage_of, usd_library
from fusion.texture.files import png
from fusion.texture.textured import Textured


def write_usdz(path: Path, made: Textured) -> None:
    """One file with the picture in it; metres, y up, and the file says so.

    Raises:
        MeshError: usd-core is not installed, or refuses.
    """
    usd_library(path)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "texture.png").write_bytes(png(made))
        _stage(folder / "scan.usdc", made)
        with atomic_file(path) as partial:
            partial.write_bytes(packed(folder, path))


def _stage(path: Path, made: Textured) -> None:
    """The scene: one mesh with a material whose colour is the picture."""
    from pxr import Sdf, UsdGeom, UsdShade, Vt

    stage, shape = stage_of(path, for_file(made.mesh, ".usdz"))
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
