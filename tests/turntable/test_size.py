"""How well a scan can know its size: what the fit of the axis makes of errors of depth, beside what it really does."""

import numpy as np
import pytest
from test_finish import EVERYWHERE, FAR, NEAR, run, usable

from fusion.geometry import pose
from fusion.geometry.depth import point_map
from fusion.turntable.selfcheck import NAMES, PRIOR

NO_DOUBT = np.zeros(len(NAMES))


def doubt(**std: float) -> np.ndarray:
    """Standard deviations by name, 0 for the others."""
    return np.array([std.get(name, 0.0) for name in NAMES])


def grown(scene, depths, motion) -> float:
    """By how much the object is too large where depths (n, h, w) are placed by a motion; pixel by pixel, independent of
    the code under test."""
    shifts, places, facing = [], [], []
    for true, wrong, angle, own in zip(scene.depths, depths, scene.angles, motion.angles, strict=True):
        surface = point_map(true, scene.camera, 0.001)
        seen = usable(surface, EVERYWHERE)
        T, T_own = (axis.object_frame() @ axis.turn(-a) for axis, a in ((scene.axis, angle), (motion.axis, own)))
        points = surface.points[seen].astype(float)
        moved = points * (wrong / true)[seen][:, None]
        normals = surface.normals[seen] @ T[:3, :3].T
        places.append(pose.transform(T, points))
        shifts.append(np.sum((pose.transform(T_own, moved) - places[-1]) * normals, axis=1))
        facing.append(normals)
    at, n = np.concatenate(places), np.concatenate(facing)
    arm = at - at.mean(axis=0)
    columns = np.column_stack([np.cross(arm, n), n, np.sum(arm * n, axis=1)])
    return float(np.linalg.lstsq(columns, np.concatenate(shifts), rcond=None)[0][-1])


@pytest.mark.slow
@pytest.mark.parametrize(("name", "size"), [("stretch", 0.003), ("offset", 0.004)])
def test_it_is_what_such_an_error_does(owl_scene, name, size):
    s = np.clip((2 * owl_scene.depths - NEAR - FAR) / (FAR - NEAR), -1, 1)
    wrong = size * (s if name == "stretch" else np.ones_like(s))
    start = owl_scene.axis, owl_scene.angles
    found = run(owl_scene, start, wrong=wrong, doubt=doubt(**{name: size}))
    right = run(owl_scene, start, doubt=NO_DOUBT)
    happened = grown(owl_scene, owl_scene.depths + wrong, found) - grown(owl_scene, owl_scene.depths, right)
    # linear in the error, and the fit's robust weights see other residuals with it: a fifth, and 0.05 % of size
    assert found.size_std == pytest.approx(abs(happened), rel=0.25, abs=5e-4)
    assert found.size_std > 1e-3
    assert right.size_std < 1e-5


def test_twice_the_doubt_is_twice_the_spread(owl_scene):
    start = owl_scene.axis, owl_scene.angles
    once, twice = (run(owl_scene, start, doubt=k * PRIOR).size_std for k in (0.1, 0.2))
    assert twice == pytest.approx(2 * once, rel=1e-3)
    assert run(owl_scene, start).size_std is None
