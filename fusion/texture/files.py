"""Textured meshes as files: GLB, OBJ with its MTL and PNG, USDZ."""

import io
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fusion.files.output.publish import atomic_file
from fusion.mesh.formats.conventions import for_file
from fusion.mesh.formats.single import check_single
from fusion.mesh.formats.usdz import packed, stage_of, usd_library
from fusion.texture.textured import Textured

if TYPE_CHECKING:
    from PIL.Image import Image

SEVEN_DIGITS = 100.0  # [m] below this they are exact to 5 micrometres


def write_glb(path: Path, made: Textured) -> None:
    """One file with the picture in it; metres, y up, as viewers take it.

    Raises:
        MeshError: the mesh lies too far from the origin for 32 bits a coordinate.
    """
    import trimesh

    check_single(path, made.mesh)
    material = trimesh.visual.material.PBRMaterial(
        name="texture", baseColorTexture=_picture(made), metallicFactor=0.0, roughnessFactor=1.0
    )
    mesh = for_file(made.mesh, ".glb")
    whole = trimesh.Trimesh(
        mesh.vertices,
        mesh.faces,
        vertex_normals=np.asarray(mesh.normals, float),
        visual=trimesh.visual.TextureVisuals(made.uv, material=material),
        process=False,
    )
    data: Any = whole.export(file_type="glb", include_normals=True)
    with atomic_file(path) as partial:
        partial.write_bytes(data)


def write_obj(path: Path, made: Textured) -> None:
    """OBJ in metres, z up, beside it the material and the picture under the same name (.mtl, .png)."""
    mesh, stem = made.mesh, path.stem
    with atomic_file(path.with_suffix(".png")) as partial:
        partial.write_bytes(png(made))
    with atomic_file(path.with_suffix(".mtl")) as partial:
        text = f"newmtl texture\nKa 1 1 1\nKd 1 1 1\nKs 0 0 0\nillum 1\nmap_Kd {stem}.png\n"
        partial.write_text(text, encoding="utf-8")
    corners = mesh.faces + 1
    lines = [f"mtllib {stem}.mtl", "usemtl texture"]
    digits = 7 if np.abs(mesh.vertices).max(initial=0.0) < SEVEN_DIGITS else 15
    lines += [f"v {x:.{digits}g} {y:.{digits}g} {z:.{digits}g}" for x, y, z in mesh.vertices.tolist()]
    lines += [f"vt {u:.7g} {v:.7g}" for u, v in made.uv.tolist()]
    lines += [f"vn {x:.5g} {y:.5g} {z:.5g}" for x, y, z in np.asarray(mesh.normals).tolist()]
    lines += [f"f {a}/{a}/{a} {b}/{b}/{b} {c}/{c}/{c}" for a, b, c in corners.tolist()]
    with atomic_file(path) as partial:
        partial.write_text("\n".join([*lines, ""]), encoding="utf-8")


def png(made: Textured) -> bytes:
    """The picture as a PNG file."""
    out = io.BytesIO()
    _picture(made).save(out, "PNG")
    return out.getvalue()


def _picture(made: Textured) -> "Image":
    from PIL import Image

    return Image.fromarray(np.ascontiguousarray(made.image))


def write_usdz(path: Path, made: Textured) -> None:
    """One file with the picture in it; metres, y up, and the file says so.

    Raises:
        MeshError: usd-core is not installed, or refuses, or the mesh lies too far from the origin for 32 bits.
    """
    usd_library(path)
    check_single(path, made.mesh)
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
