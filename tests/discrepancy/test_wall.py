"""A flat wall at a distance that a laser measured needs no mesh: its plane is found, its distance is the laser's."""

import numpy as np
import pytest

from fusion.discrepancy.observe.scene.stage import stage_of
from fusion.discrepancy.observe.scene.wall import wall_of
from fusion.recording.open import open_recording
from fusion.sensor.effects.readout.depth_scale import DepthScale
from fusion.sensor.sensor import Sensor
from fusion.simulation.scenes.panel import wall
from fusion.simulation.simulate import simulate
from fusion.simulation.write import write_simulation


@pytest.fixture
def recording(tmp_path):
    """A wall turned by ten degrees at 1.2 m, seen by a camera whose depth is 1 % long; its mesh and poses are lost."""
    scene = wall(distance_m=(1.2,), tilt_deg=(10.0,), frames=2)
    write_simulation(tmp_path / "rec", simulate(scene, Sensor("long", "itof", (DepthScale(scale=0.01),)), 1))
    for name in ("scene.json", "groundtruth.txt"):
        (tmp_path / "rec" / name).unlink()
    return open_recording(tmp_path / "rec")


def test_the_wall_stands_where_the_laser_says_and_is_turned_as_it_is_seen(recording):
    found = wall_of(recording)
    assert found is not None
    a, b, c = (found.mesh.vertices[i] for i in found.mesh.faces[len(found.mesh.faces) // 2])
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal)
    # along the optical axis; vertices are doubles
    assert normal @ a / normal[2] == pytest.approx(1.2, abs=1e-6)
    assert np.rad2deg(np.arccos(abs(normal[2]))) == pytest.approx(10.0, abs=0.1)
    stage = stage_of(recording, 0)
    assert stage.sigma_rad > 0.05
    view = stage.caster.view(recording.camera, np.eye(4))
    assert np.isfinite(view.depth).all()
    ratio = recording[0].depth / view.depth
    # millimetre counts at 1.2 m
    assert np.nanmedian(ratio) == pytest.approx(1.01, abs=5e-4)


def test_a_recording_that_says_no_distance_is_no_wall(recording):
    recording.telemetry.pop("distance_m")
    assert wall_of(recording) is None
