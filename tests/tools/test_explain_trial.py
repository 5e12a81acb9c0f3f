"""The trial's own physics, labels and scores: what they must hold whatever the engine says."""

import json
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tools"))

from concealed.decks import Setting, shots_of
from concealed.flight import Flight
from concealed.law import Law
from concealed.making import make
from concealed.matching import Matching
from trial.scoring import interval, score
from trial.sealing import digest, sealed


@pytest.fixture(scope="module")
def shots():
    return {flight: shots_of(np.random.default_rng(3), Setting("walls", flight)) for flight in (True, False)}


@pytest.mark.parametrize("device", [Flight(), Matching()], ids=["flight", "matching"])
def test_without_laws_the_depth_is_the_scene(device, shots):
    shot = shots[isinstance(device, Flight)][1]
    inside = shot.interior
    error = (device.clean(shot, []) - shot.hits.z)[inside]
    # four sub-pixels gathered on a slanted wall: the mean range is not that of the centre, by microns
    assert np.abs(error).max() < 5e-5


@pytest.mark.parametrize("device", [Flight(), Matching()], ids=["flight", "matching"])
def test_noise_of_a_frame_is_as_stated(device, shots):
    shot = shots[isinstance(device, Flight)][1]
    depth, _ = device.record(shot, [], np.random.default_rng(0))
    stated = float(np.sqrt(np.mean(device.sigma(shot)[shot.interior] ** 2)))
    measured = float(np.sqrt(np.mean(depth[:, shot.interior].var(axis=0, ddof=1))))
    # some 5000 pixels of 7 frames: well under 5 %; rounding of the disparity is not quite uniform
    assert measured == pytest.approx(stated, rel=0.1)


def test_a_delay_shifts_the_range_by_itself(shots):
    shot = shots[True][1]
    law = Law("depth_offset", "delay", lambda place: np.full(place.z.shape, 0.003), ())
    change = (Flight().clean(shot, [law]) - Flight().clean(shot, [])) * shot.stretch
    assert np.allclose(change[shot.interior], 0.003, atol=1e-9)


def test_a_harmonic_folds_onto_three_periods_of_the_phase(shots):
    shot = shots[True][1]
    law = Law("cyclic_error", "harmonic", lambda place: [(3, 0.05, np.zeros(3))], ("depth",))
    # the third harmonic is alike in all three samples, and leaves no trace; the second does
    assert np.nanmax(np.abs(Flight().clean(shot, [law]) - Flight().clean(shot, []))) < 1e-9
    law = Law("cyclic_error", "harmonic", lambda place: [(2, 0.05, np.zeros(3))], ("depth",))
    assert np.nanmax(np.abs(Flight().clean(shot, [law]) - Flight().clean(shot, []))) > 1e-3


def test_the_same_seed_makes_the_same_case_and_no_label_in_its_folder(tmp_path):
    labels = [make("null", [5, 1], tmp_path / name) for name in "ab"]
    assert labels[0] == labels[1]
    files = sorted(p.relative_to(tmp_path / "a") for p in (tmp_path / "a").rglob("*") if p.is_file())
    assert all((tmp_path / "a" / f).read_bytes() == (tmp_path / "b" / f).read_bytes() for f in files)
    assert {f.name for f in files if f.suffix == ".json"} == {"camera.json", "scene.json", "sensor.json"}
    assert "family" not in (tmp_path / "a" / "sensor.json").read_text()


def test_a_seal_holds_its_label():
    label = {"family": "plain", "z_o": 7.0}
    seal, salt = sealed(label)
    assert digest(json.loads(json.dumps(label)), salt) == seal
    assert digest({**label, "z_o": 7.1}, salt) != seal


def claim(name, *alike):
    return {"effect": name, "indistinguishable_from": list(alike), "where": {"variables": ["depth"]}}


@pytest.mark.parametrize(
    ("missing", "equivalent", "claims", "points"),
    [
        ([], [], [], 0.0),
        ([], [], [claim("depth_offset")], -2.0),
        (["column_delay"], [], [claim("column_delay")], 1.0),
        (["column_delay"], [], [claim("cyclic_error")], -1.0),
        (["column_delay"], [], [claim("unknown")], 0.0),
        (["column_delay"], [], [], 0.0),
        (["column_delay"], ["emitter_parallax"], [claim("emitter_parallax", "column_delay")], 1.0),
        (["column_delay"], ["emitter_parallax"], [claim("column_delay")], 0.5),
        (["column_delay"], [], [claim("depth_scale", "column_delay")], 0.5),
    ],
)
def test_points_are_those_of_the_challenges(missing, equivalent, claims, points):
    truths = [{"effect": name, "accept": [], "variables": ["u"]} for name in missing]
    label = {"missing": truths, "equivalent": equivalent, "accept_on_null": [], "known_truth": {}}
    assert score({"missing": claims}, label).points == points


def test_interval_of_a_share_is_the_exact_one():
    # 0 of 30: the rule of three at 95 %, one-sided
    assert interval(0, 30) == (0.0, pytest.approx(1 - 0.05 ** (1 / 30)))
    low, high = interval(5, 10)
    assert low == pytest.approx(1 - high)
