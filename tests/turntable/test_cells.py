"""The fit against the model: eliminating the cells' offsets is the same as solving for them."""

import numpy as np
import pytest

from fusion.compute.start import start
from fusion.geometry.robust import tukey
from fusion.turntable.model.cells import CUT, normal_equations, settle
from fusion.turntable.model.meeting import ANGLE, AXIS, HEIGHT, RESIDUAL, SHARED, SIGMA, SPOILT

FRAMES, CELLS, EACH, NOISE = 5, 40, 12, 0.001


@pytest.fixture(autouse=True, params=["tuned", "plain"])
def kernels(request, monkeypatch):
    """All of it holds for both."""
    monkeypatch.setenv("FUSION_KERNELS", request.param)


def rows_of_cells(rng, errors=0):
    """Equations of cells with offsets of their own: rows, frames and where each cell begins."""
    start()
    offset = rng.normal(0, 0.002, CELLS)
    rows = rng.normal(0, 1, (CELLS * EACH, SHARED + AXIS + errors)).astype(np.float32)
    rows[:, RESIDUAL] = np.repeat(offset, EACH) + rng.normal(0, NOISE, CELLS * EACH)
    rows[:, SIGMA], rows[:, SPOILT], rows[:, HEIGHT] = NOISE, 1.5, rng.uniform(0, 0.1, CELLS * EACH)
    frame = np.sort(rng.integers(0, FRAMES, (CELLS, EACH)), axis=1).ravel().astype(np.int32)
    return rows, frame, np.arange(0, CELLS * EACH + 1, EACH, dtype=np.int32)


@pytest.mark.parametrize("errors", [0, 3])
def test_eliminated_offsets_are_those_of_the_whole_system(errors):
    rows, frame, first = rows_of_cells(np.random.default_rng(0), errors)
    shared = AXIS + errors
    offset = np.zeros(CELLS)
    settle(rows, first, offset, 3.0, 0, -np.inf)
    for steady, lowest in ((0, -np.inf), (1, 0.03)):
        H, g = normal_equations(rows, frame, first, offset, FRAMES, (3.0, steady, lowest))
        sigma = 3.0 * NOISE * (1.5 if steady else 1.0)
        rest = rows[:, RESIDUAL].astype(float) - np.repeat(offset, EACH)
        weight = tukey(rest / sigma, CUT) / sigma**2 * (rows[:, HEIGHT] >= lowest)
        J = np.zeros((len(rows), shared + FRAMES + CELLS))
        J[:, :shared] = rows[:, SHARED:]
        J[np.arange(len(rows)), shared + frame] = rows[:, ANGLE]
        J[np.arange(len(rows)), shared + FRAMES + np.repeat(np.arange(CELLS), EACH)] = 1
        whole = np.linalg.solve((J * weight[:, None]).T @ J, (J * weight[:, None]).T @ rows[:, RESIDUAL])
        # float64 sums of float32 rows, and a condition number of a few hundred
        np.testing.assert_allclose(np.linalg.solve(H, g), whole[: shared + FRAMES], rtol=1e-5, atol=1e-9)


def test_an_equation_far_off_counts_nothing():
    rows, frame, first = rows_of_cells(np.random.default_rng(1))
    offset = np.zeros(CELLS)
    for _ in range(2):
        settle(rows, first, offset, 3.0, 0, -np.inf)
    before = normal_equations(rows, frame, first, offset, FRAMES, (3.0, 0, -np.inf))
    wild = np.insert(rows, 3, rows[3], axis=0)
    wild[3, RESIDUAL] = 1.0
    after = normal_equations(
        wild, np.insert(frame, 3, frame[3]), np.append(0, first[1:] + 1).astype(np.int32), offset, FRAMES,
        (3.0, 0, -np.inf),
    )  # fmt: skip
    for one, other in zip(before, after, strict=True):
        np.testing.assert_array_equal(one, other)
