"""A simulated recording: repeatable, true to its sensor, with a background that stands still."""

from dataclasses import replace

import numpy as np
import pytest

from fusion.geometry.camera import Camera
from fusion.sensor.correction.unit import refuse_other_unit
from fusion.sensor.files.sensor_file import read_sensor
from fusion.sensor.presets import preset
from fusion.sensor.sensor import Sensor
from fusion.simulation.demo.demo import demo_scene, demo_truth, write_demo_recording
from fusion.simulation.demo.demo_object import demo_object
from fusion.simulation.rendering.render import render
from fusion.simulation.simulate import simulate

V2 = preset("kinect-v2-indoors")
SMALL = Camera(160, 120, 144.3, 144.7, 80.3, 59.1, distortion=(0.06, -0.14), depth_scale=5000.0, principle="itof")


@pytest.fixture(scope="module")
def scene():
    return replace(demo_scene(frames=4, turns=0.2), camera=SMALL)


def test_the_same_seed_gives_the_same_bits_and_another_does_not(scene):
    def bits(seed):
        return [(f.depth.tobytes(), f.color.tobytes(), f.ir.tobytes()) for f in simulate(scene, V2, seed).frames()]

    first = bits(5)
    assert first == bits(5)
    assert all(a[0] != b[0] for a, b in zip(first, bits(6), strict=True))


def test_an_ideal_sensor_sees_the_truth(scene):
    simulation = simulate(replace(scene, edge_lost=0.0, edge_mixed=0.0), Sensor(), 0)
    for frame, T in zip(simulation.frames(), simulation.truth.poses, strict=True):
        alone = render(simulation.mesh, SMALL, T).depth
        seen = np.isfinite(alone)
        assert seen.mean() > 0.05
        assert np.abs(frame.depth - alone)[seen].max() < 1e-6


def test_the_background_stands_still_while_the_owl_turns(scene):
    quiet = replace(scene, edge_lost=0.0, edge_mixed=0.0)
    first, *_, last = [frame.depth for frame in simulate(quiet, Sensor(), 0).frames()]
    changed = np.abs(first - last) > 1e-4
    assert 0.01 < changed.mean() < 0.3


def test_noise_is_that_of_the_sensor(scene):
    quiet = replace(scene, edge_lost=0.0, edge_mixed=0.0)
    true = [f.depth for f in simulate(quiet, Sensor(), 0).frames()]
    noisy = Sensor(principle="itof", effects=(V2.effect("axial_noise"),))
    seen = [f.depth for f in simulate(quiet, noisy, 0).frames()]
    wall = (slice(0, 20), slice(0, 160))  # the upper part of the image shows nothing but the wall
    error = np.array([(b - a)[wall] for a, b in zip(true, seen, strict=True)])
    sigma = noisy.sigma(true[0], None, SMALL)[wall]
    # the wall is seen at up to 40 degrees, where the angle term adds at most 5 %
    assert 0.97 < error.std() / np.sqrt((sigma**2).mean()) < 1.1


def test_edge_pixels_are_lost_and_nothing_else(scene):
    for frame in simulate(scene, V2, 0).frames():
        assert 0.9 < np.isfinite(frame.depth).mean() < 1.0


def test_the_owl_is_watertight_upright_and_asymmetric():
    import trimesh

    owl = demo_object()
    mesh = trimesh.Trimesh(owl.vertices, owl.faces, process=False)
    assert mesh.is_watertight and mesh.volume > 0 and mesh.body_count == 1
    assert 50_000 < len(owl.faces) < 100_000
    assert owl.vertices[:, 2].min() == pytest.approx(0.0, abs=1e-4)
    assert 0.2 < np.ptp(owl.vertices[:, 2]) < 0.25
    assert len(np.unique(owl.colors, axis=0)) > 5
    # turned by any of these angles it does not fit itself: its moments differ by far more than rounding
    for degrees in (90, 180, 270):
        turned = mesh.copy().apply_transform(trimesh.transformations.rotation_matrix(np.deg2rad(degrees), [0, 0, 1]))
        assert np.abs(turned.moment_inertia - mesh.moment_inertia).max() > 1e-7


def test_the_demo_is_a_recording_with_its_truth_beside_it(tmp_path):
    from fusion.mesh.files import read_mesh
    from fusion.recording.native.trajectory_file import read_trajectory
    from fusion.recording.open import open_recording

    folder = write_demo_recording(tmp_path / "demo", seed=1, frames=2, turns=0.1)
    recording = open_recording(folder)
    assert len(recording) == 2 and recording.camera.distortion == demo_scene().camera.distortion
    assert recording.poses is None  # the truth stands beside the recording, not in it
    assert np.allclose(recording.telemetry["turntable_deg"], [0, 18])
    assert recording[0].depth.shape == (480, 640) and recording[0].color is not None
    truth = read_trajectory(tmp_path / "demo" / "truth_poses.txt")
    assert np.allclose(truth.timestamps, recording.timestamps)
    assert len(read_mesh(tmp_path / "demo" / "truth.ply").faces) == len(demo_truth().faces)
    refuse_other_unit(read_sensor(tmp_path / "demo" / "sensor.json"), recording.camera)
