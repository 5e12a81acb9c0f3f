"""The doctor asks a turntable recording for its focal length, and leaves every other recording alone."""

import json
from dataclasses import replace

import numpy as np
import pytest

from fusion.commands.main import main
from fusion.errors import TrackingError
from fusion.geometry.camera import Camera
from fusion.geometry.robust import DOUBT
from fusion.recording.checks.stillness import turns_before_a_still_camera, turns_by_its_log
from fusion.recording.looking.sample import draw
from fusion.recording.open import open_recording
from fusion.recording.recording import Frame, Recording
from fusion.scan.judging import focal_doctor
from fusion.scan.judging.focal_doctor import check_focal_length, measure
from fusion.turntable.focal import FocalCheck

CAMERA = Camera(160, 120, 130.0, 130.0, 79.5, 59.5, depth_scale=5000.0)
COUNT = 12


def recording(tmp_path, depth_of, log=None) -> Recording:
    """A recording in memory whose frame i shows `depth_of(i)` with 1 mm of noise."""
    stamps = np.arange(COUNT) / 10

    def load(i):
        noise = np.random.default_rng(i).normal(0, 0.001, CAMERA.shape)
        return Frame(i, i / 10, (depth_of(i) + noise).astype(np.float32))

    telemetry = {} if log is None else {"timestamp": stamps, "turntable_deg": np.asarray(log, float)}
    return Recording(tmp_path, "native", CAMERA, stamps, load, telemetry=telemetry)


def wall(i):
    return np.full(CAMERA.shape, 1.5)


def turning(i):
    """A slab that gets wide and narrow before a wall, as a box on a turntable does."""
    depth, half = wall(i), int(22 + 14 * np.cos(2 * np.pi * i / COUNT))
    depth[40:90, 80 - half : 80 + half] = 0.8
    return depth


def flickering(i):
    """A still thing whose edge jumps by two pixels."""
    depth = wall(i)
    depth[30:100, 60 : 100 + 2 * (i % 2)] = 0.8
    return depth


def panning(i):
    """A camera that turns: everything changes."""
    return 1.0 + 0.5 * np.sin(np.arange(160) / 12 + 0.5 * i) * np.ones((120, 1))


@pytest.mark.parametrize(
    ("depth_of", "turns"), [(turning, True), (wall, False), (flickering, False), (panning, False)],
    ids=["turntable", "wall", "flickering edge", "moving camera"],
)  # fmt: skip
def test_what_looks_like_a_turntable(tmp_path, depth_of, turns):
    assert turns_before_a_still_camera(draw(recording(tmp_path, depth_of))) == turns


def test_a_log_that_turns_is_enough(tmp_path):
    assert turns_by_its_log(recording(tmp_path, panning, 12.0 * np.arange(COUNT)))
    assert not turns_by_its_log(recording(tmp_path, panning, np.zeros(COUNT)))
    assert not turns_by_its_log(recording(tmp_path, panning))


@pytest.mark.parametrize("depth_of", [wall, flickering, panning])
def test_other_recordings_cost_nothing(tmp_path, depth_of, monkeypatch):
    monkeypatch.setattr(focal_doctor, "measure", lambda _: pytest.fail("was measured"))
    assert check_focal_length(draw(recording(tmp_path, depth_of))) == []


@pytest.mark.parametrize(
    ("relative", "std", "severity"),
    [(0.089, 0.008, "warning"), (-0.03, 0.002, "warning"), (0.002, 0.001, "ok"), (0.02, 0.01, "ok"), (0.0, 0.03, "ok")],
)
def test_it_speaks_up_only_with_evidence(tmp_path, monkeypatch, relative, std, severity):
    monkeypatch.setattr(focal_doctor, "measure", lambda _: FocalCheck(relative, std, 6.0, COUNT))
    (finding,) = check_focal_length(draw(recording(tmp_path, turning)))
    assert finding.severity == severity and finding.check == "focal length"
    assert ("hardly tells it" in finding.seen) == (severity == "ok" and std > 0.002)
    assert (f"about {100 * relative:+.0f} %" in finding.seen) == (severity == "warning")
    # what a scan is sure of it corrects by itself, as this camera is only nominal
    assert ("--keep-camera" in finding.do) == (severity == "warning")


def test_what_a_scan_is_not_sure_of_it_does_not_correct(tmp_path, monkeypatch):
    monkeypatch.setattr(focal_doctor, "measure", lambda _: FocalCheck(0.04, 0.01, 6.0, COUNT))
    (finding,) = check_focal_length(draw(recording(tmp_path, turning)))
    assert finding.severity == "warning" and "--refine-camera" in finding.do


def test_what_does_not_turn_about_one_axis_is_not_spoken_of(tmp_path, monkeypatch):
    def refuse(_):
        raise TrackingError("the views do not fit a turn about one axis")

    monkeypatch.setattr(focal_doctor, "measure", refuse)
    assert check_focal_length(draw(recording(tmp_path, turning))) == []


@pytest.mark.slow
@pytest.mark.parametrize("log", [True, False])
def test_a_planted_error_is_measured(owl_recording, log):
    wrong = 1.06
    camera = owl_recording.camera
    stated = replace(camera, fx=camera.fx * wrong, fy=camera.fy * wrong)
    told = owl_recording.telemetry if log else {}
    found = measure(replace(owl_recording, camera=stated, telemetry=told))
    # a pixel is 3 mm on an owl of 5 cm radius, and the prior of 3 % pulls: measured 4.5 % of the 5.7 planted
    assert found.relative == pytest.approx(1 / wrong - 1, abs=0.018)
    assert found.deviations(stated) > DOUBT
    assert np.rad2deg(found.turned) > 300


@pytest.mark.slow
def test_a_right_focal_length_is_left_alone(owl_recording):
    found = measure(owl_recording)
    assert found.deviations(owl_recording.camera) <= DOUBT


@pytest.fixture(scope="module")
def owl_recording(tmp_path_factory):
    """A small owl without noise: 72 frames of 6 degrees before a wall."""
    from fusion.simulation.demo.demo import looking_at
    from fusion.simulation.demo.demo_object import demo_object
    from fusion.simulation.rendering.render import RayCaster
    from fusion.simulation.scene.turntable import Turntable

    small = Camera(160, 120, 190.0, 191.0, 80.3, 59.1, depth_scale=5000.0, principle="itof")
    T_world_camera = looking_at(np.array([0.5, 0.05, 0.28]), np.array([0.0, 0.0, 0.10]))
    table = Turntable(degrees_per_frame=6.0, frames=72)
    caster = RayCaster(demo_object())
    rays = np.dstack([small.rays(), np.ones(small.shape)]) @ T_world_camera[:3, :3].T
    # a wall behind, so that something stands still
    back = ((-0.4 - T_world_camera[0, 3]) / rays[..., 0]).astype(np.float32)
    depths = [
        np.fmin(caster.view(small, T).depth, back) for T in table.T_object_camera(T_world_camera, table.commanded_deg())
    ]
    stamps = np.arange(72) / 10
    telemetry = {"timestamp": stamps, "turntable_deg": table.commanded_deg()}
    path = tmp_path_factory.mktemp("owl")
    return Recording(path, "native", small, stamps, lambda i: Frame(i, i / 10, depths[i]), telemetry=telemetry)


def findings(capsys, *arguments):
    status = main(["info", *map(str, arguments), "--json"])
    content = json.loads(capsys.readouterr().out)
    assert status in (0, 1)
    return [f for f in content["findings"] if f["check"] == "focal length"]


@pytest.mark.real
@pytest.mark.slow
def test_the_real_box_is_told_to_refine(shared, capsys):
    (finding,) = findings(capsys, shared / "data/kleenex_turntable")
    # 525 px stated; the box's own corners are right at 572 px, which is 9 %
    assert finding["severity"] == "warning" and "about +9 %" in finding["seen"]
    assert "corrects it by itself" in finding["do"]
    assert findings(capsys, shared / "data/kleenex_turntable", "--quick") == []


@pytest.mark.real
def test_a_moving_camera_is_left_alone(shared, capsys):
    assert findings(capsys, shared / "data/tum_fr1_rpy", "--camera", "tum-fr1") == []
    assert not turns_before_a_still_camera(draw(open_recording(shared / "data/tum_fr1_rpy", "tum-fr1")))
