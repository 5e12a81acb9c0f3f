"""The equations of edges: their derivatives are those of the residuals, and pairs are those of the views."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from fusion.turntable.pairs.edges import AskedErrors, edge_sums, paired, stack
from fusion.turntable.selfcheck import NAMES, PRIOR, SelfCheck

EDGE, REACH = [(0, 1)], 0.02


@pytest.fixture(scope="module")
def views(owl_scene):
    return owl_scene.views()[:2]


def residuals(views, motion, check):
    axis, angles = motion
    code, out = paired(stack(views), (axis, np.diff(angles)), EDGE, (REACH, 0.7), AskedErrors(check, NAMES))
    there = code[0] == 2
    return np.where(there, out[0, :, 0], np.nan), np.where(there[:, None], out[0, :, 2:], np.nan)


@pytest.mark.parametrize("triangulation", [False, True])
def test_derivatives_are_the_finite_differences(owl_scene, views, triangulation):
    axis, angles = owl_scene.axis, owl_scene.angles[:2] + np.array([0.0, 0.01])
    z = views[0].points[:, 2]
    none = SelfCheck(np.zeros(len(NAMES)), float(z.min()), float(z.max()), triangulation)
    J = residuals(views, (axis, angles), none)[1]
    for k, h in enumerate([1e-3, 1e-3, 1e-3, 1e-4, 1e-4, *(PRIOR / 30)]):
        unit = h * np.eye(5 + len(NAMES))[k]

        def at(sign, unit=unit):
            step = sign * unit
            moved = axis.moved(step[1:5])
            return residuals(views, (moved, angles + np.array([0, step[0]])), replace(none, values=step[5:]))[0]

        change = (at(1) - at(-1)) / (2 * h)
        # some points fall on another pixel on the way: the middle of all tells; 1e-7 m of float32 over the step
        wrong = np.nanmedian(np.abs(change - J[:, k]))
        assert wrong < 0.02 * np.nanmedian(np.abs(change)) + 1e-7 / h, k


def test_reach_grows_with_the_noise_of_the_views(views):
    seen = stack(views)
    assert seen.reach(0.006) == 0.006  # the noise is 1 mm or less
    noisy = stack([replace(v, sigma=np.full_like(v.sigma, 0.004)) for v in views])
    assert noisy.reach(0.006) == pytest.approx(0.02) and noisy.reach(0.03) == 0.03


def pairs(view, T, model):
    """Point-to-plane pairs of a view's points with a model, one array operation after the other."""
    p, n = view.points.astype(float) @ T[:3, :3].T + T[:3, 3], view.normals.astype(float) @ T[:3, :3].T
    u, v = np.floor(model.camera.project(p) + 0.5).astype(int).T
    inside = (u >= 0) & (u < model.camera.width) & (v >= 0) & (v < model.camera.height)
    index, u, v = np.flatnonzero(inside), u[inside], v[inside]
    q, m, sigma = (image[v, u].astype(float) for image in (model.points, model.normals, model.sigma))
    apart, known = p[index] - q, q[:, 2] > 0
    met = known & (np.linalg.norm(apart, axis=1) < REACH) & (p[index, 2] >= q[:, 2] - REACH)
    met &= np.einsum("ij,ij->i", n[index], m) > 0.7
    cosine = np.abs(np.einsum("ij,ij->i", m, q)) / np.linalg.norm(q, axis=1)  # noise acts along the line of sight
    spread = np.maximum(cosine * np.hypot(view.sigma[index].astype(float), np.nan_to_num(sigma)), 1e-5)
    residual, visible = np.einsum("ij,ij->i", m, apart), int(known.sum())
    return SimpleNamespace(index=index[met], residual=residual[met], sigma=spread[met], visible=visible)


def test_pairs_are_those_of_the_views(owl_scene, views):
    turn = float(owl_scene.angles[1] - owl_scene.angles[0])
    values = np.array([0.02, 1.0, -1.0, 0.004, 0.01, 0.005, -0.003, 0.002, 0.001, -0.001, 0.0, 0.0, 0.001])
    check = SelfCheck(values, 0.5, 0.9)
    there, back = check.view(views[0]), check.view(views[1])
    expected = pairs(there, owl_scene.axis.turn(turn), back.map)
    code, out = paired(stack(views), (owl_scene.axis, np.array([turn])), EDGE, (REACH, 0.7), AskedErrors(check))
    both = np.intersect1d(np.flatnonzero(code[0] == 2), expected.index)
    # a point on the border of two pixels may take the other one
    assert len(both) > 0.999 * len(expected.index)
    found = out[0, expected.index]
    assert np.median(np.abs(found[:, 0] - expected.residual)) < 2e-7
    assert np.median(np.abs(found[:, 1] / expected.sigma - 1)) < 1e-5
    assert abs(int((code[0] >= 1).sum()) - expected.visible) <= 0.001 * expected.visible


def test_an_edge_with_few_pairs_says_nothing(owl_scene, views):
    check = SelfCheck(np.zeros(len(NAMES)), 0.5, 0.9)
    far = (owl_scene.axis.moved(np.array([0, 0, 0.5, 0.5])), np.array([0.0, 1.5]))
    sums = edge_sums(stack(views), far, EDGE, 0.002, AskedErrors(check, NAMES))
    assert not sums.H.any() and not sums.visible.any()
