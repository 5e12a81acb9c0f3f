"""Views of one recording stand for recordings where they are far enough apart."""

import numpy as np

from fusion.discrepancy.observe.observations import views_of
from fusion.geometry.pose import about_axis


def test_a_turned_camera_sees_another_view_and_a_shaken_one_does_not():
    turned = [about_axis((0.0, 0.0, 0.8), (0.0, 1.0, 0.0), np.deg2rad(angle)) for angle in (0, 1, 30, 31, 60, 0.5)]
    assert views_of(turned) == [0, 0, 1, 1, 2, 0]
    shaken = [np.eye(4) + np.diag([1e-3] * 3, 1) for _ in range(5)]
    assert set(views_of(shaken)) == {0}
    assert views_of([]) == []
