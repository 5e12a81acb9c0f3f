"""Simulated recordings in place of the prediction: matched frame by frame, what they lack is named, wrong ones told."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from made_up_walls import WALLS, sensor_of, view_of

from fusion.commands.main import main
from fusion.discrepancy.explain import explain
from fusion.discrepancy.simulated import matched
from fusion.discrepancy.verdict.verdict import verdict_of
from fusion.errors import RecordingError
from fusion.recording.recording import Frame, Recording
from fusion.sensor.effects.light.ambient_light import AmbientLight
from fusion.sensor.effects.phase.column_delay import ColumnDelay
from fusion.sensor.effects.readout.depth_scale import DepthScale
from fusion.sensor.files.sensor_file import write_sensor
from fusion.sensor.sensor import Sensor

FRAMES = 7


def recording_of(sensor: Sensor, place: int, seed: int, ir: bool = True) -> Recording:
    """What a sensor gives of one of the walls, without mesh and poses."""
    view = view_of(sensor.principle, WALLS[place], place)
    rng = np.random.default_rng([seed, place])
    depth = [np.asarray(sensor.sample(view.depth, view, None, rng), np.float32) for _ in range(FRAMES)]
    light = np.asarray(view.ir, np.uint16) if ir else None
    stamps = 100.0 * place + np.arange(FRAMES) / 30
    about = {"poses": {"sigma_m": 0.0005, "sigma_rad": 0.0005}}
    return Recording(
        Path(f"rec_{place:02d}_{seed}"),
        "native",
        view.camera,
        stamps,
        lambda i: Frame(i, float(stamps[i]), depth[i], ir=light),
        scene=about,
    )


def all_of(sensor: Sensor, seed: int) -> list[Recording]:
    return [recording_of(sensor, place, seed) for place in range(5)]


@pytest.mark.slow
def test_a_simulation_that_is_right_leaves_nothing():
    known = sensor_of("itof")
    found = explain(all_of(known, 1), known, simulated=all_of(known, 2))
    verdict = verdict_of(found)
    assert not verdict.missing and verdict.headline.startswith("Nothing is missing: the simulation explains")


@pytest.mark.slow
def test_what_a_simulation_lacks_is_named():
    known = sensor_of("itof")
    hidden = replace(known, effects=(*known.effects, ColumnDelay(slope=4e-4), AmbientLight(ambient=8000.0)))
    found = explain(all_of(hidden, 1), replace(known, std={("axial_noise", "c0"): 1e-4}), simulated=all_of(known, 2))
    claims = {claim.effect: claim for claim in verdict_of(found).missing}
    noise = next(claim for claim in claims.values() if claim.channel == "noise")
    assert "ambient_light" in (noise.effect, *noise.indistinguishable_from)
    named = {*claims, *(name for claim in claims.values() for name in claim.indistinguishable_from)}
    assert "column_delay" in named


@pytest.mark.slow
def test_an_error_of_the_simulation_is_found_in_folders_without_scene_and_poses(tmp_path, capsys):
    """As any simulator writes them: depth images and nothing else."""
    known = sensor_of("itof")
    wrong = replace(known, effects=(*known.effects, DepthScale(0.006)))
    for name, recordings in (("recorded", all_of(known, 1)), ("simulated", all_of(wrong, 2))):
        for place, recording in enumerate(recordings):
            folder = tmp_path / f"{name}_{place}"
            folder.mkdir()
            for i in range(FRAMES):
                np.save(folder / f"{i:03d}.npy", recording[i].depth)
    write_sensor(tmp_path / "known.json", known)
    camera = recording_of(known, 0, 1).camera
    folders = {name: [str(tmp_path / f"{name}_{place}") for place in range(5)] for name in ("recorded", "simulated")}
    words = ["explain", *folders["recorded"], "--simulated", *folders["simulated"], "-o", str(tmp_path / "out")]
    words += ["--sensor", str(tmp_path / "known.json"), "--camera"]
    assert main([*words, f"{camera.fx},{camera.fy},{camera.cx},{camera.cy}", "--no-report"]) == 0
    (claim,) = json.loads((tmp_path / "out" / "verdict.json").read_text())["missing"]
    scale = claim["parameters"]["scale"]
    assert claim["effect"] == "depth_scale" and abs(scale["value"] + 0.006) < 3 * scale["std"] < 0.003
    told = " ".join(capsys.readouterr().out.split())
    assert "Missing in the simulation: depth scale" in told and "one of the simulation's own" in told


@pytest.mark.slow
def test_another_simulator_without_noise_serves_too():
    silent = Sensor("geometry", "itof", ())
    found = explain(all_of(sensor_of("itof"), 1), sensor_of("itof"), simulated=all_of(silent, 2))
    assert verdict_of(found).missing == ()


def test_frames_are_matched_by_order_or_by_time():
    one = recording_of(sensor_of("itof"), 0, 1)
    fewer = replace(one, timestamps=one.timestamps[2:], load=lambda i: one.load(i + 2))
    (match,) = matched([one], [fewer])
    assert match.partner.tolist() == [-1, -1, 0, 1, 2, 3, 4]


@pytest.mark.parametrize("wrong", ["number", "size", "time"])
def test_what_does_not_fit_is_told_in_one_line(wrong):
    one = recording_of(sensor_of("itof"), 0, 1)
    other = replace(one, timestamps=one.timestamps[:3] + 50.0)
    if wrong == "size":
        other = replace(one, camera=replace(one.camera, width=64))
    with pytest.raises(RecordingError) as error:
        matched([one], [one, one] if wrong == "number" else [other])
    assert "\n" not in str(error.value)
