"""How a sensor acts on a scene: the true camera, the rig, the frames before, what is frozen, infrared noise."""

from dataclasses import replace

import numpy as np
import pytest

from fusion.geometry.camera import Camera
from fusion.geometry.pose import inverse, pose, transform
from fusion.sensor.effects.light.multipath import Multipath
from fusion.sensor.effects.light.projector_shadow import ProjectorShadow
from fusion.sensor.effects.optics.focal_length import FocalLength
from fusion.sensor.effects.phase.mixed_pixels import MixedPixels
from fusion.sensor.effects.readout.axial_noise import AxialNoise
from fusion.sensor.effects.readout.fixed_pattern import FixedPattern
from fusion.sensor.effects.readout.temporal_filtering import TemporalFiltering
from fusion.sensor.effects.rig.pose_jitter import PoseJitter
from fusion.sensor.effects.rig.timestamp_offset import TimestampOffset
from fusion.sensor.effects.rig.turntable_eccentricity import TurntableEccentricity
from fusion.sensor.effects.triangulation.speckle_noise import SpeckleNoise
from fusion.sensor.moment import Moment
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import LIGHT_SPEED, MODULATION_HZ
from fusion.simulation.rendering.exposure import Exposures
from fusion.simulation.rendering.render import render
from fusion.simulation.scene.course import SimulatedCourse, turning
from fusion.simulation.scene.scene import Part, Scene
from fusion.simulation.scene.shapes import box
from fusion.simulation.scene.turntable import Turntable
from fusion.simulation.scenes import built_in
from fusion.simulation.simulate import simulate

CAMERA = Camera(96, 72, 86.0, 86.0, 47.2, 35.9, distortion=(0.05, -0.02), depth_scale=5000.0)
BLOCK = box((-0.12, -0.1, 0.9), (0.1, 0.13, 1.1), (200, 200, 200))
ROUND = Sensor(principle="itof")


def wall(frames=1, **settings):
    texts = {key: str(value) for key, value in {"frames": frames, **settings}.items()}
    return replace(built_in("wall", texts), camera=CAMERA)


def depths(scene, sensor, seed=0):
    return [frame.depth for frame in simulate(scene, sensor, seed).frames()]


@pytest.mark.parametrize("principle", ["structured_light", "itof"])
def test_the_true_camera_takes_the_picture_and_the_stated_one_reads_it(principle):
    scene = wall(tilt_deg=30)
    effect = FocalLength(relative=0.02)
    simulation = simulate(scene, Sensor(principle=principle, effects=(effect,)))
    seen = next(simulation.frames()).depth
    true = effect.true_camera(simulation.camera)
    expected = render(scene.parts[0].mesh, true, simulation.truth.poses[0]).depth
    if principle == "itof":  # the range is right
        expected = expected * np.linalg.norm(np.dstack([true.rays(), np.ones(true.shape)]), axis=2)
        expected = expected / np.linalg.norm(np.dstack([CAMERA.rays(), np.ones(CAMERA.shape)]), axis=2)
    assert np.abs(seen - expected).max() < 1e-6  # single precision at a metre
    assert np.abs(seen - depths(scene, Sensor(principle=principle))[0]).max() > 0.005
    assert simulation.camera.fx == CAMERA.fx


def test_errors_of_the_rig_move_the_surface_itself():
    table = Turntable((0.0, 0.0, 1.0), (0.0, -1.0, 0.0), 90.0, 3)
    still = Part(box((0.3, -0.5, 1.2), (0.6, 0.5, 1.3), (90, 90, 90)))
    scene = Scene("block", (Part(BLOCK, turns=True), still), turning(table, np.eye(4)), CAMERA)
    effect = TurntableEccentricity(offset=0.02, phase=0.4)
    simulation = simulate(scene, Sensor(effects=(effect,)))
    for index, frame in enumerate(simulation.frames()):
        motion = effect.motion(simulation.moment(index))
        moved = table.T_world_object(simulation.turned_deg)[index]
        if motion is not None:  # the camera's frame is the world's
            moved = pose(np.eye(3), motion[3:]) @ moved
        mesh = replace(BLOCK, vertices=transform(moved, BLOCK.vertices))
        expected = np.fmin(render(mesh, CAMERA, np.eye(4)).depth, render(still.mesh, CAMERA, np.eye(4)).depth)
        # float rounding of silhouettes: a ray may just miss
        assert np.mean(np.abs(frame.depth - expected) > 1e-5) < 0.002
        assert np.mean(np.isnan(frame.depth) != np.isnan(expected)) < 0.002


def test_a_shaking_camera_moves_everything_and_not_its_pose():
    scene = wall(frames=4)
    sensor = Sensor(effects=(PoseJitter(sigma_m=0.01, sigma_rad=0.0),))
    shaken = depths(scene, sensor)
    offsets = [float(np.median(depth) - 1) for depth in shaken]
    assert 0.001 < np.std(offsets) < 0.04 and len({round(x, 6) for x in offsets}) == 4
    for depth in shaken:  # the wall stays flat
        assert np.ptp(depth) < 1e-4
    assert np.allclose(simulate(scene, sensor).truth.poses, scene.course.T_world_camera)


def test_what_moves_has_its_velocity():
    table = Turntable((0.0, 0.0, 1.0), (0.0, -1.0, 0.0), 3.0, 5)
    course = turning(table, np.eye(4), frame_s=0.1, continuous=True)
    scene = Scene("block", (Part(BLOCK, turns=True), Part(box((-2, -2, 2), (2, 2, 2.1), (90, 90, 90)))), course, CAMERA)
    simulation = simulate(scene, Sensor())
    view = Exposures(scene, simulation.sensor, CAMERA, simulation.turned_deg).view(
        2, simulation.moment(2), np.random.default_rng(0)
    )
    points = CAMERA.points(view.depth)
    spin = np.array([0.0, -1.0, 0.0]) * np.deg2rad(30.0)
    expected = np.cross(spin, points - [0, 0, 1.0])
    assert view.turning.any() and not view.turning.all()
    assert np.abs(view.velocity - expected)[view.turning].max() < 1e-4
    assert not view.velocity[~view.turning].any()
    stopped = replace(scene, course=replace(course, continuous=False))
    late = Sensor(effects=(TimestampOffset(offset=0.05),))
    assert np.array_equal(depths(stopped, late)[2], depths(stopped, Sensor())[2], equal_nan=True)
    assert not np.array_equal(depths(scene, late)[2], depths(scene, Sensor())[2], equal_nan=True)


def test_a_moving_camera_sees_everything_move():
    times = np.arange(5) * 0.05
    course = SimulatedCourse(
        times, np.array([pose(np.eye(3), [0.4 * t, 0.0, 1.0 * t]) for t in times]), continuous=True
    )
    scene = Scene("wall", (Part(box((-4, -4, 2), (4, 4, 2.1), (90, 90, 90))),), course, CAMERA)
    simulation = simulate(scene, Sensor())
    exposures = Exposures(scene, simulation.sensor, CAMERA, simulation.turned_deg)
    view = exposures.view(2, Moment(), np.random.default_rng(0))
    assert np.allclose(view.velocity, [-0.4, 0.0, -1.0], atol=1e-6)


def test_a_frame_knows_the_one_before():
    noise = AxialNoise(c0=0.002)
    memory = 0.6
    seen = np.array(depths(wall(frames=12), Sensor(effects=(noise, TemporalFiltering(memory=memory)))))[4:] - 1.0
    together = np.mean(seen[1:] * seen[:-1]) / np.mean(seen**2)
    # 50 000 pairs: a standard error of 0.005
    assert together == pytest.approx(memory, abs=0.03)


def test_what_is_frozen_stays_as_long_as_it_should():
    speckle = Sensor(principle="structured_light", effects=(SpeckleNoise(sigma_px=0.1, correlation_px=1.0),))
    scene = wall(frames=2, distance_m="1.0,1.2")
    first, again, other, _ = (depth - depth.mean() for depth in depths(scene, speckle))
    assert np.array_equal(first, again)
    assert abs(np.corrcoef(first.ravel(), other.ravel())[0, 1]) < 0.2  # set up anew; some 1000 independent speckles
    assert not np.array_equal(first, depths(scene, speckle, seed=1)[0] - 1)
    pattern = Sensor(effects=(FixedPattern(rms=0.002),), serial="A")
    assert np.array_equal(depths(wall(), pattern, 0)[0], depths(wall(), pattern, 1)[0])
    assert not np.array_equal(depths(wall(), pattern)[0], depths(wall(), replace(pattern, serial="B"))[0])


def test_infrared_noise_is_the_phase_noise():
    """Lange and Seitz: both come from the same samples."""
    sensor = Sensor(principle="itof", effects=(AxialNoise(c0=0.004),))
    frames = list(simulate(wall(frames=30), sensor).frames())
    ir = np.array([frame.ir for frame in frames], float)
    depth = np.array([frame.depth for frame in frames])
    stretch = np.linalg.norm(np.dstack([CAMERA.rays(), np.ones(CAMERA.shape)]), axis=2)
    expected = float(np.sqrt((depth.var(axis=0) * stretch**2).mean())) * 4 * np.pi * MODULATION_HZ / LIGHT_SPEED
    found = float(np.sqrt((ir.var(axis=0) / ir.mean(axis=0) ** 2).mean()))
    # 200 000 values each: 0.2 %; rounding to counts of about 500 adds nothing
    assert found == pytest.approx(expected, rel=0.02)


def test_only_those_sensors_give_infrared_that_have_it():
    structured = Sensor(principle="structured_light")
    assert next(simulate(wall(), structured).frames()).ir is None
    assert next(simulate(replace(wall(), infrared=True), structured).frames()).ir is not None
    assert next(simulate(wall(), ROUND).frames()).ir is not None


def test_only_what_the_effects_ask_for_is_rendered():
    scene = replace(built_in("step", {"frames": "1"}), camera=CAMERA)

    def seen(*effects):
        sensor = Sensor(principle="structured_light", effects=effects)
        simulation = simulate(scene, sensor)
        exposures = Exposures(scene, sensor, simulation.camera, simulation.turned_deg)
        return exposures.view(0, Moment(), np.random.default_rng(0))

    plain = seen()
    assert plain.edges is None and plain.lit is None and plain.indirect is None and plain.velocity is None
    assert seen(MixedPixels(fill=0.9)).edges is not None
    shadow = seen(ProjectorShadow(baseline=-0.075))
    assert shadow.lit is not None and shadow.edges is None and 0 < (shadow.lit < 0.5).mean() < 0.2


def test_a_corner_looks_farther_by_its_other_wall_unless_that_is_black():
    sensor = Sensor(principle="itof", effects=(Multipath(strength=1.0),))

    def error(**settings):
        scene = replace(built_in("corner", {"frames": "1", **settings}), camera=CAMERA)
        return depths(scene, sensor)[0] - depths(scene, ROUND)[0]

    bright, dark = error(), error(black="yes")
    assert np.nanmin(bright) > -1e-4 and 0.002 < np.nanmedian(bright) < 0.1
    # the bright wall next to a black one: what the black one sends is 0.03 / 0.8 of before
    halves = [np.nanmedian(dark[:, :44]) / np.nanmedian(bright[:, :44])]
    halves += [np.nanmedian(dark[:, 52:]) / np.nanmedian(bright[:, 52:])]
    assert min(halves) < 0.1 < max(halves)


def test_stated_poses_of_a_turntable_lead_from_stated_to_true():
    simulation = simulate(replace(built_in("turntable", {"frames": "4", "uneven_sd_deg": "1"}), camera=CAMERA), ROUND)
    step = inverse(simulation.stated.poses) @ simulation.truth.poses
    assert np.allclose(step[0], np.eye(4)) and not np.allclose(step[3], np.eye(4), atol=1e-4)
