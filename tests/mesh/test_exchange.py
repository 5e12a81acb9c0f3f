"""A mesh goes to Open3D and trimesh and comes back as it was; a notebook gets a picture of it."""

from dataclasses import replace

import cv2
import numpy as np
import open3d as o3d
import pytest
import trimesh

from fusion.mesh.mesh import Mesh


def ball():
    made = trimesh.creation.icosphere(2, 0.05)
    n, rng = len(made.vertices), np.random.default_rng(1)
    return Mesh(
        made.vertices + np.array([0.3, -0.2, 1.1]),
        np.asarray(made.faces, np.int32),
        np.asarray(made.vertex_normals, np.float32),
        rng.integers(0, 256, (n, 3), np.uint8),
        {"sigma": rng.random(n, np.float32)},
    )


BALL = ball()
CASES = {
    "all": BALL,
    "bare": Mesh(BALL.vertices, BALL.faces),
    "colours only": Mesh(BALL.vertices, BALL.faces, colors=BALL.colors),
    "cloud": replace(BALL, faces=np.zeros((0, 3), np.int32)),
    "bare cloud": Mesh(BALL.vertices),
}


def check(back, mesh, scalars=True, normals=True):
    # a float32 at 1 m ends at 0.1 micrometre
    assert np.allclose(back.vertices, mesh.vertices, rtol=0, atol=2e-7)
    assert back.vertices.dtype == np.float64 and back.faces.dtype == np.int32
    assert np.array_equal(back.faces, mesh.faces)
    for name in ("normals", "colors") if normals else ("colors",):
        ours, theirs = getattr(mesh, name), getattr(back, name)
        assert (ours is None) == (theirs is None)
        assert ours is None or (theirs.dtype == ours.dtype and np.allclose(theirs, ours, atol=1e-6))
    if scalars:
        assert back.scalars.keys() == mesh.scalars.keys()
        assert all(np.array_equal(back.scalars[k], v) for k, v in mesh.scalars.items())


@pytest.mark.parametrize("name", CASES)
def test_there_and_back_through_open3d(name):
    mesh = CASES[name]
    check(Mesh.from_open3d(mesh.to_open3d()), mesh)
    # the older classes hold no values of one's own
    check(Mesh.from_open3d(mesh.to_open3d().to_legacy()), mesh, scalars=False)


@pytest.mark.parametrize("name", CASES)
def test_there_and_back_through_trimesh(name):
    mesh = CASES[name]
    with_faces = bool(len(mesh.faces))  # trimesh's clouds hold points and colours
    check(Mesh.from_trimesh(mesh.to_trimesh()), mesh, scalars=with_faces, normals=with_faces)


def test_open3d_takes_what_it_is_given():
    scene = o3d.t.geometry.RaycastingScene()
    scene.add_triangles(BALL.to_open3d())
    middle = BALL.vertices.mean(axis=0).astype(np.float32)[None]
    assert scene.compute_signed_distance(middle).item() == pytest.approx(-0.05, rel=0.05)  # facets of a coarse ball


def test_a_scene_of_trimesh_becomes_one_mesh_where_its_parts_stand():
    box = trimesh.creation.box((1, 1, 1))
    moved = np.eye(4)
    moved[0, 3] = 5.0
    scene = trimesh.Scene()
    scene.add_geometry(box)
    scene.add_geometry(box, transform=moved)
    mesh = Mesh.from_trimesh(scene)
    assert len(mesh.faces) == 24
    assert np.ptp(mesh.vertices[:, 0]) == pytest.approx(6.0)


def test_a_notebook_gets_a_picture():
    image = cv2.imdecode(np.frombuffer(BALL._repr_png_(), np.uint8), cv2.IMREAD_UNCHANGED)
    assert image.shape[2] == 4
    share = (image[..., 3] > 128).mean()
    assert 0.4 < share < np.pi / 4  # two discs in their squares, a gap between


def test_nothing_to_see_is_no_picture():
    assert Mesh(np.zeros((0, 3)))._repr_png_() is None
    assert Mesh(np.full((3, 3), np.nan), np.array([[0, 1, 2]], np.int32))._repr_png_() is None


def test_a_cloud_has_a_picture_too():
    assert CASES["bare cloud"]._repr_png_() is not None
