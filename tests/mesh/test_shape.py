"""Size, volume, holes and parts of bodies whose figures are known."""

import numpy as np
import pytest
import trimesh

from fusion.mesh.mesh import Mesh
from fusion.mesh.shape import shape_of

UP = np.array([0.0, 0.0, 1.0])
SIDES = (0.134, 0.133, 0.11)  # [m]


def box(subdivided: int = 3) -> Mesh:
    shape = trimesh.creation.box(SIDES)
    for _ in range(subdivided):
        shape = shape.subdivide()
    return Mesh(np.array(shape.vertices), np.asarray(shape.faces, np.int32))


def without(mesh: Mesh, *regions) -> Mesh:
    """Faces whose centre lies in one of the regions (a function of (n, 3) centres each) are left out."""
    centres = mesh.vertices[mesh.faces].mean(axis=1)
    gone = np.any([region(centres) for region in regions], axis=0)
    return Mesh(mesh.vertices, mesh.faces[~gone])


def bottom(c):
    return c[:, 2] < -SIDES[2] / 2 + 1e-6


def on_the_side(c):
    return (c[:, 0] > SIDES[0] / 2 - 1e-6) & (np.hypot(c[:, 1], c[:, 2]) < 0.02)


def on_top(c):
    return (c[:, 2] > SIDES[2] / 2 - 1e-6) & (np.hypot(c[:, 0], c[:, 1]) < 0.02)


@pytest.mark.parametrize("turn", [0.0, 0.3, 1.1, 2.5])
def test_size_and_volume_do_not_depend_on_how_the_body_is_turned(turn):
    mesh = box()
    c, s = np.cos(turn), np.sin(turn)
    turned = Mesh(mesh.vertices @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1.0]]) + [3.0, -2.0, 1.0], mesh.faces)
    shape = shape_of(turned, UP)
    assert shape.size == pytest.approx(SIDES, rel=1e-5)  # single precision of the rectangle
    assert shape.volume == pytest.approx(np.prod(SIDES), rel=1e-9)
    assert shape.openings() == "closed" and shape.open_share == 0 and shape.fragments == 1


def test_height_is_along_up():
    mesh = box()
    assert shape_of(Mesh(mesh.vertices[:, [2, 0, 1]], mesh.faces), [2.0, 0, 0]).size == pytest.approx(SIDES, rel=1e-5)


def test_an_open_bottom_is_closed_flat_and_told_apart_from_holes():
    shape = shape_of(without(box(4), bottom, on_the_side, on_top), UP)
    assert shape.volume == pytest.approx(np.prod(SIDES), rel=1e-9)  # all three are flat
    assert shape.openings() == "bottom open, 2 holes"
    assert sorted(hole.where for hole in shape.holes) == ["bottom", "side", "top"]
    assert shape.holes[0].where == "bottom" and shape.holes[0].perimeter == pytest.approx(2 * (SIDES[0] + SIDES[1]))
    assert shape.holes[0].outwards == pytest.approx((0, 0, -1))
    assert 0 < shape.open_share < 0.1  # the bottom does not count
    # what is missing and what is there make the closed body
    faces = 2 * (SIDES[0] * SIDES[1] + SIDES[0] * SIDES[2] + SIDES[1] * SIDES[2])
    assert shape.area + sum(hole.area for hole in shape.holes) == pytest.approx(faces)


def test_a_slit_that_runs_up_from_the_base_belongs_to_it():
    """Two blocks that nearly touch, as no camera looks in between: what is open there is no hole in the side."""

    def slit(c):
        return (np.abs(c[:, 1]) < 0.01) & (c[:, 0] > SIDES[0] / 2 - 1e-6) & (c[:, 2] < 0.03)

    shape = shape_of(without(box(4), bottom, slit), UP)
    assert shape.openings() == "bottom open" and shape.open_share == 0


def test_a_body_with_an_open_top_is_not_open_at_the_bottom():
    shape = shape_of(without(box(4), on_top), UP)
    assert shape.openings() == "1 hole" and shape.holes[0].where == "top"


def test_an_open_sheet_has_no_volume():
    sheet = without(box(), lambda c: c[:, 2] < SIDES[2] / 2 - 1e-6)
    assert shape_of(sheet, UP).volume is None


def test_parts_are_counted():
    one, two = box(), box(1)
    both = Mesh(
        np.concatenate([one.vertices, two.vertices * 0.1 + 1, [[9.0, 9, 9]]]),
        np.concatenate([one.faces, two.faces + len(one.vertices)]),
    )
    shape = shape_of(both, UP)
    assert shape.fragments == 2  # a vertex without a face is no part
    assert shape.largest_share == pytest.approx(1 / 1.01)


@pytest.mark.parametrize("mesh", [
    Mesh(np.zeros((0, 3))), Mesh(np.ones((4, 3))), Mesh(np.full((3, 3), np.nan), np.array([[0, 1, 2]], np.int32)),
    Mesh(np.array([[0, 0, 0], [1, 0, 0], [2.0, 0, 0]]), np.array([[0, 1, 2]], np.int32)),
], ids=["empty", "cloud", "nan", "no area"])  # fmt: skip
def test_what_is_no_body_has_no_volume(mesh):
    shape = shape_of(mesh, UP)
    assert shape.volume is None and np.isfinite(shape.size).all()


@pytest.mark.parametrize("tilt", [0.0, 0.1, 0.3])
def test_a_bottom_is_told_on_a_plate_that_is_not_square_to_the_axis(tilt):
    low = trimesh.creation.box((0.2, 0.09, 0.015))  # tilted, its foot spans twice its height
    for _ in range(4):
        low = low.subdivide()
    mesh = without(Mesh(np.array(low.vertices), np.asarray(low.faces, np.int32)), lambda c: c[:, 2] < -0.015 / 2 + 1e-6)
    c, s = np.cos(tilt), np.sin(tilt)
    shape = shape_of(Mesh(mesh.vertices @ np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]), mesh.faces), UP)
    assert shape.openings() == "bottom open" and shape.volume == pytest.approx(0.2 * 0.09 * 0.015, rel=1e-9)
