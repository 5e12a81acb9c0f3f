"""The spoilers of the stress test: each does what it says to the files and no more, and scores are strict."""

import json
from dataclasses import replace

import numpy as np
import pytest

from fusion.commands.main import main as fusion_main
from tools.sets.judging.command import Ran
from tools.trial.concealed.rays import looking
from tools.trial.spoiled.bases import Base
from tools.trial.spoiled.case import Case, Spoiled, Told, put
from tools.trial.spoiled.catalogue import CONTROL, SPOILS
from tools.trial.spoiled.folder import Taken, quaternion_of, read, rotation_of, write
from tools.trial.spoiled.geometry.planes import planes_of, seen
from tools.trial.spoiled.geometry.ply import changed_ply, read_ply
from tools.trial.spoiled.running import Run
from tools.trial.spoiled.scoring import score
from tools.trial.spoiled.surfaces import walls_bowed
from tools.trial.spoiled.telling import line, summary

WALL = b"""ply
format ascii 1.0
element vertex 4
property float x
property float y
property float z
property uchar red
property uchar green
property uchar blue
element face 2
property list uchar int vertex_indices
end_header
-3 0 -3 90 90 90
3 0 -3 90 90 90
3 0 3 90 90 90
-3 0 3 90 90 90
3 0 1 2
3 0 2 3
"""
SIZE = (48, 64)
CAMERA = {"width": 64, "height": 48, "fx": 60.0, "fy": 60.0, "cx": 31.2, "cy": 23.9, "distortion": [0.0] * 5}
CAMERA |= {"depth_scale": 1000, "principle": "itof", "sensor": "made"}


def wall(number, rng, noise=0.002):
    """A recording of seven frames of the wall at y = 0, in whole millimetres."""
    T = looking(np.array([0.2 * number, -1.2 - 0.2 * number, 0.1]), np.array([0.0, 0, 0]), 0.05)
    times = np.round(100.0 + 50 * number + np.arange(7) / 30, 6)
    row = [*T[:3, 3], *quaternion_of(T[:3, :3])]
    poses = np.array([[t, *row] for t in times])
    scene = {"mesh": "scene.ply", "poses": {"source": "surveyed", "sigma_m": 0.0005, "sigma_rad": 0.0005}}
    log = ["timestamp,temperature_c", *(f"{t:.6f},30.0" for t in times)]
    infrared = [(times[0], np.full(SIZE, 900.0))]
    one = Taken(f"rec_{number:02d}", CAMERA, scene, times, np.zeros((7, *SIZE)), poses, WALL, infrared, log)
    facing = (one.rays() @ one.pose(0)[:3, :3].T)[..., 1]
    z = np.broadcast_to(-one.pose(0)[1, 3] / facing, (7, *SIZE))
    return replace(one, depth=np.round(z + noise * rng.standard_normal(z.shape), 3) if noise else z)


@pytest.fixture(scope="module")
def case():
    rng = np.random.default_rng(1)
    effects = [
        {"effect": "axial_noise", "parameters": {"c0": {"value": 0.002, "unit": "m", "std": 0.0001}}},
        {"effect": "depth_quantization", "parameters": {"step": {"value": 0.001, "unit": "m", "std": 0}}},
    ]
    sensor = {"format": "fusion-sensor/1", "name": "made", "principle": "itof", "effects": effects}
    return Case(tuple(wall(k, rng) for k in range(4)), sensor)


def spoiled(name, case, seed=3):
    return SPOILS[name](case, np.random.default_rng(seed))


def moved(before, after):
    """(n, h, w) change of depth of each recording [m]."""
    return [b.depth - a.depth for a, b in zip(before.recordings, after.recordings, strict=True)]


def test_what_is_not_spoiled_comes_back_as_it_was(case, tmp_path):
    one = case.recordings[1]
    write(one, tmp_path / one.name)
    again = read(tmp_path / one.name)
    assert np.allclose(again.depth, one.depth, atol=1e-9)
    assert again.camera == one.camera  # finer counts would say that depth comes in steps of several
    bent = replace(one, depth=one.depth + 0.0003)
    write(bent, tmp_path / "bent")
    fine = read(tmp_path / "bent")
    assert fine.camera["depth_scale"] % one.camera["depth_scale"] == 0
    assert np.allclose(fine.depth, bent.depth, atol=0.51 / fine.camera["depth_scale"])
    assert np.allclose(again.poses, one.poses, atol=1e-7)
    assert (again.scene, again.mesh, again.log) == (one.scene, one.mesh, one.log)
    assert again.infrared[0][0] == one.infrared[0][0]
    assert np.array_equal(again.infrared[0][1], one.infrared[0][1])


@pytest.mark.parametrize("name", list(SPOILS))
def test_a_spoiled_recording_opens(case, name, tmp_path, capsys):
    after = spoiled(name, case)
    paths, sensor = put(after.case, tmp_path / "case")
    assert fusion_main(["info", str(paths[-1]), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)
    assert fusion_main(["sensor", "show", sensor]) == 0
    assert bool(after.text) == (name != CONTROL)


def test_a_rotation_and_its_quaternion_are_one():
    rng = np.random.default_rng(0)
    for q in rng.standard_normal((20, 4)):
        R = rotation_of(q)
        assert np.allclose(R @ R.T, np.eye(3))
        assert abs(quaternion_of(R) @ q) / np.linalg.norm(q) == pytest.approx(1.0)


def test_a_bow_lifts_the_wall_by_its_size_at_the_same_places():
    rng = np.random.default_rng(2)
    flat = Case(tuple(wall(k, rng, noise=0) for k in range(4)), {})
    after = walls_bowed(flat, np.random.default_rng(5))
    heights, places = [], []
    for taken, change in zip(flat.recordings, moved(flat, after.case), strict=True):
        view = seen(taken)
        facing = (view.rays @ view.T[:3, :3].T)[..., 1]
        heights.append((change[0] * facing).ravel())
        places.append(view.points[..., [0, 2]].reshape(-1, 2))
    # waves of 1.5 to 6 m over a wall of 1 to 2 m: what is seen of them is not the whole, but of its kind
    assert 0.2 * after.told.shape_rms_m < np.std(np.concatenate(heights)) < 2 * after.told.shape_rms_m
    for place, height in zip(places[0][::500], heights[0][::500], strict=True):
        nearest = np.argmin(np.linalg.norm(places[1] - place, axis=1))
        away = np.linalg.norm(places[1][nearest] - place)
        # a slope of 2 pi 2 mm 2 sqrt 2 / 1.5 m at most
        assert abs(heights[1][nearest] - height) < 1e-9 + 0.025 * away


def test_the_worse_poses_are_off_by_the_factor(case):
    off = []
    for seed in range(60):
        after = spoiled("poses", case, seed)
        k = float(after.text.split()[0])
        for a, b in zip(case.recordings, after.case.recordings, strict=True):
            off += list((b.poses[0, 1:4] - a.poses[0, 1:4]) / k / 0.0005)
            assert np.ptp(b.poses[:, 1:], axis=0).max() < 1e-9  # one error for all frames
    assert np.std(off) == pytest.approx(1.0, abs=4 / np.sqrt(2 * len(off)))


def test_a_camera_that_shakes_sees_the_plane_from_there():
    still = Case((wall(0, np.random.default_rng(0), noise=0),), {})
    after = spoiled("shake", still)
    change = moved(still, after.case)[0]
    assert 1e-4 < np.abs(change).max() < 0.02
    # from any place a plane is a plane: its inverse depth is linear in the pixel
    v, u = np.mgrid[: SIZE[0], : SIZE[1]]
    A = np.column_stack([u.ravel(), v.ravel(), np.ones(u.size)])
    for frame in after.case.recordings[0].depth:
        rest = np.linalg.lstsq(A, 1 / frame.ravel(), rcond=None)[1]
        assert rest < 1e-18
    assert len({round(float(frame[0, 0]), 7) for frame in after.case.recordings[0].depth}) == 7


def test_halves_share_no_frame_and_copies_share_all(case):
    first, second = spoiled("repeat", case).case.recordings[:2]
    assert (len(first.depth), len(second.depth)) == (4, 3)
    assert second.times[0] > first.times[-1]
    assert np.array_equal(first.depth[1], case.recordings[0].depth[2])
    assert np.array_equal(second.depth[1], case.recordings[0].depth[3])
    after = spoiled("copy", case)
    assert len(after.case.recordings) > len(case.recordings)
    (name, copy), *_ = after.told.repeats
    by_name = {taken.name: taken for taken in after.case.recordings}
    assert np.array_equal(by_name[copy].depth, by_name[name].depth)
    assert by_name[copy].times[0] >= by_name[name].times[0] + 100
    assert np.allclose(by_name[copy].poses[:, 0], by_name[copy].times)


@pytest.mark.parametrize("name", ["clutter", "person"])
def test_things_stand_before_the_wall_in_the_recordings_named(case, name):
    after = spoiled(name, case)
    for taken, change in zip(case.recordings, moved(case, after.case), strict=True):
        inside = np.abs(change) > 0.05
        assert inside.any() == (taken.name in after.told.outliers)
        assert (change[inside] < 0).all()
        assert not change[~inside].any() or np.abs(change[~inside]).max() < 0.05
        if name == "person":
            assert (~inside).all(axis=(1, 2)).any()


def test_the_mesh_is_scaled_and_nothing_else(case):
    after = spoiled("mesh", case)
    before, behind = (planes_of(c.recordings[0].mesh)[0] for c in (case, after.case))
    assert np.allclose(before[:3], behind[:3])
    assert 0.005 <= abs(before[3] - behind[3]) <= 0.02
    assert not np.any(moved(case, after.case)[0])
    vertices, faces = read_ply(WALL)
    table = np.zeros(4, [("x", "<f8"), ("y", "<f8"), ("z", "<f8"), ("red", "u1")])
    for k, axis in enumerate("xyz"):
        table[axis] = vertices[:, k]
    head = b"ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty double x\nproperty double y\n"
    head += (
        b"property double z\nproperty uchar red\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n"
    )
    binary = head + table.tobytes() + b"".join(b"\x03" + face.astype("<i4").tobytes() for face in faces)
    twice, same = read_ply(changed_ply(binary, lambda x: 2 * x))
    assert np.allclose(twice, 2 * vertices)
    assert np.array_equal(same, faces)


def test_rounding_leaves_whole_steps_and_the_file_says_them(case):
    after = spoiled("rounding", case)
    step = after.case.sensor["effects"][1]["parameters"]["step"]["value"]
    counts = after.case.recordings[0].depth / step
    assert np.allclose(counts, np.round(counts))
    assert after.case.sensor["effects"][0]["parameters"]["c0"]["value"] == pytest.approx(0.0004)


def claim(effect, variables=(), alike=(), **where):
    return {"effect": effect, "where": {"variables": list(variables), **where}, "indistinguishable_from": list(alike)}


def verdict(*claims, **more):
    return {"missing": list(claims), **more}


PLANTED = ({"effect": "cyclic_error", "accept": [], "region": []},)
QUIET = Ran(0, "", 1.0)


@pytest.mark.parametrize(
    ("missing", "names", "said", "outcome"),
    [
        ((), (), verdict(), "right"),
        ((), ("principal_point",), verdict(), "silent"),
        ((), ("principal_point",), verdict(claim("principal_point")), "right"),
        ((), ("principal_point",), verdict(claim("unknown", ["time"])), "WRONG"),
        ((), ("principal_point",), verdict(claim("focal_length", alike=["principal_point"])), "set"),
        (PLANTED, (), verdict(), "silent"),
        (PLANTED, (), verdict(claim("cyclic_error")), "right"),
        (PLANTED, (), verdict(claim("cyclic_error"), claim("multipath")), "WRONG"),
        (PLANTED, (), verdict(claim("cyclic_error", recordings=["rec_01"])), "WRONG"),
        (PLANTED, (), verdict(claim("cyclic_error", region=[{"variable": "depth", "low": 0, "high": 1}])), "WRONG"),
        (PLANTED, ("pose_jitter",), verdict(claim("pose_jitter")), "silent"),
    ],
)
def test_scores_are_strict(case, missing, names, said, outcome):
    base = Base("made", case, missing)
    assert score(said, QUIET, base, Spoiled(case, "spoil", Told("spoil"), names)).outcome == outcome


def test_what_is_only_indicated_is_silent_and_yet_told(case):
    one = Spoiled(case, "3 px", Told("camera file"), ("principal_point",))
    found = score(verdict(indicated=[claim("principal_point")]), QUIET, Base("made", case), one)
    assert (found.outcome, found.told, found.how) == ("silent", True, ("indicated",))


def test_a_region_that_is_true_is_no_fault(case):
    partial = ({"effect": "cyclic_error", "region": [{"variable": "time", "low": 1, "high": 2}]},)
    said = verdict(claim("cyclic_error", region=[{"variable": "temperature", "low": 30, "high": 40}]))
    assert score(said, QUIET, Base("made", case, partial), Spoiled(case, "", Told("^$"))).outcome == "right"


def test_what_tells_a_spoil(case):
    told = Told("pose", pose_factor=10.0, outliers=("rec_01",), repeats=(("rec_00", "rec_02"),), refused="twice")
    one, base = Spoiled(case, "spoil", told), Base("made", case)
    more = {"nuisances": {"pose_factor": 12.0}, "outliers": [{"recording": "rec_01"}], "headline": "poses are worse"}
    assert score(verdict(**more), QUIET, base, one).how == ("pose_factor", "outliers", "headline")
    assert score(verdict(repeats=[["rec_02", "rec_00"]]), QUIET, base, one).how == ("repeats",)
    assert score(verdict(nuisances={"pose_factor": 25.0}, outliers=None), QUIET, base, one).how == ()
    assert score(None, Ran(1, "rec_05 was given twice", 1.0), base, one).outcome == "refused"
    assert score(None, Ran(1, "no camera.json", 1.0), base, one).outcome == "failed"


def test_the_figure_counts_spoiled_runs_alone(case):
    one, base = Spoiled(case, "3 px", Told("camera file"), ("principal_point",)), Base("made", case)
    bad = score(verdict(claim("unknown", ["time"])), QUIET, base, one)
    runs = [Run(0, "made", True, "centre", "3 px", bad, 9.0, ""), Run(0, "made", True, CONTROL, "", bad, 9.0, "")]
    assert "wrong established claims: 1 of 1 (95 %: 2.5 to 100.0 %)" in summary(runs)
    assert "unspoiled: wrong established claims 1 of 1" in summary(runs)
    assert "!unknown(time)!" in line(runs[0])
