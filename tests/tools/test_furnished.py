"""The furnished rooms: what is made stays by the contract, the same, and apart from its answer; verdicts are scored."""

import ast
import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from tools.trial.furnished import making
from tools.trial.furnished.check import checked
from tools.trial.furnished.making import made
from tools.trial.furnished.plan import Spec, plan
from tools.trial.furnished.planted.catalogue import FLIGHT, MATCHING
from tools.trial.furnished.scoring import CaseRow, scored, table

ROOM = Path(__file__).resolve().parents[2] / "tools" / "trial" / "furnished"
HARNESS = {"__main__", "running", "scoring"}  # they start the engine and score it, and make nothing
SPECS = {"null": Spec(null="plain"), "planted": Spec(("disparity_offset",), "tri")}


@pytest.fixture(scope="module", params=SPECS, ids=str)
def case(request, tmp_path_factory):
    """A small case: its name, its folder of all cases, and another one of the same seed."""
    folders = [tmp_path_factory.mktemp(f"{request.param}_{name}") for name in "ab"]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(making, "BUDGET", dict.fromkeys(making.BUDGET, 3e5))  # fewer frames, all the same
        answers = [made(7, 0, SPECS[request.param], folder).answer for folder in folders]
    assert answers[0] is not None
    return request.param, *folders


def files_of(folder):
    return sorted(path.relative_to(folder) for path in folder.rglob("*") if path.is_file())


def test_files_are_those_of_the_contract(case):
    folder = case[1] / "cases" / "case_000"
    sensor = json.loads((folder / "sensor.json").read_text(encoding="utf-8"))
    assert sensor["format"] == "fusion-sensor/1"
    recordings = sorted(folder.glob("rec_*"))
    assert len(recordings) >= 3
    for recording in recordings:
        camera = json.loads((recording / "camera.json").read_text(encoding="utf-8"))
        scene = json.loads((recording / "scene.json").read_text(encoding="utf-8"))
        assert (recording / scene["mesh"]).read_bytes().startswith(b"ply\n")
        assert camera["principle"] == sensor["principle"]
        rows = [line.split() for line in (recording / "depth.txt").read_text().splitlines()[1:]]
        poses = [line.split() for line in (recording / "groundtruth.txt").read_text().splitlines()[1:]]
        assert [row[0] for row in rows] == [pose[0] for pose in poses]
        for _, name in rows:
            image = cv2.imread(str(recording / name), cv2.IMREAD_UNCHANGED)
            assert image.dtype == np.uint16
            assert image.shape == (camera["height"], camera["width"])
            assert (image > 0).mean() > 0.5


def test_the_same_seed_makes_the_same_bits(case):
    _, here, there = case
    files = [name for name in files_of(here) if name.suffix != ".npz"]  # zip files tell their time
    assert files == [name for name in files_of(there) if name.suffix != ".npz"]
    assert all((here / name).read_bytes() == (there / name).read_bytes() for name in files)


def test_the_answer_is_not_in_the_case(case):
    kind, out, _ = case
    answer = json.loads((out / "answers" / "case_000.json").read_text(encoding="utf-8"))
    assert answer["truth"] == list(SPECS[kind].effects)
    texts = [path for path in (out / "cases").rglob("*") if path.suffix in (".json", ".txt", ".csv")]
    assert {path.name for path in texts if path.suffix == ".json"} == {"camera.json", "scene.json", "sensor.json"}
    told = " ".join(path.read_text(encoding="utf-8") for path in texts)
    assert not [name for name in ("truth", "also_right", "disparity_offset", "nothing") if name in told]


def test_its_own_reader_finds_what_is_told(case):
    kind, out, _ = case
    figures = checked(out, "case_000")
    assert figures["valid"] > 0.9
    if kind == "null":
        # noise as told, but for what rounding adds; thousands of pixels
        assert figures["spread"] == pytest.approx(1, abs=0.1)
    else:
        assert figures["slope"] == pytest.approx(1, abs=max(0.05, 5 * figures["slope_std"]))


def test_a_case_that_was_made_is_kept(case):
    out = case[1]
    file = out / "answers" / "case_000.json"
    before = file.stat().st_mtime_ns
    assert made(7, 0, Spec(null="plain"), out).answer == json.loads(file.read_text(encoding="utf-8"))
    assert file.stat().st_mtime_ns == before


def test_a_plan_has_nulls_single_effects_and_pairs():
    specs = plan(72, 30)
    assert specs == plan(72, 30)
    assert sorted(len(spec.effects) for spec in specs) == [0] * 9 + [1] * 16 + [2] * 5
    assert all(set(spec.effects) <= {*FLIGHT, *MATCHING} for spec in specs)
    assert {spec.kind for spec in specs if len(spec.effects) == 1} == {"one"}


def claim(name, *alike):
    return {"effect": name, "indistinguishable_from": list(alike)}


@pytest.mark.parametrize(
    ("truth", "also", "claims", "outcome", "wrong"),
    [
        ([], [], [], "quiet", 0),
        ([], [], [claim("depth_offset")], "wrong", 1),
        ([], ["reference_shape_error"], [claim("reference_shape_error")], "right", 0),
        (["depth_scale"], [], [], "silent", 0),
        (["depth_scale"], [], [claim("depth_scale")], "right", 0),
        (["depth_scale"], [], [claim("focal_length", "depth_scale")], "set", 0),
        (["defocus"], ["mixed_pixels"], [claim("mixed_pixels")], "right", 0),
        (["depth_scale"], [], [claim("depth_scale"), claim("unknown")], "wrong", 1),
        (["depth_scale"], [], [claim("depth_offset"), claim("unknown")], "wrong", 2),
    ],
)
def test_a_claim_is_right_by_its_name_or_by_its_look_alikes(truth, also, claims, outcome, wrong):
    said = scored({"missing": claims}, {"truth": truth, "also_right": also})
    assert (said.outcome, said.claims, said.wrong) == (outcome, len(claims), wrong)


def test_no_verdict_is_a_refusal_and_counts_as_nothing_else():
    refused = scored(None, {"truth": ["depth_scale"]}, "fusion explain: no scene")
    quiet = scored({"missing": []}, {"truth": []})
    assert (refused.outcome, refused.words) == ("refused", "fusion explain: no scene")
    rows = [CaseRow("case_000", "one", ["depth_scale"], refused, 1.0), CaseRow("case_001", "nothing", [], quiet, 1.0)]
    shares = {text[:46].strip(): text[46:].split() for text in table(rows).splitlines()}
    assert shares["refused, of all"][:3] == ["1", "of", "2"]
    # 0 of 1: the exact interval reaches to 0.975
    assert shares["cases with a wrong established claim"] == ["0", "of", "1", "0.00", "[0.00,", "0.97]"]
    assert shares["right, by name or by set, of those planted"] == ["none"]


@pytest.mark.parametrize("path", sorted(ROOM.rglob("*.py")), ids=lambda path: str(path.relative_to(ROOM)))
def test_the_generator_imports_nothing_of_the_package_nor_of_other_generators(path):
    tree = ast.parse(path.read_text(encoding="utf-8"))
    names = [node.module or "" for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)]
    names += [alias.name for node in ast.walk(tree) if isinstance(node, ast.Import) for alias in node.names]
    assert "fusion" not in {name.split(".")[0] for name in names}
    own = [name for name in names if name.startswith("tools.")]
    assert path.stem in HARNESS or all(name.startswith("tools.trial.furnished.") for name in own)
