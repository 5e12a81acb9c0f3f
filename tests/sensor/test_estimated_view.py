"""What is estimated from a depth image, against what the renderer knows."""

import numpy as np
import pytest

from fusion.geometry.camera import Camera
from fusion.mesh.mesh import Mesh
from fusion.sensor.correction.estimate import estimated_view
from fusion.sensor.edges.nearest import REACH_PX
from fusion.sensor.sensor import Sensor
from fusion.simulation.rendering.render import Channels, render
from fusion.simulation.scene.shapes import joined

CAMERA = Camera(160, 120, 150.0, 150.0, 80.2, 60.3)


def square(half: float, z: float, reflectance: float) -> Mesh:
    corners = half * np.array([[1, 1, 0], [-1, 1, 0], [-1, -1, 0], [1, -1, 0]]) + [0.0, 0, z]
    scalars = {"reflectance": np.full(4, reflectance, np.float32)}
    return Mesh(corners, np.array([[0, 1, 2], [0, 2, 3]], np.int32), scalars=scalars)


@pytest.fixture(scope="module")
def truth():
    scene = joined([square(0.2, 1.0, 0.8), square(4, 2.0, 0.3)])
    return render(scene, CAMERA, np.eye(4), Channels(edges=True, lit=-0.075))


@pytest.fixture(scope="module")
def lossy(truth):
    """The depth without a third of the pixels beside edges, without 2 % of all, and with 1 mm of noise."""
    rng = np.random.default_rng(3)
    lost = ((truth.edges.distance < 1) & (rng.random(truth.depth.shape) < 0.33)) | (
        rng.random(truth.depth.shape) < 0.02
    )
    return np.where(lost, np.nan, truth.depth + rng.normal(0, 1e-3, truth.depth.shape)).astype(np.float32)


def test_edges_are_found_to_a_pixel(truth):
    view = estimated_view(truth.depth, CAMERA)
    near = truth.edges.distance < REACH_PX - 1
    # an edge lies anywhere between the two pixels
    assert np.abs(view.edges.distance[near] - truth.edges.distance[near]).max() <= 0.8
    same = near & (truth.edges.distance > 0.5)
    assert np.allclose(view.edges.jump[same], truth.edges.jump[same], atol=1e-5)
    assert (view.edges.distance[np.isinf(truth.edges.distance)] > REACH_PX - 0.8).all()


def test_holes_and_noise_change_little(truth, lossy):
    view = estimated_view(lossy, CAMERA)
    seen = np.isfinite(lossy)
    near = seen & (truth.edges.distance < REACH_PX - 2)
    off = np.abs(view.edges.distance[near] - truth.edges.distance[near])
    assert np.percentile(off, 99) < 1.5  # a pixel lost on either side, and half a pixel
    sign = np.sign(view.edges.jump[near & (truth.edges.distance > 1)])
    assert np.mean(sign == np.sign(truth.edges.jump[near & (truth.edges.distance > 1)])) > 0.97
    # a lost pixel away from edges is no edge
    assert (view.edges.distance[np.isinf(truth.edges.distance)] > REACH_PX - 2.5).all()


def test_a_wide_hole_is_where_the_surface_ends(truth):
    depth = truth.depth.copy()
    depth[:, 120:140] = np.nan
    view = estimated_view(depth, CAMERA)
    assert view.edges.distance[5, 115:120] == pytest.approx(np.arange(4.5, -0.5, -1), abs=1e-6)
    assert not view.edges.jump[5].any() and not view.edges.light[5, 115:120].any()


def test_a_pixel_between_two_surfaces_does_not_hide_their_edge(truth):
    depth = truth.depth.copy()
    column = int(np.flatnonzero(depth[60] < 1.5)[-1]) + 1
    depth[:, column] = 1.4
    view = estimated_view(depth, CAMERA)
    assert (view.edges.jump[60, column - 4 : column] > 0.3).all()
    assert (view.edges.jump[60, column + 1 : column + 4] < -0.5).all()


def test_reflectance_comes_back_from_the_amplitude(truth):
    ir = Sensor().amplitude(truth)
    view = estimated_view(truth.depth, CAMERA, ir)
    inside = np.isfinite(view.incidence) & (truth.edges.distance > 2)
    assert np.allclose(view.reflectance[inside], truth.reflectance[inside], rtol=1e-3)
    across = (truth.edges.distance < 3) & (truth.edges.distance > 0.5)
    assert np.allclose(view.edges.light[across], truth.edges.light[across], rtol=0.1)  # other neighbours


def test_shadow_lies_where_the_renderer_has_it(truth):
    view = estimated_view(truth.depth, CAMERA, projector=-0.075)
    dark, true = (1 - v.lit[60].astype(float) for v in (view, truth))
    assert dark.sum() == pytest.approx(true.sum(), abs=1.0)
    assert np.flatnonzero(dark)[0] == pytest.approx(np.flatnonzero(true)[0], abs=1)
    assert view.baseline == -0.075 and estimated_view(truth.depth, CAMERA).lit is None


def test_nothing_measured_is_nothing_known():
    view = estimated_view(np.full(CAMERA.shape, np.nan, np.float32), CAMERA, projector=0.05)
    assert np.isinf(view.edges.distance).all() and (view.lit == 1).all() and np.isnan(view.incidence).all()


def test_a_steep_floor_has_no_edges():
    x, y, z = np.eye(3)
    floor = Mesh(np.array([-9 * x, 9 * x, 9 * x + 20 * z, -9 * x + 20 * z]) + 0.2 * y, np.array([[0, 1, 2], [0, 2, 3]]))
    depth = render(floor, CAMERA, np.eye(4)).depth
    horizon = int(np.flatnonzero(np.isfinite(depth).all(axis=1))[0])
    view = estimated_view(depth, CAMERA)
    assert np.isinf(view.edges.distance[horizon + 9 :]).all()
