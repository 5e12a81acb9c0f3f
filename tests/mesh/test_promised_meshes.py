"""A mesh file gives all that it promises, or one line that says where it does not."""

import json
import struct

import numpy as np
import pytest
import trimesh

from fusion.errors import MeshError
from fusion.mesh.files import read_mesh, write_mesh
from fusion.mesh.mesh import Mesh

PLY = (
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    "element face 2\nproperty list uchar int vertex_indices\nend_header\n"
    "0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n"
)
PCD = (
    "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 3\nHEIGHT 1\n"
    "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 3\nDATA ascii\n0 0 0\n1 0 0\n0 1 0\n"
)
OBJ = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n"
OFF = "OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n"
FACET = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
STL = f"solid a\n{FACET}endsolid a\n"
XYZ = "0 0 0\n1 0 0\n0 1 0\n"
GOOD = {".ply": PLY, ".pcd": PCD, ".obj": OBJ, ".off": OFF, ".stl": STL, ".xyz": XYZ}


BROKEN = {
    "a face less.ply": (PLY.replace("face 2", "face 3"), "2 of 3 lines of element face"),
    "faces short.ply": (PLY[: PLY.rindex("3 0 2 3")], "1 of 2 lines"),
    "a milliard.ply": (PLY.replace("face 2", "face 1000000000"), "of 1000000000 lines"),
    "more.ply": (PLY.replace("face 2", "face 1"), "line 15.*the end of the file"),
    "two numbers.ply": (PLY.replace("1 1 0", "1 1"), "line 12: '1 1', where 3 numbers"),
    "a word.ply": (PLY.replace("1 1 0", "1 1 abc"), "line 12"),
    "half index.ply": (PLY.replace("3 0 1 2", "3 0 1.5 2"), "line 14.*whole numbers"),
    "short list.ply": (PLY.replace("3 0 1 2", "4 0 1 2"), "line 14.*5 numbers"),
    "two corners.ply": (PLY.replace("3 0 1 2", "2 0 1"), "a face of 2 corners"),
    "strips.ply": (PLY.replace("element face", "element tristrips"), "strips"),
    "no format.ply": (PLY.replace("format ascii 1.0\n", ""), "without format"),
    "no end.ply": (PLY.replace("end_header\n", ""), "without its end"),
    "digits.ply": (PLY.replace("vertex 4", "vertex " + "4" * 400), "line 3 of the header"),
    "short.pcd": (PCD[: PCD.index("1 0 0\n0 1")], "1 of 3 points"),
    "long.pcd": (PCD + "5 5 5\n", "line 15"),
    "columns.pcd": (PCD.replace("\n1 0 0", "\n1 0"), "line 13: '1 0', where 3"),
    "word.pcd": (PCD.replace("\n1 0 0", "\n1 0 x"), "line 13"),
    "points.pcd": (PCD.replace("POINTS 3", "POINTS 2"), "POINTS 2, but WIDTH 3"),
    "zero.obj": (OBJ.replace("f 1 2 3", "f 0 1 2"), "line 5: 'f 0 1 2'.*from 1 to 4"),
    "beyond.obj": (OBJ.replace("f 1 2 3", "f 1 2 5"), "line 5"),
    "back.obj": (OBJ.replace("f 1 2 3", "f -1 -2 -5"), "line 5"),
    "vertex.obj": (OBJ.replace("v 0 1 0", "v 0"), "line 4"),
    "edge.obj": (OBJ.replace("f 1 2 3", "f 1 2"), "line 5: 'f 1 2'"),
    "word.obj": (OBJ.replace("f 1 2 3", "f 1 2 x"), "line 5"),
    "cut.stl": (STL[: STL.index("endloop")], "endsolid"),
    "corner.stl": (STL.replace("vertex 1 0 0\n", ""), "line 6: 'endloop', where vertex"),
    "number.stl": (STL.replace("vertex 1 0 0", "vertex 1 0"), "line 5"),
    "binary.stl": (b"\1" * 80 + struct.pack("<I", 3) + b"\0" * 50, "3 triangles promised"),
    "short.off": (OFF[: OFF.rindex("3 0 2 3")], "5 lines for 4 vertices and 2 faces"),
    "index.off": (OFF.replace("3 0 1 2", "3 0 1"), "line 7"),
    "column.off": (OFF.replace("1 1 0", "1 1"), "line 5"),
    "cut.asc": ("4\n" + XYZ, "3 of 4 points"),
    "grid.asc": ("ncols 3\nnrows 1\n1 2 3\n", "line 1"),
    "column.xyz": (XYZ.replace("1 0 0", "1 0"), "line 2"),
    "word.xyz": (XYZ.replace("1 0 0", "1 0 x"), "line 2"),
}


@pytest.mark.parametrize("name", BROKEN)
def test_what_is_missing_is_told_with_its_line(tmp_path, name):
    content, told = BROKEN[name]
    path = tmp_path / name
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    with pytest.raises(MeshError, match=told):
        read_mesh(path)


@pytest.mark.parametrize("ending", GOOD)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_text_is_read_however_it_was_saved(tmp_path, ending, encoding, end):
    (tmp_path / "plain").with_suffix(ending).write_text(GOOD[ending])
    (tmp_path / "other").with_suffix(ending).write_bytes(GOOD[ending].replace("\n", end).encode(encoding))
    plain, other = (read_mesh((tmp_path / name).with_suffix(ending)) for name in ("plain", "other"))
    np.testing.assert_array_equal(other.vertices, plain.vertices)
    np.testing.assert_array_equal(other.faces, plain.faces)


def test_points_that_were_not_measured_are_left_out_and_told(tmp_path):
    (tmp_path / "a.pcd").write_text(PCD.replace("\n1 0 0", "\nnan nan nan"))
    notes: list[str] = []
    assert len(read_mesh(tmp_path / "a.pcd", notes).vertices) == 2
    assert "1 vertices that are not finite" in notes[0]


def test_indices_of_obj_count_back_from_where_they_stand(tmp_path):
    (tmp_path / "a.obj").write_text(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 5 5 5\nv 6 5 5\nv 5 6 5\nf -3/1 -2/2 -1/3\n"
    )
    assert read_mesh(tmp_path / "a.obj").faces.tolist() == [[0, 1, 2], [3, 4, 5]]


@pytest.mark.parametrize("order", ["little", "big"])
def test_binary_polygons_of_different_lengths(tmp_path, order):
    sign = "<" if order == "little" else ">"
    head = PLY[: PLY.index("end_header\n") + 11].replace("ascii", f"binary_{order}_endian")
    corners = struct.pack(f"{sign}12f", 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0)
    faces = struct.pack(f"{sign}B4iB3i", 4, 0, 1, 2, 3, 3, 0, 1, 2)
    path = tmp_path / "a.ply"
    path.write_bytes(head.encode() + corners + faces)
    faces_read = [tuple(np.roll(face, -face.argmin())) for face in read_mesh(path).faces]
    assert sorted(faces_read) == [(0, 1, 2), (0, 1, 2), (0, 2, 3)]
    for length in range(1, len(faces)):
        path.write_bytes(head.encode() + corners + faces[:length])
        with pytest.raises(MeshError):
            read_mesh(path)
    path.write_bytes(head.encode() + corners + faces + b"\1")
    with pytest.raises(MeshError, match="1 bytes more"):
        read_mesh(path)


def test_compressed_points(tmp_path, capfd):
    plain = np.arange(9, dtype="<f4").tobytes()  # field by field
    packed = bytes([31]) + plain[:32] + bytes([3]) + plain[32:]  # as they are
    head = PCD[: PCD.index("ascii")].encode() + b"binary_compressed\n"
    path = tmp_path / "a.pcd"
    path.write_bytes(head + struct.pack("<II", len(packed), len(plain)) + packed)
    np.testing.assert_array_equal(read_mesh(path).vertices, np.arange(9.0).reshape(3, 3).T)
    # cut off, a repetition of what is not there, too much, too little, another size promised
    for wrong in (packed[:-1], b"\x20\x00" + packed, packed + b"\x00a", packed[:33]):
        path.write_bytes(head + struct.pack("<II", len(wrong), len(plain)) + wrong)
        with pytest.raises(MeshError, match="0 of 3 points could be read"):
            read_mesh(path)
    path.write_bytes(head + struct.pack("<II", len(packed), 10**9) + packed)
    with pytest.raises(MeshError, match="1000000000 promised"):
        read_mesh(path)
    assert capfd.readouterr() == ("", "")


def test_pcd_of_open3d_comes_back_compressed_too(tmp_path):
    open3d = pytest.importorskip("open3d")
    random = np.random.default_rng(1)
    points, colors = np.round(random.normal(size=(500, 3)), 1), random.integers(0, 256, (500, 3)).astype(np.uint8)
    cloud = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(points))
    cloud.colors = open3d.utility.Vector3dVector(colors / 255)
    for kind in ({}, {"write_ascii": True}, {"compressed": True}):
        open3d.io.write_point_cloud(tmp_path / "a.pcd", cloud, **kind)
        again = read_mesh(tmp_path / "a.pcd")
        np.testing.assert_allclose(again.vertices, points, atol=1e-6)
        np.testing.assert_array_equal(again.colors, colors)


def test_what_open3d_would_take_for_zeros_or_write_beyond_its_memory(tmp_path):
    path = tmp_path / "a.pcd"
    header = PCD[: PCD.index("0 0 0\n1 0 0")]
    rows = struct.pack("<3d", 1, 2, 3) * 3
    path.write_bytes(header.replace("SIZE 4 4 4", "SIZE 8 8 8").replace("ascii", "binary").encode() + rows)
    with pytest.raises(MeshError, match="field x of 8 bytes a number"):
        read_mesh(path)
    # a part of a normal, one name twice, a colour of two bytes: left out
    many = header.replace("x y z", "x y z normal_x normal_y rgb").replace("SIZE 4 4 4", "SIZE 4 4 4 4 4 2")
    many = many.replace("TYPE F F F", "TYPE F F F F F U").replace("COUNT 1 1 1", "COUNT 1 1 1 1 1 1")
    path.write_text(many + "1 2 3 0 1 7\n" * 3)
    mesh = read_mesh(path)
    assert mesh.normals is None and mesh.colors is None
    path.write_text(many.replace("y z n", "x z n") + "1 2 3 0 1 7\n" * 3)
    with pytest.raises(MeshError, match="one x, y and z"):
        read_mesh(path)
    colored = many.replace("4 4 4 2", "4 4 4 4")
    path.write_text(colored + "1 2 3 0 1 7\n1 2 3 0 1 010\n1 2 3 0 1 7\n")  # which strtol takes for 8
    with pytest.raises(MeshError, match=r"line 13.*rgb as a whole number"):
        read_mesh(path)


def test_triangles_that_are_lines_are_left_out_once_corners_are_joined(tmp_path):
    flat = FACET.replace("vertex 0 1 0", "vertex 1 0 0")
    (tmp_path / "a.stl").write_text(f"solid a\n{FACET}{flat}endsolid a\n")
    assert read_mesh(tmp_path / "a.stl").faces.tolist() == [[0, 1, 2]]


@pytest.mark.parametrize("brightest", [1.0, 255.0])
def test_colors_of_obj_reach_to_one_or_255(tmp_path, brightest):
    lines = [f"v {x} 0 0 {0.2 * brightest:g} 0 {brightest:g}" for x in range(3)]
    (tmp_path / "a.obj").write_text("\n".join([*lines, "v 0 1 0 0 0 0", "f 1 2 4", "f 2 3 4"]))
    assert read_mesh(tmp_path / "a.obj").colors.tolist() == [[51, 0, 255]] * 3 + [[0, 0, 0]]


def glb(change) -> bytes:
    """A box as GLB, its tree changed."""
    data = trimesh.creation.box().export(file_type="glb")
    (first,) = struct.unpack("<I", data[12:16])
    tree = json.loads(data[20 : 20 + first])
    change(tree)
    text = json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    rest = data[20 + first :]
    return data[:8] + struct.pack("<II", 20 + len(text) + len(rest), len(text)) + data[16:20] + text + rest


def no_view(tree):
    del tree["accessors"][tree["meshes"][0]["primitives"][0]["attributes"]["POSITION"]]["bufferView"]


def many(tree):
    tree["accessors"].append({"count": 10**12, "componentType": 5126, "type": "MAT4"})


def twice(tree):
    tree["nodes"].append({"children": [0, 0]})
    tree["scenes"][0]["nodes"] = [len(tree["nodes"]) - 1]


def long(tree):
    tree["accessors"][0]["count"] += 1000


def fan(tree):
    tree["meshes"][0]["primitives"][0]["mode"] = 6


def packed(tree):
    tree["extensionsRequired"] = ["KHR_draco_mesh_compression"]


def flat(tree):
    tree["accessors"][tree["meshes"][0]["primitives"][0]["attributes"]["POSITION"]]["type"] = "VEC2"


def pairs(tree):
    tree["accessors"][tree["meshes"][0]["primitives"][0]["indices"]]["type"] = "VEC2"


TREES = {
    flat: "VEC2 instead of VEC3",
    pairs: "VEC2 instead of SCALAR|rows in",
    no_view: "packed in a way",
    many: "too large",
    twice: "two places",
    long: "rows in",
    fan: "mode 6",
    packed: "draco",
}


@pytest.mark.parametrize("change", TREES, ids=lambda change: change.__name__)
def test_what_trimesh_would_take_for_zeros_or_leave_out(tmp_path, change):
    (tmp_path / "a.glb").write_bytes(glb(change))
    with pytest.raises(MeshError, match=TREES[change]):
        read_mesh(tmp_path / "a.glb")


def test_a_gltf_names_only_what_lies_beside_it(tmp_path):
    home = tmp_path / "home"
    home.mkdir()
    written = trimesh.creation.box().export(file_type="gltf")
    for name, data in written.items():
        (home / name).write_bytes(data)
    assert len(read_mesh(home / "model.gltf").vertices) == 8
    buffer = next(name for name in written if name.endswith(".bin"))
    (home / buffer).rename(tmp_path / buffer)
    text = (home / "model.gltf").read_text()
    (home / "model.gltf").write_text(text.replace(buffer, f"../{buffer}"))
    with pytest.raises(MeshError, match="outside its folder"):
        read_mesh(home / "model.gltf")


@pytest.mark.parametrize("ending", [".ply", ".obj", ".stl", ".off", ".glb", ".pcd", ".xyz", ".asc"])
def test_any_mutation_is_a_mesh_or_one_line(tmp_path, ending, capfd):
    path, random = (tmp_path / "a").with_suffix(ending), np.random.default_rng(7)
    ball = trimesh.creation.icosphere(subdivisions=1, radius=0.1)
    write_mesh(path, Mesh(np.asarray(ball.vertices), np.asarray(ball.faces, np.int32)))
    good = path.read_bytes()
    for _ in range(150):
        data = bytearray(good)
        for _ in range(random.integers(1, 5)):
            # headers twice as often as the rest
            at = random.integers(min(200, len(data)) if random.random() < 0.5 else len(data))
            data[at] = random.integers(256) if random.random() < 0.5 else ord(random.choice(list("0123456789 \n-.ef")))
        path.write_bytes(data[: random.integers(len(data))] if random.random() < 0.2 else data)
        try:
            mesh = read_mesh(path, [])
        except MeshError as error:
            assert "\n" not in str(error)
        else:
            assert np.isfinite(mesh.vertices).all()
    assert capfd.readouterr() == ("", "")


def test_a_face_of_a_million_corners_is_no_face(tmp_path):
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf" + " 1 2 3" * 100_000 + "\n")
    with pytest.raises(MeshError, match="line 4: a face of 599,999 characters"):
        read_mesh(tmp_path / "a.obj")
