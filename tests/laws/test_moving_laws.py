"""Laws of every effect that moves rays or surfaces: its bias is the exact picture of a plane, to first order."""

from dataclasses import fields, replace

import numpy as np
import pytest
from rich_view import rich_view, sensor_of

from fusion.geometry.pose import exp
from fusion.sensor.effect import Effect
from fusion.sensor.effects import EFFECTS
from fusion.sensor.effects.optics import OPTICS
from fusion.sensor.effects.rig import RIG
from fusion.sensor.effects.rig.pose_jitter import PoseJitter
from fusion.sensor.laws.moving import CameraEffect, RigEffect
from fusion.sensor.parameter import parameters
from fusion.sensor.view import Edges, View, incidence_of, stretch

CAMERAS = [kind for kind in EFFECTS if issubclass(kind, CameraEffect)]
RIGS = [kind for kind in EFFECTS if issubclass(kind, RigEffect)]
NORMAL = np.array([0.5, -0.2, -0.84]) / np.linalg.norm([0.5, -0.2, -0.84])
POINT = np.array([0.0, 0.0, 1.3])  # on the wall [m]


def sized(kind: type[Effect], share: float) -> Effect:
    """The effect at a share of its typical size; a phase stays."""
    values = {p.name: p.typical if p.name == "phase" else share * p.typical for p in parameters(kind).values()}
    return kind(**values)


@pytest.fixture(params=["structured_light", "itof"])
def view(request) -> View:
    """The bare wall through POINT, all of it on the turntable."""
    view = rich_view()
    camera = replace(view.camera, principle=request.param)
    depth = depth_of(NORMAL, POINT, camera)
    normals = np.broadcast_to(NORMAL, (*depth.shape, 3))
    incidence = incidence_of(normals, camera)
    turning = np.ones(depth.shape, bool)
    return replace(view, camera=camera, depth=depth, normals=normals, incidence=incidence, turning=turning)


def depth_of(normal, point, camera):
    """Depth (h, w) [m] of a plane."""
    return point @ normal / (camera.rays().astype(float) @ normal[:2] + normal[2])


def written(normal, point, true, view):
    """What a sensor with the true camera writes into its depth image (h, w) of a plane."""
    depth = depth_of(normal, point, true)
    return depth * stretch(true).astype(float) / stretch(view.camera) if view.time_of_flight else depth


def test_there_are_both_kinds():
    assert len(CAMERAS) >= 3 and len(RIGS) >= 3


@pytest.mark.parametrize("kind", CAMERAS, ids=lambda kind: kind.name)
class TestEveryCameraEffect:
    def test_neutral_is_the_stated_camera(self, kind, view):
        assert kind().true_camera(view.camera) == view.camera
        assert np.array_equal(kind().bias(view.depth, view), 0)

    @pytest.mark.parametrize("share", [-1.0, 1.0])
    def test_bias_is_the_picture_of_the_true_camera(self, kind, view, share):
        effect = sized(kind, share)
        expected = written(NORMAL, POINT, effect.true_camera(view.camera), view) - view.depth
        assert np.abs(expected).max() > 1e-4
        # a plane is its own tangent plane; rays and their lengths are single precision, 6e-8 of up to 5 m, thrice
        assert np.abs(effect.bias(view.depth, view) - expected).max() < 2e-6

    def test_several_parameters_add_up_to_first_order(self, kind, view):
        alone = 0.0
        for about in parameters(kind).values():
            alone = alone + kind(**{about.name: 0.01 * about.typical}).bias(view.depth, view)
        # the second order of a hundredth of the typical size, itself a few percent of the depth
        together = sized(kind, 0.01).bias(view.depth, view)
        assert np.abs(together - alone).max() < 0.01 * np.abs(together).max() + 2e-6

    def test_without_normals_only_the_length_of_the_ray_counts(self, kind, view):
        effect = sized(kind, 1.0)
        blind = replace(view, normals=None)
        ratio = stretch(effect.true_camera(view.camera)) / view.stretch if view.time_of_flight else 1.0
        assert np.abs(effect.bias(view.depth, blind) - view.depth * (ratio - 1)).max() < 1e-6  # single precision


@pytest.mark.parametrize("kind", RIGS, ids=lambda kind: kind.name)
class TestEveryRigEffect:
    def test_neutral_moves_nothing(self, kind, view):
        motion = kind().motion(view.moment)
        assert motion is None or not np.any(motion)

    def test_nothing_moves_without_a_table(self, kind, view):
        moment = replace(view.moment, axis_point=None, axis_direction=None)
        assert sized(kind, 1.0).motion(moment) is None
        assert not np.any(sized(kind, 1.0).bias(view.depth, replace(view, moment=moment)))

    def test_bias_is_the_picture_of_the_moved_wall(self, kind, view):
        errors = []
        for share in (1.0, 0.5):
            effect = sized(kind, share)
            T = exp(effect.motion(view.moment))
            normal, point = T[:3, :3] @ NORMAL, T[:3, :3] @ POINT + T[:3, 3]
            expected = depth_of(normal, point, view.camera) - view.depth
            errors.append(np.abs(effect.bias(view.depth, view) - expected).max())
            assert errors[-1] < 0.05 * np.abs(expected).max()  # turns of 0.005 rad at up to 70 deg of incidence
        # half the size has a quarter of the error, as a second order has; 1e-8 m is rounding
        assert errors[1] < 0.3 * errors[0] + 1e-8

    def test_only_the_table_moves(self, kind, view):
        turning = np.zeros(view.depth.shape, bool)
        turning[:, :20] = True
        bias = sized(kind, 1.0).bias(view.depth, replace(view, turning=turning))
        assert np.any(bias[:, :20]) and not np.any(bias[:, 20:])

    def test_repeats_after_a_whole_turn(self, kind, view):
        effect = sized(kind, 1.0)
        later = replace(view.moment, table_angle=view.moment.table_angle + 2 * np.pi)
        assert np.allclose(effect.motion(later), effect.motion(view.moment), rtol=0, atol=1e-12)


def test_shake_is_a_motion_too(view):
    assert not np.any(PoseJitter().shake(np.random.default_rng(0)))
    effect = PoseJitter(0.001, 0.001)
    T = exp(effect.shake(np.random.default_rng(4)))
    expected = depth_of(T[:3, :3] @ NORMAL, T[:3, :3] @ POINT + T[:3, 3], view.camera) - view.depth
    drawn = effect.sampled(view.depth, view, np.random.default_rng(4)) - view.depth
    assert np.abs(drawn - expected).max() < 0.02 * np.abs(expected).max()  # a few mrad at up to 70 deg of incidence


@pytest.mark.parametrize("kind", [*RIG, *OPTICS], ids=lambda kind: kind.name)
@pytest.mark.parametrize("bad", [np.nan, np.inf, 0.0])
def test_holes_in_what_is_known_leave_no_holes_in_the_depth(kind, bad):
    view = rich_view(kind)
    rng = np.random.default_rng(0)

    def holey(image):
        lost = rng.random(view.depth.shape) < 0.2
        return np.where(lost[..., None] if image.ndim == 3 else lost, bad, image)

    edges = Edges(*(holey(getattr(view.edges, about.name)) for about in fields(Edges)))
    view = replace(view, normals=holey(view.normals), velocity=holey(view.velocity), edges=edges)
    sensor, there = sensor_of(sized(kind, 1.0)), np.isfinite(view.depth)
    assert np.isfinite(sensor.predict(view.depth, view)[there]).all()
    assert np.isfinite(sensor.sample(view.depth, view, None, rng)[there]).all()
