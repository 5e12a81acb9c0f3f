"""Every fault that a scan knows of turns on its own light, the worst stands first, and a good scan has none."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from made_up_scan import AGREEING, CAMERA, COUNT, good_scan, with_evidence, with_motion

from fusion.certainty.common import Common
from fusion.certainty.shared import NOTHING
from fusion.certainty.sigma import Sure
from fusion.commands.scan.turntable import failure, lines
from fusion.files.json_values import json_text
from fusion.mesh.mesh import Mesh
from fusion.results.facts import Gap
from fusion.scan.judging.pulled import Pulled
from fusion.turntable.focal import FocalCheck
from fusion.turntable.jumps import Jump
from fusion.turntable.selfcheck import NAMES
from fusion.turntable.steps import judge_steps

WRONG = FocalCheck(0.09, 0.008, 6.0, COUNT)
UNSURE = FocalCheck(0.03, 0.008, 6.0, COUNT)
CALIBRATED = replace(CAMERA, std={"fx": 0.6})


def light(scan, subject):
    (found,) = [x for x in scan.judgement.lights if x.subject == subject]
    return found


def test_a_good_scan_has_only_good_lights():
    judgement = good_scan().judgement
    assert judgement.level == "ok" and judgement.warnings == ()
    assert len(judgement.lines()) == 1 and judgement.lines()[0].startswith("good")
    json_text(judgement.lights)


def without_a_side(scan):
    mesh = scan.mesh
    up = np.cross(*(mesh.vertices[mesh.faces[:, k]] - mesh.vertices[mesh.faces[:, 0]] for k in (1, 2)))
    return Mesh(mesh.vertices, mesh.faces[up[:, 1] <= 1e-9])


def on_a_board(scan, apart):
    """The object and a board below it, so far from it [m]; what it stands on was not found."""
    board = trimesh.creation.box((0.2, 0.2, 0.02)).apply_translation((0, 0, -0.01 - apart))
    mesh = Mesh(
        np.vstack([scan.mesh.vertices, board.vertices]),
        np.vstack([scan.mesh.faces, board.faces + len(scan.mesh.vertices)]).astype(np.int32),
    )
    return with_motion(replace(scan, mesh=mesh), plate=None)


def depth_error(size):
    values = np.zeros(len(NAMES))
    values[NAMES.index("bend2")] = size
    return values


def contradicted(share):
    return replace(AGREEING, through=np.full(4, share))


def off_its_log(scan):
    """Steps hardly scatter, yet the angles swing by 8 deg about what was told."""
    told = np.deg2rad(10.0) * np.arange(COUNT)
    return replace(with_motion(scan, angles=told + np.deg2rad(8.0) * np.sin(told)), told=told)


def sized(scan, std):
    """A scan of a camera and a depth that are calibrated, whose size is known so well."""
    common = Common(0.0005, 0.001, 0.9, "calibration", std)
    parts = {"noise": 1e-4, "calibration": 1e-4}
    sure = Sure(np.full(len(scan.mesh.vertices), 1e-4, np.float32), parts, (), NOTHING, common, 0.0)
    return replace(with_motion(scan, size_std=std), sure=sure)


PLANTED = {
    "Camera": [
        ("bad", lambda s: with_evidence(s, focal=WRONG, stated_camera=CALIBRATED)),
        ("warning", lambda s: with_evidence(s, focal=WRONG, refined=True)),
        ("warning", lambda s: with_evidence(s, focal=UNSURE)),
        ("warning", lambda s: with_evidence(s, focal=FocalCheck(0.01, 0.03, 6.0, COUNT))),
    ],
    "Depth": [("bad", lambda s: with_motion(s, camera_check=replace(s.motion.camera_check, values=depth_error(0.02))))],
    "Table": [
        ("bad", lambda s: replace(s, wobble=0.05)),
        (
            "warning",
            lambda s: replace(
                s, steps=judge_steps(np.where(np.arange(COUNT) > 20, 0.2, 0) + s.motion.angles, s.motion.angle_std)
            ),
        ),
    ],
    "Log": [
        ("warning", off_its_log),
        ("warning", lambda s: replace(s, told=-s.motion.angles)),
        ("bad", lambda s: replace(s, told=s.motion.angles / 57.3)),
        ("bad", lambda s: replace(s, told=1.5 * s.motion.angles)),
    ],
    "Standing still": [("bad", lambda s: with_evidence(s, jump=Jump(17, 0.008, "camera")))],
    "Closing": [
        ("bad", lambda s: replace(s, closure=Gap(0.001, 0.015, 8.0))),
        ("warning", lambda s: replace(s, closure=Gap(0.03, 0.0, 4.0))),
    ],
    "Frames": [
        ("warning", lambda s: with_motion(s, rejected=dict.fromkeys(range(4), "a hand"))),
        ("bad", lambda s: with_motion(s, rejected=dict.fromkeys(range(len(s.motion.angles) // 5), "a hand"))),
        ("bad", lambda s: with_motion(s, rejected=dict.fromkeys(range(20), "a hand"))),
    ],
    "Fit": [
        ("bad", lambda s: replace(s, residual=np.full(COUNT, 0.009))),
        ("bad", lambda s: replace(s, residual=np.full(COUNT, np.nan))),
    ],
    "Agreement": [
        ("warning", lambda s: with_evidence(s, agreement=contradicted(0.05))),
        ("bad", lambda s: with_evidence(s, agreement=contradicted(0.15))),
        ("bad", lambda s: with_evidence(s, agreement=contradicted(0.4))),
        ("bad", lambda s: with_evidence(s, agreement=replace(s.evidence.agreement, bent=0.001))),
    ],
    "Poses": [
        ("warning", lambda s: with_evidence(sized(s, None), pulled=Pulled(0.25e-4, 0.0))),
        ("bad", lambda s: with_evidence(sized(s, None), pulled=Pulled(0.5e-4, 0.0))),
        ("bad", lambda s: with_evidence(sized(s, None), pulled=Pulled(0.0, 0.3))),
    ],
    "Coverage": [("bad", lambda s: with_motion(s, angles=0.5 * s.motion.angles))],
    "Size": [("warning", lambda s: sized(s, 0.004)), ("warning", lambda s: sized(s, 0.02))],
    "Surface": [
        ("warning", lambda s: replace(s, mesh=without_a_side(s))),
        ("bad", lambda s: with_evidence(s, kept_share=0.6)),
    ],
    "Plate": [
        ("bad", lambda s: on_a_board(s, 0.01)),
        ("bad", lambda s: with_motion(s, plate=0.0, table=-0.066, plate_thickness=0.24)),
    ],
}


@pytest.mark.parametrize(
    ("subject", "level", "plant"), [(name, *rest) for name, cases in PLANTED.items() for rest in cases]
)
def test_a_planted_fault_turns_on_its_own_light(subject, level, plant):
    scan = plant(good_scan())
    found = light(scan, subject)
    assert found.level == level and found.do, "what to do is said with it"
    others = [x for x in scan.judgement.lights if x.subject != subject and x.level != "ok"]
    assert others == []
    assert scan.judgement.lights[0] == found
    assert scan.judgement.lines()[0].startswith("PROBLEM" if level == "bad" else "look here")


def test_a_size_that_is_known_well_is_told_and_no_fault():
    known = light(sized(good_scan(), 0.001), "Size")
    assert known.level == "ok" and "0.11 %" in known.reason  # with half a thousandth of the focal length
    assert not [x for x in good_scan().judgement.lights if x.subject == "Size"], "nothing says how wrong the depth is"


def test_the_size_is_part_of_what_all_vertices_share():
    scan = sized(good_scan(), 0.004)
    assert scan.sure.common.scale == pytest.approx(np.hypot(0.004, 0.0005))
    assert replace(scan.sure.common, size=None).scale == pytest.approx(np.hypot(0.001 / 0.9, 0.0005))


def test_the_worst_stands_first():
    scan = with_evidence(replace(good_scan(), closure=Gap(0.03, 0.0, 4.0)), jump=Jump(17, 0.008, "object"))
    assert [x.level for x in scan.judgement.lights[:3]] == ["bad", "warning", "ok"]


def test_a_closing_angle_that_got_worse_is_said_so():
    scan = replace(good_scan(), closure=Gap(0.03, 0.001, 4.0), closure_raw=Gap(0.01, 0.001, 1.0))
    assert "the angle got worse" in light(scan, "Closing").reason


def test_a_log_in_radians_is_called_that():
    assert "radians" in light(replace(good_scan(), told=good_scan().motion.angles / 57.3), "Log").do


@pytest.mark.parametrize(
    ("word", "plant"),
    [
        ("good", lambda s: s),
        ("good", lambda s: replace(s, closure=Gap(0.03, 0.0, 4.0))),
        ("doubtful", lambda s: replace(s, wobble=0.05)),
        ("doubtful", lambda s: with_evidence(s, agreement=contradicted(0.15))),
        ("failed", lambda s: replace(with_evidence(s, agreement=contradicted(0.4)), wobble=0.05)),
        ("failed", lambda s: with_motion(s, rejected=dict.fromkeys(range(20), "a hand"))),
    ],
)
def test_the_verdict_is_the_worst_of_the_lights(word, plant):
    scan = plant(good_scan())
    assert scan.judgement.worth.word == word
    assert scan.turntable().verdict == word and bool(scan.turntable().reasons) == (word != "good")
    assert lines(scan)[0].startswith(f"verdict   {word}")
    assert (failure(scan, "scan") is not None) == (word == "failed")


def test_patches_off_the_surface_are_told_with_their_size():
    scan = with_evidence(good_scan(), agreement=replace(contradicted(0.0), bent=0.0012))
    said = light(scan, "Agreement")
    assert said.level != "ok" and "1.20 mm" in said.reason and "contradict" not in said.reason


def test_what_made_a_scan_fail_stands_first():
    scan = replace(with_evidence(good_scan(), agreement=contradicted(0.4)), wobble=0.05)
    assert "contradict the surface" in scan.turntable().reasons[0]
    assert "--keep-failed" in str(failure(scan, "scan"))


def test_a_calibrated_camera_that_a_scan_contradicts_may_have_a_wrong_depth_law():
    scan = with_evidence(good_scan(), focal=WRONG, stated_camera=CALIBRATED)
    assert "depth law" not in light(scan, "Camera").reason
    done = replace(scan.settings.correction, undone_m={"depth_offset": 0.003})
    corrected = replace(scan, settings=replace(scan.settings, correction=done))
    assert "depth law" in light(corrected, "Camera").reason and "more walls" in light(corrected, "Camera").do


def test_what_has_no_print_is_not_asked_for_it():
    assert not [x for x in good_scan().judgement.lights if x.subject == "Print"]


def test_where_a_scan_with_a_log_fails_the_log_is_a_suspect():
    told = np.deg2rad(10.0) * np.arange(COUNT)
    failed = with_evidence(good_scan(), agreement=contradicted(0.5))
    assert "--ignore-log" in failure(replace(failed, told=told), "scan").do
    assert "--ignore-log" not in failure(failed, "scan").do


def test_a_failed_scan_of_nothing_that_turns_says_so():
    failed = with_evidence(good_scan(), agreement=contradicted(0.5))
    assert "Nothing turns" not in light(failed, "Agreement").do
    still = with_motion(failed, angles=np.deg2rad(0.1) * np.arange(COUNT))
    assert light(still, "Agreement").do.startswith("Nothing turns: all views lie within")
    assert "fusion reconstruct" in light(still, "Agreement").do


@pytest.mark.parametrize(("share", "told"), [(0.0, False), (0.015, False), (0.07, True)])
def test_thin_parts_are_told_where_there_are_some(share, told):
    lights = with_evidence(good_scan(), thin_share=share).judgement.lights
    assert ["Thin parts" in light.subject for light in lights].count(True) == int(told)


def test_views_that_go_to_and_fro_and_nowhere_are_told():
    """A plain bottle: shape alone let each view slip as its noise asked for."""
    slips = np.deg2rad(4.0) * np.random.default_rng(0).uniform(-1, 1, COUNT)
    lost = with_motion(good_scan(), angles=slips)
    assert "to and fro" in light(lost, "Coverage").reason and "--step" in light(lost, "Coverage").do
    few = with_motion(good_scan(), angles=np.deg2rad(0.7) * np.arange(COUNT) + slips / 40)
    for other in (few, replace(lost, told=slips)):
        assert light(other, "Coverage").level == "bad" and "to and fro" not in light(other, "Coverage").reason
