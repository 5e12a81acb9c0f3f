"""Faces that look inwards: turned where it can be told, doubted where it cannot, left alone where all is well."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh

from fusion.mesh.comparison.compare import CompareSettings, compare
from fusion.mesh.comparison.distances import signed_distances, surface_of
from fusion.mesh.comparison.winding import wound
from fusion.mesh.mesh import Mesh
from fusion.mesh.vertices import joined

STAND = CompareSettings(align=False, samples=20_000)


def ball(radius, rounds=3, x=0.0):
    shape = trimesh.creation.icosphere(rounds, radius)
    return Mesh(np.array(shape.vertices) + np.array([x, 0, 0]), np.array(shape.faces, np.int32))


def inverted(mesh, rows=slice(None)):
    faces = mesh.faces.copy()
    faces[rows] = faces[rows, ::-1]
    return replace(mesh, faces=faces)


def both(a, b):
    return Mesh(np.r_[a.vertices, b.vertices], np.r_[a.faces, b.faces + len(a.vertices)].astype(np.int32))


def soup(mesh):
    return Mesh(mesh.vertices[mesh.faces].reshape(-1, 3), np.arange(mesh.faces.size, dtype=np.int32).reshape(-1, 3))


def height(mesh):
    return mesh.vertices[mesh.faces].mean(axis=1)[:, 2]


def some(mesh, share):
    return np.random.default_rng(0).random(len(mesh.faces)) < share


@pytest.mark.parametrize("given", [lambda mesh: mesh, soup])
@pytest.mark.parametrize("rows", [lambda mesh: height(mesh) > 0.02, lambda mesh: some(mesh, 0.4)])
def test_a_reference_partly_turned_inwards_measures_as_the_right_one(rows, given):
    right, scan = ball(0.1), ball(0.1005)
    wrong = rows(right)
    found, true = compare(scan, given(inverted(right, wrong)), STAND), compare(scan, right, STAND)
    assert found.accuracy == true.accuracy and found.completeness.mean_signed < 0
    assert found.notes == (f"{wrong.sum()} of {len(right.faces)} faces of the reference pointed inwards: turned.",)
    np.testing.assert_array_equal(found.reference.faces[~wrong], given(right).faces[~wrong])


@pytest.mark.parametrize("radii", [(0.1, 0.05), (0.05, 0.1)])  # of the right one and the inverted one
def test_each_of_two_bodies_looks_outwards(radii):
    pair = both(ball(radii[0]), inverted(ball(radii[1], x=0.4)))
    points = np.array([[0, 0, radii[0] + 0.01], [0.4, 0, radii[1] + 0.01], [0, 0, 0.01], [0.4, 0, 0.01]])
    assert (np.sign(signed_distances(points, pair)) == [1, 1, -1, -1]).all()
    assert wound(pair).notes()


@pytest.mark.parametrize("inner", [ball(0.05), inverted(ball(0.05))], ids=["thing", "cavity"])
def test_what_is_within_a_body_stays_as_it_is(inner):
    hollow = both(ball(0.1), inner)
    assert wound(hollow).mesh is hollow
    found = wound(inverted(hollow))  # as a whole it is turned, as ever
    assert found.whole and found.turned.all() and not found.notes()


def test_a_cavity_of_two_minds_looks_inwards_and_its_body_outwards():
    right = both(ball(0.1), inverted(ball(0.05)))
    wrong = some(right, 0.6)
    np.testing.assert_array_equal(wound(inverted(right, wrong)).turned, wrong)


def test_an_open_reference_of_two_minds_is_doubted():
    whole = ball(0.1)
    bowl = replace(whole, faces=whole.faces[height(whole) < 0.05])
    assert wound(bowl).mesh is bowl and not wound(inverted(bowl)).notes()  # nothing tells that it is wrong
    wrong = height(bowl) > 0.02
    found = wound(inverted(bowl, wrong))
    np.testing.assert_array_equal(found.turned, wrong)  # as most of it looks
    assert len(found.notes()) == 2 and "uncertain" in found.notes()[1]


def test_a_strip_with_one_side_is_doubted():
    count = 60
    turn = np.repeat(np.linspace(0, 2 * np.pi, count, endpoint=False), 2)
    out = 0.1 + np.tile([-0.02, 0.02], count) * np.cos(turn / 2)
    up = np.tile([-0.02, 0.02], count) * np.sin(turn / 2)
    here = np.repeat(np.arange(0, 2 * count - 2, 2), 2)[:, None]
    quads = here + np.tile([[0, 1, 2], [1, 3, 2]], (count - 1, 1))
    faces = np.r_[quads, [[2 * count - 2, 2 * count - 1, 1], [2 * count - 1, 0, 1]]]
    found = wound(Mesh(np.column_stack([out * np.cos(turn), out * np.sin(turn), up]), faces.astype(np.int32)))
    assert not found.turned.any() and "uncertain" in found.notes()[0]


def test_faces_written_from_both_sides_count_once():
    right = ball(0.1)
    for twice in (some(right, 0.5), np.ones(len(right.faces), bool)):
        doubled = Mesh(right.vertices, np.r_[right.faces, right.faces[twice, ::-1]])
        found = surface_of(doubled).wound
        np.testing.assert_array_equal(found.mesh.faces, right.faces)
        assert found.notes() == [
            f"{twice.sum()} faces of the reference lie on others that look the other way: left out."
        ]
    half = right.faces[height(right) < 0]
    assert "uncertain" in wound(Mesh(right.vertices, np.r_[half, half[:, ::-1]])).notes()[-1]


def test_bodies_that_touch_keep_the_wall_between_them():
    box = trimesh.creation.box((0.1, 0.1, 0.1))
    one = Mesh(np.array(box.vertices), np.array(box.faces, np.int32))
    pair = joined(both(one, Mesh(one.vertices * [-1, 1, 1] + [0.1, 0, 0], one.faces[:, ::-1])))
    assert (len(pair.vertices), len(pair.faces)) == (12, 24)
    assert wound(pair).mesh is pair and not wound(pair).notes()
