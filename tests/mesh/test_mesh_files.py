"""Files come back as they were written; broken files are one clear error."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh

from fusion.errors import MeshError
from fusion.mesh.files import read_mesh, write_mesh
from fusion.mesh.mesh import Mesh

HEADER = """ply
format ascii 1.0
element vertex 4
property float x
property float y
property float z
element face {faces}
property list uchar int vertex_indices
end_header
"""
SQUARE = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n"


@pytest.fixture
def sphere() -> Mesh:
    ball = trimesh.creation.icosphere(subdivisions=2, radius=0.1)
    rng = np.random.default_rng(1)
    count = len(ball.vertices)
    return Mesh(
        vertices=np.asarray(ball.vertices) + 0.2,
        faces=np.asarray(ball.faces, np.int32),
        normals=np.asarray(ball.vertex_normals, np.float32),
        colors=rng.integers(0, 256, (count, 3)).astype(np.uint8),
        scalars={"signed_distance": rng.normal(size=count).astype(np.float32)},
    )


def test_ply_holds_everything(tmp_path, sphere):
    write_mesh(tmp_path / "a.ply", sphere)
    again = read_mesh(tmp_path / "a.ply")
    np.testing.assert_allclose(again.vertices, sphere.vertices, atol=2e-8)  # float32 below 0.5 m
    np.testing.assert_array_equal(again.faces, sphere.faces)
    np.testing.assert_array_equal(again.normals, sphere.normals)
    np.testing.assert_array_equal(again.colors, sphere.colors)
    np.testing.assert_array_equal(again.scalars["signed_distance"], sphere.scalars["signed_distance"])
    head = (tmp_path / "a.ply").read_bytes()[:600]
    assert b"unit: metre" in head
    assert b"property float scalar_signed_distance" in head  # CloudCompare's naming of a scalar field


def test_ply_far_from_the_origin_keeps_micrometres(tmp_path, sphere):
    far = replace(sphere, vertices=sphere.vertices + 5e5)
    write_mesh(tmp_path / "far.ply", far)
    np.testing.assert_allclose(read_mesh(tmp_path / "far.ply").vertices, far.vertices, atol=1e-9)  # float64 at 5e5


@pytest.mark.parametrize("ending", ["obj", "stl", "glb", "off"])
def test_triangle_formats_keep_the_surface(tmp_path, sphere, ending):
    write_mesh(tmp_path / f"a.{ending}", sphere)
    again = read_mesh(tmp_path / f"a.{ending}")
    assert len(again.vertices) == len(sphere.vertices)  # corners joined again
    corners = again.vertices[again.faces]
    np.testing.assert_allclose(corners, sphere.vertices[sphere.faces], atol=2e-8)  # float32 or 8 digits


@pytest.mark.parametrize("ending", ["ply", "pcd", "xyz", "asc", "obj", "glb"])
def test_point_clouds(tmp_path, sphere, ending):
    cloud = replace(sphere, faces=np.zeros((0, 3), np.int32))
    write_mesh(tmp_path / f"c.{ending}", cloud)
    again = read_mesh(tmp_path / f"c.{ending}")
    assert again.faces.shape == (0, 3)
    np.testing.assert_allclose(again.vertices, cloud.vertices, atol=2e-8)
    if ending in ("ply", "pcd", "xyz", "asc"):
        np.testing.assert_allclose(again.normals, cloud.normals, atol=1e-6)


@pytest.mark.parametrize(
    "text",
    [
        "//X Y Z R G B\n3\n0 0 0 10 20 30\n1 0 0 10 20 30\n0 1 0.5 10 20 30\n",  # CloudCompare, all boxes ticked
        "0.0,0.0,0.0,10,20,30\r\n1.0,0.0,0.0,10,20,30\r\n0.0,1.0,0.5,10,20,30\r\n",
        "# scanner\n0;0;0;10;20;30\n\n1;0;0;10;20;30\n0;1;0.5;10;20;30",
    ],
)
def test_clouds_as_scanners_programs_write_them(tmp_path, text):
    (tmp_path / "part.ASC").write_bytes(text.encode())
    cloud = read_mesh(tmp_path / "part.ASC")
    assert cloud.vertices.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0.5]]
    assert cloud.colors.tolist() == [[10, 20, 30]] * 3


def test_polygons_become_triangles(tmp_path):
    (tmp_path / "q.ply").write_text(HEADER.format(faces=1) + SQUARE + "4 0 1 2 3\n")
    assert len(read_mesh(tmp_path / "q.ply").faces) == 2


def test_vertices_that_are_not_finite_go_with_their_faces(tmp_path):
    text = HEADER.format(faces=2) + SQUARE.replace("1 1 0", "1 nan 0") + "3 0 1 2\n3 0 1 3\n"
    (tmp_path / "n.ply").write_text(text)
    notes: list[str] = []
    mesh = read_mesh(tmp_path / "n.ply", notes)
    assert mesh.faces.tolist() == [[0, 1, 2]]
    assert len(mesh.vertices) == 3
    assert len(notes) == 1
    assert "1 vertices that are not finite" in notes[0]


BROKEN = {
    "empty.ply": b"",
    "noise.ply": bytes(range(256)) * 8,
    "noise.glb": bytes(range(256)) * 8,
    "noise.stl": bytes(range(256)) * 8,
    "noise.obj": bytes(range(256)) * 8,
    "noise.pcd": bytes(range(256)) * 8,
    "noise.xyz": bytes(range(256)) * 8,
    "noise.gltf": b"{",
    "index.ply": (HEADER.format(faces=1) + SQUARE + "3 0 1 9\n").encode(),
    "index.obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 7\n",
    "nan.obj": b"v nan 0 0\nv nan 0 0\nv nan 1 0\nf 1 2 3\n",
    "huge.xyz": b"0 0 0\n1e30 0 0\n",
    "ragged.xyz": b"0 0 0\n1 0\n",
    "promise.ply": HEADER.format(faces=1).replace("vertex 4", "vertex 99999999999999").encode() + SQUARE.encode(),
    "promise_b.ply": HEADER.format(faces=1).replace("ascii", "binary_little_endian").replace("4", "9" * 12).encode(),
    "promise.pcd": b"VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 999999999999\nHEIGHT 1\n"
    b"POINTS 999999999999\nDATA binary\nabc",
    "mesh.docx": b"hello",
}


@pytest.mark.parametrize("name", BROKEN)
def test_broken_files_are_one_line(tmp_path, name):
    (tmp_path / name).write_bytes(BROKEN[name])
    with pytest.raises(MeshError) as caught:
        read_mesh(tmp_path / name)
    assert "\n" not in str(caught.value)
    assert name in str(caught.value)


@pytest.mark.parametrize("ending", ["ply", "glb", "pcd"])
def test_truncated_files_are_an_error(tmp_path, sphere, ending):
    whole = tmp_path / f"a.{ending}"
    write_mesh(whole, sphere)
    data = whole.read_bytes()
    for length in (10, len(data) // 2, len(data) - 3):
        whole.write_bytes(data[:length])
        with pytest.raises(MeshError):
            read_mesh(whole)


def test_missing_file_and_wrong_names(tmp_path, sphere):
    with pytest.raises(MeshError, match="no such"):
        read_mesh(tmp_path / "nothing.ply")
    with pytest.raises(MeshError, match="folder"):
        read_mesh(tmp_path)
    with pytest.raises(MeshError, match="unknown"):
        write_mesh(tmp_path / "a.xls", sphere)
    with pytest.raises(MeshError, match="triangles"):
        write_mesh(tmp_path / "a.stl", Mesh(sphere.vertices))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("corners", ["-3/-3/-1 -2/-2/-1 -1/-1/-1", "-3//-1 -2//-1 -1//-1", "-3/-3 -2/-2 -1/-1"])
def test_obj_counts_back_from_the_face(tmp_path, corners):
    """Of places, textures and normals alike, as some exporters write all of them."""
    corner = "vt 0 0\nvt 1 0\nvt 0 1\nvn 0 0 1\n"
    path = tmp_path / "back.obj"
    path.write_text(f"v 0 0 0\nv 1 0 0\nv 0 1 0\n{corner}f {corners}\nv 0 0 5\n")
    mesh = read_mesh(path)
    assert len(mesh.faces) == 1
    assert np.ptp(mesh.vertices[mesh.faces[0]], axis=0).tolist() == [1, 1, 0]
