"""Depth that was averaged over pixels is told by what bends, and does not move the axis."""

import numpy as np
import pytest
from scipy.ndimage import uniform_filter

from fusion.turntable.model.flattening import laplacian


def paraboloid(h=40, w=60, bent=4e-5):
    v, u = np.mgrid[0:h, 0:w].astype(float)
    return 0.5 + bent / 2 * ((u - 30) ** 2 + (v - 20) ** 2) / 2


def test_the_laplacian_of_a_bowl():
    found = laplacian(paraboloid())
    assert np.allclose(found[3:-3, 3:-3], 4e-5, rtol=1e-4) and not found[:3].any() and not found[:, -3:].any()


def test_a_plane_is_not_bent():
    v, u = np.mgrid[0:30, 0:30]
    assert np.abs(laplacian(0.5 + 0.001 * u - 0.002 * v)).max() < 1e-8


def test_holes_and_edges_say_nothing():
    depth = paraboloid()
    depth[20, 30] = np.nan
    depth[:, 45:] += 0.1
    found = laplacian(depth)
    assert not found[17:24, 27:34].any() and not found[10, 42:48].any()
    assert not laplacian(np.full((20, 20), np.nan)).any()


@pytest.mark.parametrize("width", [3, 5, 7])
def test_a_mean_over_a_window_adds_its_variance_times_half_the_laplacian(width):
    """A box of w pixels each way: (w^2 - 1) / 24 of the Laplacian, exactly so for a paraboloid."""
    depth = paraboloid()
    added = (uniform_filter(depth, width, mode="nearest") - depth)[10:-10, 10:-10]
    assert np.allclose(added, (width**2 - 1) / 24 * laplacian(depth)[10:-10, 10:-10], rtol=1e-3)
