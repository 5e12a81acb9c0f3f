"""The trial's own physics, labels and scores: what they must hold whatever the engine says."""

import ast
import json
from pathlib import Path

import numpy as np
import pytest

from tools.trial.asked import kind_asked
from tools.trial.case import Order, tried
from tools.trial.concealed.decks import Setting, camera_of, shots_of
from tools.trial.concealed.laws.flight import Flight
from tools.trial.concealed.laws.law import Law
from tools.trial.concealed.laws.matching import Matching
from tools.trial.concealed.making import make
from tools.trial.concealed.more import ASKED, asked_shots
from tools.trial.concealed.oracle import _mean as tile_mean
from tools.trial.concealed.oracle import _poses as oracle_columns
from tools.trial.concealed.oracle import oracle_of
from tools.trial.concealed.rays import cast, nudged
from tools.trial.concealed.turning import Turn, runs_of, table_shots
from tools.trial.figures import figures, table
from tools.trial.on_batch import tried_on_workers
from tools.trial.scoring import interval, likeness, score
from tools.trial.sealing import digest, sealed

TRIAL = Path(__file__).resolve().parents[2] / "tools" / "trial"


def made(family, folder, seed=(5, 1)):
    case = make(family, list(seed), folder)
    assert case is not None
    return case


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


@pytest.mark.slow
def test_the_same_seed_makes_the_same_case_and_no_label_in_its_folder(tmp_path):
    labels = [made("null", tmp_path / name).label for name in "ab"]
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


@pytest.mark.parametrize("path", sorted((TRIAL / "concealed").rglob("*.py")), ids=lambda p: p.stem)
def test_the_generator_imports_nothing_of_the_package_or_of_the_harness(path):
    tree = ast.parse(path.read_text(encoding="utf-8"))
    names = [n.module or "" for n in ast.walk(tree) if isinstance(n, ast.ImportFrom)]
    names += [alias.name for n in ast.walk(tree) if isinstance(n, ast.Import) for alias in n.names]
    assert not {name.split(".")[0] for name in names} & {"fusion", "trial"}


def test_a_turning_object_is_seen_where_its_table_really_is():
    rng = np.random.default_rng(2)
    camera, runs = camera_of(rng, False), runs_of(rng)
    late, true, stated = (table_shots(camera, runs, turn) for turn in (Turn(late=0.02), Turn(), Turn()))
    for run, (shots, others) in zip(runs, zip(late, true, strict=True), strict=True):
        turned = np.linalg.solve(shots[0].T, others[0].T)
        angle = np.arccos(np.clip((np.trace(turned[:3, :3]) - 1) / 2, -1, 1))
        # the arc cosine near 1 tells an angle to 1e-8 only
        assert angle == pytest.approx(abs(np.deg2rad(run.rate)) * 0.02, abs=1e-7)
    assert np.array_equal(true[0][0].hits.z, stated[0][0].hits.z, equal_nan=True)


def test_rows_of_a_rolling_shutter_lie_between_those_of_its_ends():
    rng = np.random.default_rng(2)
    camera, runs = camera_of(rng, False), runs_of(rng)
    rolled = table_shots(camera, runs, Turn(line=1e-4))[1][3]
    still = table_shots(camera, runs, Turn())[1][3]
    assert len(rolled.bands) == 24
    middle = slice(76, 84)  # 4 rows at most from the stated time, the others 30 to 40
    change = np.abs(rolled.hits.z - still.hits.z)
    change[change > 0.05] = np.nan  # another surface
    ends = np.r_[40:50, 110:120]
    assert np.nanmean(change[middle]) < 0.3 * np.nanmean(change[ends])


def test_errors_of_a_pose_are_those_of_a_moved_camera(shots):
    shot = shots[False][1]
    oracle = oracle_of(Matching(), [shot], np.zeros((0, 2)), 0.0)
    label, native = oracle.moments[0][2], oracle.moments[0][3]
    columns = oracle_columns(shot, label, native)
    for axis in range(6):
        step = 1e-4 * np.eye(6)[axis]
        moved = cast(shot.panels, nudged(shot.T, step), shot.camera.rays()).z
        tiles = tile_mean(np.where(np.abs(moved - shot.hits.z) < 0.05, moved - shot.hits.z, 0.0) * native, label)
        # second order in a step of 1e-4, on walls tilted up to 45 degrees
        assert columns[:, axis] * 1e-4 / 5e-4 == pytest.approx(tiles, rel=0.01, abs=1e-5)


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
    assert interval(0, 30, 0.9) == (0.0, pytest.approx(1 - 0.05 ** (1 / 30)))
    low, high = interval(5, 10)
    assert low == pytest.approx(1 - high)


@pytest.mark.parametrize(
    ("true", "said", "f1"),
    [
        (["radius"], ["u", "v"], 1.0),
        (["v", "depth"], ["v", "range"], 1.0),
        (["v", "depth"], ["v"], 2 / 3),
        (["time"], ["u"], 0.0),
    ],
)
def test_variables_said_in_another_way_count(true, said, f1):
    assert likeness(true, said) == pytest.approx(f1)


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ("", None),
        ("the same target with other values of temperature, time", "time"),
        ("a step of two depths at once, then a black patch", "step"),
        ("rail: a flat wall from distances known against each other, 0.5 to 4 m on a rail or by laser", "rail"),
        ("amplitude switch: the same patches of black, grey and white paper twice from the same place", "light"),
        ("near card switch: a wall at 2 m, with and without a white card close to the camera", "card"),
        ("step target: a board half a metre before a wall, both in the picture", "step"),
        ("rolled camera: the same wall from 1.2 m, the camera upright and turned", "roll"),
        ("the same wall nearer and farther", "distance"),
    ],
)
def test_an_answer_asks_for_a_kind_of_recording(text, kind):
    assert kind_asked(text) == kind


def result(family, outcome, z, **more):
    label = {"family": family, "nothing_missing": "null" in family, "z_o": z, "equivalent": [], "ratio": None}
    of = {"outcome": outcome, "points": 0.0, "claimed": "x", "recalled": 1, "missing": 1}
    of |= {"region": None, "variables": 1.0, "extra": ()}
    return {"case": "c", "label": label, "seconds": 5.0, "score": {**of, "errors": [0.5, 2.0]}, **more}


@pytest.mark.parametrize("kind", [*ASKED, "time"])
def test_every_kind_that_may_be_asked_for_can_be_made(kind, shots):
    more = asked_shots(np.random.default_rng(1), kind, shots[False])
    # a wall or a board is seen by tens of tiles, or the recording tells nothing
    assert all(np.isfinite(shot.hits.z).mean() > 0.2 for shot in more)
    assert len({id(shot.camera) for shot in more}) == 1


def test_figures_count_by_what_the_oracle_could_do():
    gain = {"held out": {"before": 200.0, "engine": 110.0, "oracle": 100.0, "tiles": 100}}
    results = [
        result("null", "quiet", 0.0),
        result("hard null", "false claim", 0.0),
        result("plain", "right", 9.0, gain=gain),
        result("plain", "wrong", 4.0),  # marginal: does not count
        result("unknown", "right", 8.0),
    ]
    rows = {row["measure"]: row for row in figures(results)}
    assert rows["established claims on nulls"]["value"] == 0.5
    assert (rows["right name or right group, oracle 5 sigma"]["hits"], rows["wrong name, oracle 5 sigma"]["of"]) == (
        1,
        1,
    )
    assert rows["unknown, with the right variables"]["hits"] == 1
    assert rows["90 % intervals that hold the true parameter"]["value"] == 0.5
    assert rows["gain against the oracle's, held out: median, deciles"]["value"] == pytest.approx(0.9)
    assert "hard null: c (false claim: x)" in table(results)


@pytest.mark.slow
def test_a_case_on_a_worker_is_the_same_and_is_not_tried_twice(tmp_path):
    pytest.importorskip("distributed")
    order = Order("case_0000", "null", (4711, 0, 0), tmp_path / "here", gain=False)
    order.output.mkdir()
    tried(order)
    here = json.loads((tmp_path / "here" / "case_0000.json").read_text())
    there, again = (next(tried_on_workers([order], tmp_path / "there", 1)) for _ in range(2))
    assert there == again  # the salt of a seal is another one each time
    for key in ("label", "claims", "score", "complaint"):
        assert here[key] == there[key]
    (line,) = (tmp_path / "there" / "seals.txt").read_text().splitlines()
    assert line == f"case_0000 {there['seal']}"


def test_a_case_that_cannot_be_made_is_told(tmp_path):
    pytest.importorskip("distributed")
    order = Order("case_0000", "injected", (4711, 0, 0), tmp_path)
    (result,) = tried_on_workers([order], tmp_path, 1)
    assert "real recordings are absent" in result["absent"]
