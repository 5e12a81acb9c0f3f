"""Clean-up removes what it says and keeps orientation, normals and colours."""

import numpy as np
import pytest
import trimesh

from fusion.mesh.cleanup import border_loops, fill_small_holes, large_parts, without_crumbs
from fusion.mesh.mesh import Mesh
from fusion.mesh.vertices import vertices_kept


def ball(radius: float, centre: tuple[float, float, float] = (0, 0, 0), subdivisions: int = 3) -> Mesh:
    shape = trimesh.creation.icosphere(subdivisions=subdivisions, radius=radius)
    normals = np.asarray(shape.vertices) / radius
    colors = np.full((len(normals), 3), 77, np.uint8)
    scalars = {"height": normals[:, 2].astype(np.float32)}
    vertices = np.asarray(shape.vertices) + centre
    return Mesh(vertices, np.asarray(shape.faces, np.int32), normals.astype(np.float32), colors, scalars)


def together(*parts: Mesh) -> Mesh:
    starts = np.cumsum([0] + [len(part.vertices) for part in parts])
    return Mesh(
        vertices=np.concatenate([part.vertices for part in parts]),
        faces=np.concatenate([part.faces + start for part, start in zip(parts, starts, strict=False)]).astype(np.int32),
        normals=np.concatenate([part.normals for part in parts if part.normals is not None]),
        colors=np.concatenate([part.colors for part in parts if part.colors is not None]),
    )


def volume(mesh: Mesh) -> float:
    shape = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    assert shape.is_watertight
    assert shape.is_winding_consistent
    return float(shape.volume)


def test_largest_part_goes_by_surface_not_by_vertices():
    big, fine = ball(0.1, subdivisions=1), ball(0.02, (1, 0, 0), subdivisions=4)
    kept, _ = large_parts(together(fine, big), 1.0)
    np.testing.assert_array_equal(kept.vertices, big.vertices)
    np.testing.assert_array_equal(kept.normals, big.normals)


def test_only_small_holes_are_filled_and_the_surface_closes():
    whole = ball(0.1)
    open_ball = vertices_kept(whole, whole.vertices[:, 2] >= -0.07)  # a border of about 0.45 m
    faces = np.delete(open_ball.faces, [300, 700], axis=0)  # two holes of one triangle, about 0.05 m around
    holed = Mesh(open_ball.vertices, faces, open_ball.normals, open_ball.colors, open_ball.scalars)
    assert len(border_loops(holed)) == 3
    filled = fill_small_holes(holed, 0.1)
    assert len(border_loops(filled)) == 1
    closed = fill_small_holes(filled, 1.0)
    assert border_loops(closed) == []
    # the flat lid removes the cap below z = -0.07 and the rim down to it: between 0 and 15 % of the ball
    assert 0.85 * volume(whole) < volume(closed) < volume(whole)
    assert closed.normals is not None
    assert closed.colors is not None
    assert len(closed.normals) == len(closed.colors) == len(closed.scalars["height"]) == len(closed.vertices)
    np.testing.assert_allclose(closed.normals[-1], [0, 0, -1], atol=0.05)  # the lid's centre looks down


def test_borders_that_touch_in_a_vertex_are_two_loops():
    whole = ball(0.1)
    fan = np.flatnonzero((whole.faces == 20).any(axis=1))
    first = whole.faces[fan[0]]
    across = next(f for f in fan if len(set(whole.faces[f]) & set(first)) == 1)
    holed = Mesh(whole.vertices, np.delete(whole.faces, [fan[0], across], axis=0))
    assert sorted(len(loop) for loop in border_loops(holed)) == [3, 3]
    assert volume(fill_small_holes(holed, 1.0)) == pytest.approx(volume(whole), rel=1e-9)


def test_a_point_cloud_passes_through():
    cloud = Mesh(np.zeros((5, 3)))
    for cleaned in (large_parts(cloud, 1.0)[0], fill_small_holes(cloud, 1.0)):
        assert len(cleaned.vertices) == 5


def test_crumbs_go_and_the_largest_part_stays():
    sizes = [0.02, 0.1, 0.5]
    boxes = [trimesh.creation.box([size] * 3).apply_translation([2.0 * i, 0, 0]) for i, size in enumerate(sizes)]
    all_of_them = trimesh.util.concatenate(boxes)
    mesh = Mesh(all_of_them.vertices, all_of_them.faces.astype(np.int32))
    kept = [len(without_crumbs(mesh, size).vertices) // 8 for size in (0.01, 0.1, 0.5, 5.0)]
    assert kept == [3, 2, 1, 1]  # the diagonal is 1.7 sides
