"""A recording becomes a mesh: tracked or with given poses, and what happens when the input is bad."""

import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "reference"))
from small_room import CAMERA, Room, room_mesh, sway

from fusion.commands.main import main
from fusion.errors import RecordingError, TrackingError, VolumeError
from fusion.files.output.claim import MARK
from fusion.geometry.pose import angle, exp, inverse
from fusion.geometry.trajectory import Trajectory
from fusion.mesh.comparison.distances import signed_distances
from fusion.mesh.files import read_mesh
from fusion.reconstruction.pipeline import reconstruct
from fusion.reconstruction.planning import plan
from fusion.reconstruction.settings import ReconstructSettings
from fusion.recording.native.trajectory_file import read_trajectory
from fusion.recording.recording import Frame, Recording
from fusion.recording.writing.write import write_recording
from fusion.results.course import off_course
from fusion.sensor.presets import default_sensor
from fusion.simulation.rendering.render import RayCaster

FRAMES = 10
CHEAP = ReconstructSettings(voxel=0.01, truncation=0.04, color=False)


@pytest.fixture(scope="module")
def room():
    return Room(RayCaster(room_mesh()))


@pytest.fixture(scope="module")
def truth():
    return np.stack([sway(0.12 * i) for i in range(FRAMES)])


@pytest.fixture(scope="module")
def depths(room, truth):
    return [room.depth(T, seed) for seed, T in enumerate(truth)]


def recording_of(depths, truth=None) -> Recording:
    stamps = 10.0 + np.arange(len(depths)) / 30

    def load(i):
        if isinstance(depths[i], Exception):
            raise depths[i]
        return Frame(i, float(stamps[i]), depths[i].copy())

    poses = None if truth is None else Trajectory(stamps, truth)
    return Recording(Path("made"), "made", CAMERA, stamps, load, poses)


def pose_errors(result, truth):
    found = [inverse(T) @ F for T, F in zip(truth, result.trajectory.poses, strict=True)]
    return np.array([(angle(d), np.linalg.norm(d[:3, 3])) for d in found if np.isfinite(d).all()])


def test_a_moving_camera_is_tracked_and_the_room_is_right(depths, truth):
    result = reconstruct(recording_of(depths), CHEAP)
    assert not result.rejected
    # 2 mm noise and 1 cm voxels: a third of a voxel over ten frames of motion
    assert pose_errors(result, truth).max() < 0.0035
    distance = np.abs(signed_distances(result.mesh.vertices, room_mesh()))
    # flat parts come out at a fraction of the noise; edges of the boxes are rounded by a voxel
    assert np.median(distance) < 0.002
    assert np.quantile(distance, 0.95) < 0.01
    assert result.information.shape == (FRAMES, 6, 6)
    assert np.isfinite(result.residual[1:]).all()


def test_the_mesh_has_the_colours_of_the_room(room, depths, truth):
    recording = recording_of(depths)
    pictures = [room.caster.view(CAMERA, T).color for T in truth]
    colored = replace(recording, load=lambda i: replace(recording.load(i), color=pictures[i]))
    result = reconstruct(colored, replace(CHEAP, color=True, poses=Trajectory(recording.timestamps, truth)))
    seen = result.mesh.scalars["color_views"] > 0
    assert result.settings.color and result.settings.uncolored_share == pytest.approx(1 - seen.mean())
    # things of one colour each: pixels of 13 mm at the far wall mix none but at their rims, which are kept away from
    known = np.array([(90, 90, 90), (150, 150, 150), (200, 200, 200), (200, 80, 80)])
    apart = np.abs(result.mesh.colors[seen].astype(int)[:, None] - known).max(axis=2).min(axis=1)
    assert seen.mean() > 0.8 and (apart < 5).mean() > 0.98
    assert not (result.mesh.colors == 0).all(axis=1).any()
    without = reconstruct(colored, replace(CHEAP, poses=Trajectory(recording.timestamps, truth)))
    assert without.mesh.colors is None and not without.settings.color


def test_given_poses_are_kept_as_they_are(depths, truth):
    poses = Trajectory(10.0 + np.arange(FRAMES) / 30, truth)
    result = reconstruct(recording_of(depths), replace(CHEAP, poses=poses))
    assert np.array_equal(result.trajectory.poses, truth)
    assert result.settings.poses == "given"
    assert np.isnan(result.residual).all()
    assert np.median(np.abs(signed_distances(result.mesh.vertices, room_mesh()))) < 0.002


def test_a_frame_without_a_given_pose_is_rejected(depths, truth):
    poses = Trajectory(10.0 + np.arange(FRAMES - 1) / 30, truth[:-1])
    result = reconstruct(recording_of(depths), replace(CHEAP, poses=poses))
    assert result.rejected == {FRAMES - 1: "no pose is given for its time stamp"}


def test_blank_and_broken_frames_are_told_and_passed_over(depths, truth):
    bad = list(depths)
    bad[4] = np.full(CAMERA.shape, np.nan, np.float32)
    bad[6] = RecordingError("the image is cut off", "depth/6.png")
    result = reconstruct(recording_of(bad), CHEAP)
    assert set(result.rejected) == {4, 6}
    assert "cut off" in result.rejected[6]
    assert np.isnan(result.trajectory.poses[[4, 6]]).all()
    assert pose_errors(result, truth).max() < 0.0035


def test_the_box_and_the_largest_depth_are_kept(depths):
    box = ((-0.6, -0.2, 1.0), (0.8, 0.45, 1.7))
    inside = reconstruct(recording_of(depths[:3]), replace(CHEAP, box=box)).mesh.vertices
    # whole blocks of 8 voxels are allocated around what is inside
    assert (inside >= np.array(box[0]) - 0.12).all()
    assert (inside <= np.array(box[1]) + 0.12).all()
    near = reconstruct(recording_of(depths[:3]), replace(CHEAP, max_depth=1.6)).mesh.vertices
    assert near[:, 2].max() < 1.7


def test_the_trajectory_is_judged_by_the_recordings_own_poses(depths, truth):
    made = replace(recording_of(depths, truth), scene={"poses": {"source": "surveyed", "sigma_m": 0.003}})
    tracked = reconstruct(made, CHEAP)
    values = tracked.facts.values()["trajectory_error"]
    assert values["rmse_m"] < 0.005 and values["frames"] == FRAMES  # the bar of the poses above
    assert values["against"] == "the recording's surveyed poses, +- 3 mm"
    nominal = replace(made, scene={"poses": {"source": "nominal"}})
    assert "as planned and not measured" in off_course(tracked.trajectory, nominal).words()
    assert "trajectory_error" not in reconstruct(recording_of(depths[:3]), CHEAP).facts.values()
    # with these poses given there is no error to tell
    assert reconstruct(made, replace(CHEAP, poses=made.poses)).off_course is None


@pytest.mark.parametrize(("told", "kind", "why"), [(None, "room", "1.53 m large"), (False, "object", "as told")])
def test_object_or_room_is_decided_and_said(depths, told, kind, why):
    chosen = plan(recording_of(depths), ReconstructSettings(room=told, color=False), default_sensor(CAMERA))
    assert chosen.kind == kind and why in chosen.reason
    assert (chosen.volume.voxel <= 0.002) == (kind == "object")


def test_object_voxels_that_do_not_fit_make_it_a_room(depths):
    low = ReconstructSettings(max_bytes=2 << 30, max_depth=1.4)
    probes = recording_of(depths)
    assert plan(probes, low, default_sensor(CAMERA)).kind == "object"
    chosen = plan(probes, replace(low, max_bytes=16 << 20), default_sensor(CAMERA))
    assert chosen.kind == "room" and "would take" in chosen.reason


def test_an_object_that_turns_is_refused(room, truth):
    still = room.depth(truth[0], 0)
    turning = [still.copy() for _ in range(FRAMES)]
    for i, depth in enumerate(turning):
        half = 6 + int(5 * np.cos(i))
        depth[50:80, 80 - half : 80 + half] = 0.6
    with pytest.raises(RecordingError, match="fusion turntable"):
        reconstruct(recording_of(turning), CHEAP)
    assert reconstruct(recording_of(turning), replace(CHEAP, force=True)).judgement.level == "bad"


def test_the_voxel_is_chosen_for_an_object_or_a_room(depths):
    chosen = reconstruct(recording_of(depths[:1]), ReconstructSettings(room=True)).settings
    assert 0.005 <= chosen.voxel_m <= 0.02
    assert chosen.truncation_m >= 4 * chosen.voxel_m


def test_what_does_not_fit_is_told_before_the_start(depths):
    with pytest.raises(VolumeError, match="--voxel"):
        reconstruct(recording_of(depths), ReconstructSettings(voxel=0.001, max_bytes=10 << 20))


def test_no_frames_and_no_depth():
    with pytest.raises(RecordingError, match="no frames"):
        reconstruct(recording_of([]), CHEAP)
    with pytest.raises(RecordingError, match="no depth"):
        reconstruct(recording_of([np.full(CAMERA.shape, np.nan, np.float32)] * 3), CHEAP)
    with pytest.raises(RecordingError, match="cut off"):
        reconstruct(recording_of([RecordingError("the image is cut off", "0.png")]), CHEAP)


def test_frames_that_have_nothing_in_common_end_in_one_line(room):
    """Every frame looks elsewhere."""
    views = [
        room.depth(exp([0, 0, 0, 0.0, 0.0, 0.25 * (i % 4)]) @ exp([0.2 * i, 0.5 * i, 0, 0, 0, 0]), i) for i in range(8)
    ]
    with pytest.raises(TrackingError, match="of 8; most often") as error:
        reconstruct(recording_of(views), CHEAP)
    assert "\n" not in str(error.value)


@pytest.fixture(scope="module")
def folder(tmp_path_factory, depths, truth):
    path = tmp_path_factory.mktemp("made") / "scan"
    made = recording_of(depths, truth)
    write_recording(path, made.camera, iter(made), poses=made.poses)
    return path


OPTIONS = ["--voxel", "0.02", "--truncation", "0.08"]


@pytest.mark.slow
def test_the_command_writes_all_that_the_contract_names(folder, tmp_path, capsys, truth):
    assert main(["reconstruct", str(folder), "-o", str(tmp_path / "out"), *OPTIONS, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["placed"] == FRAMES
    assert {p.name for p in (tmp_path / "out").iterdir()} == {
        "mesh.ply", "trajectory.txt", "settings.json", "report.html", MARK
    }  # fmt: skip
    assert len(read_mesh(tmp_path / "out/mesh.ply").faces) == told["triangles"]
    written = read_trajectory(tmp_path / "out/trajectory.txt")
    assert len(written) == FRAMES
    assert np.abs(written.poses[-1] - truth[-1]).max() < 0.005
    assert json.loads((tmp_path / "out/settings.json").read_text())["voxel_m"] == 0.02
    # no partial folder is left beside the result
    assert {p.name for p in tmp_path.iterdir()} == {"out"}


def test_the_summary_is_short_and_poses_can_be_a_file(folder, tmp_path, capsys, monkeypatch):
    # drawing takes seconds, and the test above has done it
    monkeypatch.setattr("fusion.report.scans.scan.scan_report", lambda path, report: path.write_text("drawn"))
    poses = folder / "groundtruth.txt"
    assert main(["reconstruct", str(folder), "-o", str(tmp_path / "o"), *OPTIONS, "--poses", str(poses)]) == 0
    text = capsys.readouterr().out
    assert len(text.splitlines()) == 8 and "corrected nothing to correct" in text
    assert text.splitlines()[-1].startswith("took      ")
    assert "poses as given" in text


@pytest.mark.parametrize(
    ("extra", "complaint"),
    [
        (["--poses", "none.txt"], "none.txt"),
        (["--voxel", "-1"], "voxel"),
        (["--voxel", "nan"], "voxel"),
        (["--truncation", "0.001"], "truncation"),
        (["--max-depth", "0.2"], "depth"),
        (["--max-depth", "nan"], "--max-depth"),
        (["--box", "0", "0", "0", "-1", "1", "1"], "box"),
        (["--box", "5", "5", "5", "6", "6", "6"], "--box"),
        (["--sensor", "no-such"], "--sensor"),
        (["--camera", "no-such"], "--camera"),
    ],
)
def test_bad_options_are_one_line_and_leave_nothing(folder, tmp_path, capsys, extra, complaint):
    options = (
        OPTIONS
        if not {"--voxel", "--truncation"} & set(extra)
        else ["--voxel", "0.01"][: 2 * ("--truncation" in extra)]
    )
    assert main(["reconstruct", str(folder), "-o", str(tmp_path / "out"), *options, *extra]) == 1
    line = capsys.readouterr().err.strip()
    assert complaint in line
    assert "\n" not in line
    assert list(tmp_path.iterdir()) == []


def test_no_recording_is_one_line(tmp_path, capsys):
    (tmp_path / "empty").mkdir()
    assert main(["reconstruct", str(tmp_path / "empty"), "-o", str(tmp_path / "out")]) == 1
    assert len(capsys.readouterr().err.strip().splitlines()) == 1
    assert not (tmp_path / "out").exists()
