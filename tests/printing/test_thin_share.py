"""The share of a surface behind which another one lies close."""

import numpy as np
import pytest

from fusion.mesh.mesh import Mesh
from fusion.printing.faults import thin_share


def box(*size):
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float) * size
    faces = [
        [0, 1, 3],
        [0, 3, 2],
        [4, 6, 7],
        [4, 7, 5],
        [0, 4, 5],
        [0, 5, 1],
        [2, 3, 7],
        [2, 7, 6],
        [0, 2, 6],
        [0, 6, 4],
    ]
    return Mesh(corners, np.array([*faces, [1, 5, 7], [1, 7, 3]], np.int32))


def test_a_sheet_is_thin_on_both_of_its_faces():
    assert thin_share(box(0.1, 0.1, 0.004), 0.006) == pytest.approx(0.02 / (0.02 + 4 * 0.1 * 0.004), abs=0.02)


def test_a_block_has_no_thin_parts():
    assert thin_share(box(0.1, 0.08, 0.06), 0.006) == 0.0


def test_nothing_is_not_thin():
    assert thin_share(Mesh(np.zeros((0, 3)), np.zeros((0, 3), np.int32)), 0.006) == 0.0
