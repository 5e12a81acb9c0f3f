"""Rims: pixels that mix what is before with what is behind tell of no focal length."""

import numpy as np
import pytest

from fusion.geometry.camera import Camera
from fusion.geometry.depth import point_map
from fusion.turntable.all_views.camera_fit import rests_on_rims
from fusion.turntable.focal import FocalCheck
from fusion.turntable.pairs.edges import SLANT, stack
from fusion.turntable.views import view

CAMERA = Camera(160, 120, 220.0, 220.0, 79.5, 59.5)


def cylinder():
    """One view of a standing cylinder of 50 mm, half a metre away."""
    x = CAMERA.rays()[..., 0]
    a, c = 1 + x**2, 0.5**2 - 0.05**2
    with np.errstate(invalid="ignore"):
        depth = (0.5 - np.sqrt(0.5**2 - a * c)) / a
    surface = point_map(depth.astype(np.float32), CAMERA, 0.0005)
    return view(surface, np.isfinite(surface.normals[..., 0]), None)


def test_a_clear_view_has_no_rims():
    whole = stack([cylinder(), cylinder()])
    clear = whole.clear()
    for surface in (clear.points, clear.maps[np.isfinite(clear.maps[..., 0])]):
        along = np.abs((surface[:, :3] * surface[:, 3:6]).sum(axis=1)) / np.linalg.norm(surface[:, :3], axis=1)
        assert along.min() > np.cos(SLANT)
    # of a cylinder sin(60 deg) of its width is seen clearly, but for the perspective
    share = np.isfinite(clear.maps[..., 0]).sum() / np.isfinite(whole.maps[..., 0]).sum()
    assert share == pytest.approx(np.sin(SLANT), abs=0.06)
    assert len(clear.points) == clear.first[-1] < len(whole.points)


@pytest.mark.parametrize(
    ("claim", "clear", "std", "rims"),
    [
        (0.04, -0.0001, 0.02, True),  # nothing but the rims asks for it
        (-0.03, -0.022, 0.011, False),
        (-0.03, 0.022, 0.011, True),
        (0.08, 0.079, 0.004, False),
        (0.04, 0.05, 0.06, True),  # what is seen clearly says nothing
    ],
)
def test_a_focal_length_must_show_beside_the_rims(claim, clear, std, rims):
    assert rests_on_rims(claim, clear, std) is rims


def test_how_well_a_scan_tells_it_knows_of_rims():
    check = FocalCheck(-0.02, 0.008, 6.3, 28, rims=0.021)
    assert check.told == pytest.approx(np.hypot(0.008, 0.021))
    assert check.deviations(CAMERA) == pytest.approx(0.02 / np.hypot(0.008, 0.002))
