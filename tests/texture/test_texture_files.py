"""Textured files read by others' readers (trimesh, Open3D, Pixar's USD): the same colour at the same place."""

import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "coloring"))
from painted import HALF, cube, off, paint, scene

from fusion import read_mesh, write_mesh, write_recording
from fusion.commands.main import main
from fusion.errors import FusionError, MeshError
from fusion.geometry import pose
from fusion.mesh.formats.conventions import for_file
from fusion.mesh.mesh import Mesh
from fusion.recording.native.trajectory_file import write_trajectory
from fusion.texture.files import write_glb, write_obj, write_usdz
from fusion.texture.other_mesh import apart, read_other
from fusion.texture.result_folder import open_result
from fusion.texture.textured import texture_mesh
from fusion.texture.views import Views

NEAR = 6  # [counts] the paint at a millimetre's distance, and what bilinear looks differ by


@pytest.fixture(scope="module")
def taken():
    return scene(lambda _: [cube()])


@pytest.fixture(scope="module")
def made(taken):
    return texture_mesh(off(cube(), 0.001), [(taken.recording, taken.poses)], triangles=1500)


@pytest.fixture
def result(tmp_path, taken):
    """A result folder, as far as a texture needs one."""
    write_recording(tmp_path / "scan", taken.recording.camera, taken.recording)
    folder = tmp_path / "out"
    folder.mkdir()
    write_mesh(folder / "mesh.ply", off(cube(), 0.001))
    write_trajectory(folder / "trajectory.txt", taken.poses)
    camera = {key: getattr(taken.recording.camera, key) for key in ("fx", "fy", "cx", "cy")}
    settings = {"recording": str(tmp_path / "scan"), "camera": camera}
    (folder / "settings.json").write_text(json.dumps(settings))
    return folder


def wrong_at_middles(vertices, faces, corner_uv, image):
    """Median difference [counts] from the paint at the middles of triangles that a camera saw, by a picture's colours.

    Args:
        vertices, faces: z up [m].
        corner_uv: (m, 3, 2), v upwards.
        image: (h, w, 3), top row first.
    """
    middle, (u, v) = vertices[faces].mean(axis=1), corner_uv.mean(axis=1).T
    h, w = image.shape[:2]
    rows = np.clip(((1 - v) * h).astype(int), 0, h - 1)
    colors = image[rows, np.clip((u * w).astype(int), 0, w - 1)].astype(float)
    seen = middle[:, 2] > -HALF + 0.01
    return np.median(np.abs(colors - paint(np.clip(middle, -HALF, HALF))).max(axis=1)[seen])


def test_glb_by_trimesh_is_y_up_with_the_picture_in_it(tmp_path, made):
    write_glb(tmp_path / "a.glb", made)
    found = trimesh.load(tmp_path / "a.glb", force="mesh", process=False)
    assert len(found.faces) == len(made.mesh.faces)
    z_up = found.vertices @ np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])  # rows: x, y up, z towards us
    np.testing.assert_allclose(z_up, made.mesh.vertices, atol=1e-6)
    image = np.asarray(found.visual.material.baseColorTexture)[..., :3]
    np.testing.assert_array_equal(image, made.image)
    assert wrong_at_middles(z_up, found.faces, found.visual.uv[found.faces], image) < NEAR


def test_obj_by_open3d_finds_its_picture(tmp_path, made):
    import open3d as o3d

    write_obj(tmp_path / "a.obj", made)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.mtl", "a.obj", "a.png"]
    found = o3d.io.read_triangle_mesh(str(tmp_path / "a.obj"), True)
    vertices, faces = np.asarray(found.vertices), np.asarray(found.triangles)
    image, uv = np.asarray(found.textures[0])[::-1], np.asarray(found.triangle_uvs).reshape(-1, 3, 2)
    # Open3D keeps pictures upside down for OpenGL, or not, by its release: one way the paint fits
    assert min(wrong_at_middles(vertices, faces, uv, one) for one in (image, image[::-1])) < NEAR
    by_trimesh = trimesh.load(tmp_path / "a.obj", process=False)
    picture = np.asarray(by_trimesh.visual.material.image.convert("RGB"))
    assert wrong_at_middles(by_trimesh.vertices, by_trimesh.faces, by_trimesh.visual.uv[by_trimesh.faces], picture) < 6


def test_obj_and_glb_are_references_too(tmp_path, made):
    """What others textured is read: the seams, where corners are there twice, are joined again."""
    write_obj(tmp_path / "a.obj", made)
    write_glb(tmp_path / "a.glb", made)
    obj, glb = read_mesh(tmp_path / "a.obj"), read_mesh(tmp_path / "a.glb")
    for mesh in (obj, glb):
        assert len(mesh.faces) == len(made.mesh.faces) and len(mesh.vertices) < len(made.mesh.vertices)
        assert mesh.to_trimesh().is_watertight and mesh.to_trimesh().volume == pytest.approx(8 * 0.101**3, rel=0.005)


def test_usdz_says_metres_and_y_up_and_passes_its_makers_checks(tmp_path, made):
    from pxr import Usd, UsdGeom, UsdShade, UsdValidation

    write_usdz(tmp_path / "a.usdz", made)
    stage = Usd.Stage.Open(str(tmp_path / "a.usdz"))
    assert UsdGeom.GetStageUpAxis(stage) == "Y" and UsdGeom.GetStageMetersPerUnit(stage) == 1
    (shape,) = [prim for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh)]
    vertices = np.asarray(UsdGeom.Mesh(shape).GetPointsAttr().Get())
    np.testing.assert_allclose(np.ptp(vertices, axis=0), 0.202, atol=0.001)
    z_up = vertices @ np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])
    faces = np.asarray(UsdGeom.Mesh(shape).GetFaceVertexIndicesAttr().Get()).reshape(-1, 3)
    uv = np.asarray(UsdGeom.PrimvarsAPI(shape).GetPrimvar("st").Get())[faces]
    assert wrong_at_middles(z_up, faces, uv, made.image) < NEAR
    assert UsdShade.MaterialBindingAPI(shape).ComputeBoundMaterial()[0]
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    errors = UsdValidation.ValidationContext(validators).Validate(stage)
    assert len(validators) > 20 and not [error.GetErrorAsString() for error in errors]


def test_the_command_makes_a_folder(result, tmp_path, capsys):
    out = tmp_path / "textured"
    assert main(["texture", str(result), "-o", str(out), "--usdz", "--triangles", "1500"]) == 0
    told = capsys.readouterr().out
    assert "1,500 triangles" in told and str(out / "textured.glb") in told
    names = {path.name for path in out.iterdir()}
    assert names >= {f"textured.{end}" for end in ("glb", "obj", "mtl", "png", "usdz")} | {"texture.json"}
    page = (out / "report.html").read_text()
    assert (
        "Beside photographs" in page and page.count("data:image/webp") == 2 * 4 + 1 and str(out / "report.html") in told
    )
    assert json.loads((out / "texture.json").read_text())["images"] > 5
    assert main(["texture", str(result), "-o", str(out)]) == 1  # an earlier result stays unless told
    assert (
        main(["texture", str(result), "-o", str(out), "--overwrite", "--json", "--triangles", "1500", "--no-report"])
        == 0
    )
    assert not (out / "textured.usdz").exists() and not (out / "report.html").exists()


def test_a_merge_takes_the_images_of_all_passes(result, capsys):
    settings = json.loads((result / "settings.json").read_text())
    both = {"passes": [settings["recording"]] * 2, "cameras": [settings["camera"]] * 2}
    (result / "settings.json").write_text(json.dumps(both))
    for k in (1, 2):
        (result / f"trajectory_{k}.txt").write_text((result / "trajectory.txt").read_text())
    (result / "trajectory.txt").unlink()
    mesh, taken = open_result(result)
    assert len(taken) == 2 and all(course.valid.all() for _, course in taken)
    assert len(Views.of(taken).frames) == 2 * len(taken[0][0]) and len(mesh.faces)
    (result / "settings.json").write_text(json.dumps(both | {"cameras": both["cameras"][:1]}))
    assert main(["texture", str(result), "-o", str(result.with_name("t"))]) == 1
    assert "does not say what it was made of" in capsys.readouterr().err


def test_broken_results_are_one_line_and_leave_nothing(result, tmp_path, capsys, monkeypatch):
    out = tmp_path / "textured"

    def refused(words, *more):
        assert main(["texture", str(result), "-o", str(out), *more]) == 1
        said = capsys.readouterr().err
        assert words in said and said.count("\n") == 1 and not out.exists()

    monkeypatch.setitem(sys.modules, "pxr", None)
    refused('pip install "fusion-scan[usd]"', "--usdz")
    settings = json.loads((result / "settings.json").read_text())
    (result / "settings.json").write_text(json.dumps(settings | {"recording": "gone"}))
    refused("--recording")
    (result / "settings.json").write_text("{}")
    refused("does not say what it was made of")
    (result / "settings.json").write_text(json.dumps(settings))
    depth_only = tmp_path / "scan"
    (depth_only / "rgb.txt").unlink()
    refused("no colour image")
    (result / "settings.json").unlink()
    refused("no result with a mesh")


def test_without_the_library_usdz_is_refused(tmp_path, made, monkeypatch):
    monkeypatch.setitem(sys.modules, "pxr", None)
    with pytest.raises(MeshError, match=r"fusion-scan\[usd\]"):
        write_usdz(tmp_path / "a.usdz", made)
    assert not list(tmp_path.iterdir())


def test_another_mesh_lies_on_the_scan_or_is_refused(result, tmp_path, capsys):
    """What fusion convert writes is taken in any format; another object, another unit, another place are not."""
    scan = read_mesh(result / "mesh.ply")
    write_mesh(tmp_path / "own.stl", for_file(scan, ".stl"))
    write_mesh(tmp_path / "own.glb", for_file(scan, ".glb"))
    bare = Mesh(scan.vertices, scan.faces[: len(scan.faces) // 2])  # three sides of six
    write_mesh(tmp_path / "cut.ply", bare)
    for name in ("own.stl", "own.glb", "cut.ply"):
        assert np.abs(apart(scan, read_other(tmp_path / name, scan))).max() < 1e-5
    ball = trimesh.creation.icosphere(3, HALF)
    others = {
        "ball.ply": Mesh(np.array(ball.vertices), np.array(ball.faces, np.int32)),
        "mm.ply": Mesh(1000 * scan.vertices, scan.faces),
        "lifted.ply": Mesh(scan.vertices + np.array([0, 0, 1.0]), scan.faces),
    }
    for name, other in others.items():
        write_mesh(tmp_path / name, other)
        out = tmp_path / "textured"
        assert main(["texture", str(result), "-o", str(out), "--mesh", str(tmp_path / name)]) == 1
        told = capsys.readouterr().err
        assert "does not lie on the scan" in told and name in told and told.count("\n") == 1 and not out.exists()
    assert "found 0.3499 m from end to end, " in told and "in its place, 0.3499 m, within 3.5 mm" in told


def test_a_mesh_that_was_moved_a_little_is_refused(result, tmp_path, capsys):
    """Most of it lies within a hundredth of its size: it was painted, and the images stood beside it."""
    scan = read_mesh(result / "mesh.ply")
    turn = pose.about_axis(scan.vertices.mean(axis=0), [0, 0, 1], np.deg2rad(1.5))
    write_mesh(tmp_path / "moved.ply", Mesh(scan.vertices + np.array([0.002, 0, 0.001]), scan.faces))
    write_mesh(tmp_path / "turned.ply", Mesh(pose.transform(turn, scan.vertices), scan.faces))
    for name, told in (("moved", "moved by 2.24 mm"), ("turned", "turned by 1.50 deg")):
        out = tmp_path / "textured"
        assert main(["texture", str(result), "-o", str(out), "--mesh", str(tmp_path / f"{name}.ply")]) == 1
        said = capsys.readouterr().err
        assert told in said and said.count("\n") == 1 and not out.exists()
    larger = Mesh(scan.vertices * 1.006, scan.faces, scan.normals)  # no motion undoes that
    write_mesh(tmp_path / "larger.ply", larger)
    assert len(read_other(tmp_path / "larger.ply", scan).faces) == len(scan.faces)


def test_how_far_another_mesh_is_off_is_told(taken):
    """The picture is laid on a box 1 mm too large: that is told, not by how much thinning out moved it."""
    good = [(taken.recording, taken.poses)]
    made = texture_mesh(off(cube(), 0.001), good, triangles=500, scan=cube())
    assert made.moved[0] == pytest.approx(0.001, rel=0.05)
    with pytest.raises(MeshError, match="no image shows the mesh"):
        texture_mesh(Mesh(cube().vertices + np.array([0, 0, 9.0]), cube().faces, cube().normals), good, triangles=500)


def test_a_recording_without_a_camera_has_that_of_the_result(result, taken):
    (result.parent / "scan" / "camera.json").unlink()
    _, [(recording, course)] = open_result(result)
    assert recording.camera.fx == taken.recording.camera.fx and recording.camera.cy == taken.recording.camera.cy
    assert course.valid.all()
    (result / "settings.json").write_text(json.dumps({"recording": str(result.parent / "scan")}))
    with pytest.raises(FusionError, match="has no camera"):
        open_result(result)


def test_far_from_the_origin_obj_gets_more_digits_and_32_bits_are_refused(tmp_path, made):
    """In the coordinates of a survey; seven digits are 1 m there."""
    far = replace(made, mesh=replace(made.mesh, vertices=made.mesh.vertices + np.array([4.5e5, 5.4e6, 300.0])))
    write_obj(tmp_path / "far.obj", far)
    again = trimesh.load(tmp_path / "far.obj", process=False, maintain_order=True)
    np.testing.assert_allclose(again.bounds, [far.mesh.vertices.min(axis=0), far.mesh.vertices.max(axis=0)], atol=2e-9)
    with pytest.raises(MeshError, match="GLB holds coordinates in 32 bits"):
        write_glb(tmp_path / "far.glb", far)
    assert not (tmp_path / "far.glb").exists()
