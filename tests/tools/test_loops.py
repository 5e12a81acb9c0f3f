"""Walks that come back: what is rendered, what the judge measures, and that it tells right from wrong."""

import json
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from tools.sets import loops
from tools.sets.judging.command import Ran
from tools.sets.judging.writing import Recording, trajectory
from tools.sets.loop_scenes import course, frames, judged, kinect, making, walks, words
from tools.sets.loop_scenes.place.scenery import Lens, View
from tools.sets.planted.measure import Surface

TINY = Lens(80, 60, 72.0)
EVERY = {"plain": 40, "lost": 3, "table": 40, "open": 20}


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Each scene, few frames of few pixels."""
    folder = tmp_path_factory.mktemp("made")
    for name in ("plain", "table", "open"):
        making.make(name, 1, folder / name, TINY, EVERY[name])
    return folder


@pytest.mark.parametrize("name", ["plain", "table", "open"])
def test_depth_lies_on_the_true_mesh_at_the_true_poses(made, name):
    truth = judged.truth_of(made / name / "truth")
    seen, mesh = frames.read(made / name / "recording"), trimesh.load(truth.mesh, process=False)
    assert len(truth.course.times) == len(seen.times) > 8
    for k in (0, len(seen.times) // 2):
        T = truth.course.poses[k]
        points = seen.points(k) @ T[:3, :3].T + T[:3, 3]
        assert np.median(Surface(mesh).distance(points)) < 0.012  # Nguyen's noise at 2.5 m is 10 mm
    told = json.loads((made / name / "truth" / "truth.json").read_text())
    assert told["returns"] == (name != "open")
    turn = truth.course.poses[0][:3, :3].T @ truth.course.poses[-1][:3, :3]
    assert told["turned_deg"] > (360 if told["returns"] else 120)
    if told["returns"]:
        assert Rotation.from_matrix(turn).magnitude() < np.deg2rad(60)


def test_a_recording_holds_no_truth_and_is_made_of_its_seed(made, tmp_path):
    assert {p.name for p in (made / "plain/recording").iterdir()} == {
        "camera.json", "depth", "depth.txt", "rgb", "rgb.txt"
    }  # fmt: skip
    for seed in (1, 2):
        making.make("plain", seed, tmp_path / str(seed), TINY, EVERY["plain"])
    files = sorted(p.relative_to(made / "plain") for p in (made / "plain").rglob("*.png"))
    same = [(made / "plain" / p).read_bytes() == (tmp_path / "1" / p).read_bytes() for p in files]
    assert files and all(same)
    other = sorted((tmp_path / "2").rglob("*.png"))
    assert other[0].read_bytes() != (made / "plain" / files[0]).read_bytes()


def test_a_jerk_loses_the_view_and_what_comes_after_was_seen_before():
    for seed in range(5):
        walk = walks.round_a_room(np.random.default_rng(seed), (4.5, 4.0), 0.0, True, jerked=True)
        assert 300 <= len(walk.times) <= 520
        (gap,) = walk.gaps
        blank = np.flatnonzero(walk.blank)
        assert walk.blank.sum() >= 5 and walk.times[gap] - walk.times[gap - 1] > 3 / walks.RATE
        after = blank[-1] + 1
        turn = Rotation.from_matrix(walk.poses[:, :3, :3])
        assert (turn[gap - 5].inv() * turn[after]).magnitude() > np.deg2rad(30)
        before = (turn[:gap].inv() * turn[after]).magnitude()
        assert before.min() < np.deg2rad(12)


def test_what_is_carried_is_uncovered_elsewhere_at_what_was_seen():
    for seed in range(5):
        walk = walks.round_a_room(np.random.default_rng(seed), (4.5, 4.0), 0.0, True, carried=True)
        assert 300 <= len(walk.times) <= 500
        last, after = np.flatnonzero(walk.blank)[0] - 1, np.flatnonzero(walk.blank)[-1] + 1
        assert walk.times[after] - walk.times[last] > 1.5
        turn = Rotation.from_matrix(walk.poses[:, :3, :3])
        assert (turn[last].inv() * turn[after]).magnitude() > np.deg2rad(60)  # more than a picture is wide
        assert np.linalg.norm(walk.poses[last, :3, 3] - walk.poses[after, :3, 3]) > 0.4
        assert (turn[:last].inv() * turn[after]).magnitude().min() < np.deg2rad(20)  # more than half of the picture


def test_a_hand_shakes_by_centimetres_and_degrees():
    for seed in range(5):
        still = np.tile(np.eye(4), (400, 1, 1))
        shaken = walks.by_hand(np.random.default_rng(seed), still)
        assert 0.008 < np.linalg.norm(shaken[:, :3, 3], axis=1).std() * 2 < 0.04
        degrees = np.rad2deg(Rotation.from_matrix(shaken[:, :3, :3]).magnitude())
        assert 0.8 < np.sqrt((degrees**2).mean()) < 2.5
        assert (
            np.rad2deg(
                Rotation.from_matrix(shaken[:-1, :3, :3].transpose(0, 2, 1) @ shaken[1:, :3, :3]).magnitude()
            ).max()
            < 2
        )


@pytest.mark.parametrize(("z", "sigma"), [(1.0, 0.0019), (2.0, 0.0061), (3.0, 0.0140)])
def test_noise_is_as_published(z, sigma):
    camera = kinect.Kinect(Lens(640, 480, 575.0))
    flat = np.full((480, 640), z)
    view = View(flat, np.zeros(flat.shape), flat < 0, flat < 0, np.zeros((*flat.shape, 3)))
    depth = camera.depth(view, np.zeros(2), np.random.default_rng(0))
    assert (depth > 0).mean() > 0.97
    step = z**2 * kinect.STEP / (575 * kinect.BASELINE)  # Khoshelham and Elberink: 3 mm at 1 m, 7 cm at 5 m
    assert np.std(depth[depth > 0]) == pytest.approx(np.hypot(sigma, step / np.sqrt(12)), rel=0.1)
    assert np.diff(np.unique(depth[depth > 0])).min() == pytest.approx(step, rel=0.3, abs=0.0011)
    grazing = View(flat, np.full(flat.shape, 1.45), flat < 0, flat < 0, np.zeros((*flat.shape, 3)))
    assert not camera.depth(grazing, np.zeros(2), np.random.default_rng(0)).any()


def test_edges_lose_depth_and_the_projector_throws_a_shadow():
    z = np.full((120, 160), 2.0)
    z[:, 60:100] = 1.0
    edge = kinect.edges(z)
    assert edge[:, [59, 60, 99, 100]].all() and not edge[:, :55].any()
    u = np.arange(160)
    slanted = 143 / (70 + 0.4 * (u - 80.0))[None].repeat(120, axis=0)  # a steep plane
    assert not kinect.edges(slanted)[2:-2, 2:-2].any()
    dark = np.flatnonzero(kinect.shaded(z, 10.0)[0])
    assert len(dark) == pytest.approx(5, abs=1) and (dark.min() >= 100 or dark.max() < 60)


def bent(poses, metres):
    """The same course with an error that grows to `metres` at its end."""
    out = poses.copy()
    out[:, :3, 3] += np.linspace(0, 1, len(poses))[:, None] * [metres, 0, 0]
    return out


def test_errors_are_those_of_evo(made):
    metrics = pytest.importorskip("evo.core.metrics")
    from evo.core.trajectory import PoseTrajectory3D

    true = judged.truth_of(made / "plain/truth").course
    turn = np.eye(4)
    turn[:3, :3], turn[:3, 3] = Rotation.from_rotvec([0.3, -1, 0.5]).as_matrix(), [1, 2, 3]
    found = course.Course(true.times, turn @ bent(true.poses, 0.2))
    ours = course.off_course(found, true, np.array([[0, 0, 2.0]]))
    a = PoseTrajectory3D(timestamps=true.times, poses_se3=list(true.poses))
    b = PoseTrajectory3D(timestamps=true.times, poses_se3=list(found.poses))
    b.align(a)
    ape = metrics.APE(metrics.PoseRelation.translation_part)
    ape.process_data((a, b))
    assert ours.ate == pytest.approx(ape.get_statistic(metrics.StatisticsType.rmse), abs=1e-9)
    assert ours.drift == pytest.approx(0.2) and ours.gap == pytest.approx(0.2) and ours.drift_deg < 1e-6


def ruled(monkeypatch, folder, output, poses, says, left_out=()):
    """The judge's ruling on a program that writes these poses and says this."""
    truth = judged.truth_of(folder / "truth")
    kept = [k for k in range(len(poses)) if k not in left_out]

    def program(*arguments):
        there = Path(arguments[arguments.index("-o") + 1])
        there.mkdir()
        trajectory(there / "trajectory.txt", truth.course.times[kept], np.linalg.inv(poses[0]) @ poses[kept])
        mesh = trimesh.load(truth.mesh, process=False)
        mesh.apply_transform(np.linalg.inv(poses[0]))
        mesh.export(there / "mesh.ply")
        told = {"result": {"placed": len(kept)}, "judgement": [{"level": "ok", "subject": "Course", "reason": says}]}
        (there / "settings.json").write_text(json.dumps(told))
        return Ran(0, "", 1.0)

    monkeypatch.setattr(judged, "fusion", program)
    return judged.judged("tiny", folder / "recording", truth, output, True)


def test_the_judge_tells_a_perfect_course_from_a_wrong_one(made, tmp_path, monkeypatch):
    true = judged.truth_of(made / "plain/truth").course.poses
    right = ruled(monkeypatch, made / "plain", tmp_path / "a", true, "the loop closed within 3 mm")
    assert right.misses == () and right.own.off.ate < 1e-6 and right.own.mesh.median < 1e-5
    drifted = ruled(monkeypatch, made / "plain", tmp_path / "b", bent(true, 0.3), "the loop closed within 3 mm")
    assert drifted.own.off.gap == pytest.approx(0.3, abs=1e-3)
    assert any("loop open by 300 mm" in miss for miss in drifted.misses)
    assert any("nothing warns of drift" in miss for miss in drifted.misses)
    silent = ruled(monkeypatch, made / "plain", tmp_path / "c", true, "fine")
    assert silent.misses == ("the loop is closed, and it is not said",)
    few = ruled(monkeypatch, made / "plain", tmp_path / "d", true, "the loop closed", left_out=(4, 5))
    assert few.placed == len(true) - 2
    assert any("of the frames with depth placed" in miss for miss in few.misses)
    assert any("2 frames have no pose" in miss for miss in few.misses)
    open_walk = judged.truth_of(made / "open/truth").course.poses
    assert ruled(monkeypatch, made / "open", tmp_path / "e", open_walk, "the loop closed").misses
    honest = "nothing was seen twice: drift is not checked"
    assert not ruled(monkeypatch, made / "open", tmp_path / "f", open_walk, honest).misses


def test_open3d_follows_what_it_sees_and_stays_where_it_sees_nothing(tmp_path):
    """Its ray casts lie about a voxel beside its surface: a still camera creeps by some voxels."""
    scene, camera = making.SCENES["plain"](np.random.default_rng(3)), kinect.Kinect(Lens(160, 120, 144.0))
    recording = Recording(tmp_path / "recording", dict(camera.camera))
    poses = scene.walk.poses[[0, 1, 2, 2, 3, 4]]
    for k, T in enumerate(poses):
        recording.depth(0.1 * k, scene.scenery.seen(camera.lens, T).z * (k != 3))
    recording.done()
    judged.followed(tmp_path / "recording", tmp_path / "out", 0.01, 4.0)
    found = course.read(tmp_path / "out/trajectory.txt")
    off = course.off_course(found, course.Course(found.times, poses), np.array([[0, 0, 2.0]]))
    assert len(found.times) == 6 and off.gap < 0.05 and np.allclose(found.poses[3], found.poses[2])
    assert json.loads((tmp_path / "out/peer.json").read_text())["failed"] == [3]
    assert (tmp_path / "out/mesh.ply").is_file()


def told(*sentences, alarms=(), status=0, placed=100):
    return words.Told(status, (*sentences, *alarms), alarms, placed, False)


def facts(gap=0.01, returns=True, placed=100, blank=0, worst=0.02):
    return words.Facts(100, placed, blank, gap, 0.03, worst, 0.25, returns)


@pytest.mark.parametrize(
    ("said", "true", "agree"),
    [
        (told("the loop closed"), facts(), True),
        (told("7 places were seen again: 45 mm of drift were taken out"), facts(), True),
        (told("nothing was seen twice: drift is not checked"), facts(), False),
        (told(), facts(), False),
        (told(alarms=("Drift: nothing closes this walk",)), facts(0.2), True),
        (told("the loop closed"), facts(0.2), False),
        (told(alarms=("Surface: in 19 parts",)), facts(0.2), False),
        (told("nothing was seen twice: drift is not checked"), facts(returns=False), True),
        (told("closed"), facts(returns=False), False),
        (told("the loop closed", placed=98), facts(placed=100), False),
        (told("the loop closed", placed=98), facts(placed=98), False),
        (told("the loop closed", "2 frames without depth were left out", placed=98), facts(placed=98), True),
        (told("the loop closed"), facts(blank=2), False),
        (told("the loop closed"), facts(worst=1.0), False),
        (told("the loop closed", alarms=("Course: 9 frames may be placed wrong",)), facts(worst=1.0), True),
        (told("no such file", status=1), facts(None), False),
        (told("whatever"), facts(returns=None), True),
        (told("mesh 1 x 1 x 1 m, closed, no holes"), facts(), False),
    ],
)
def test_what_is_said_is_held_against_the_truth(said, true, agree):
    assert (not words.disagreements(said, true)) == agree


def test_stages_that_pass_are_no_statements(tmp_path):
    terminal = "   5 s  closing loops 1 of 3\ngood      Frames\ntook      9 s: closing loops 3, lost frames 2\n"
    read = words.read(tmp_path, Ran(0, terminal, 9.0))
    assert read.sentences == ("good      Frames",) and not read.says_closed and not read.says_lost


def test_the_exit_status_tells_whether_all_is_reached(tmp_path, monkeypatch, capsys):
    for misses, status in (((), 0), (("loop open by 300 mm, asked 30",), 1)):
        one = judged.Judged("open_seed4", 10, 10, 10, judged.Side(None, None, 1.0), None, float("nan"), misses, ())
        monkeypatch.setattr(loops, "judged", lambda *_, one=one: one)
        monkeypatch.setattr(loops, "truth_of", lambda _: None)
        monkeypatch.setattr(loops, "make", lambda *_: None)
        output = tmp_path / str(status)
        output.mkdir()
        monkeypatch.setattr(sys, "argv", ["loops.py", "-o", str(output), "--scenes", "open", "--seed", "4"])
        assert loops.main() == status
        assert all(miss in capsys.readouterr().out for miss in misses)
        assert json.loads((output / "table.json").read_text())[0]["ratio"] is None


def test_colour_and_depth_are_of_one_size(made):
    for name in ("rgb", "depth"):
        file = sorted((made / "table/recording" / name).iterdir())[0]
        assert cv2.imread(str(file), cv2.IMREAD_UNCHANGED).shape[:2] == (60, 80)
