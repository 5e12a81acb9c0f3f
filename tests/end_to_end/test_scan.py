"""A small turntable recording becomes the object's mesh, whichever way it turns and whatever is broken in it."""

import json
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from fusion.commands.main import main
from fusion.errors import FusionError, TrackingError
from fusion.files.output.publish import output_folder
from fusion.geometry import pose
from fusion.geometry.camera import Camera
from fusion.mesh.comparison.distances import signed_distances
from fusion.mesh.files import read_mesh
from fusion.recording.native.trajectory_file import read_trajectory
from fusion.recording.open import open_recording
from fusion.recording.recording import Recording
from fusion.recording.writing.write import write_recording
from fusion.scan.finding.model_fit import ModelFit
from fusion.scan.finding.pair_fit import PairFit
from fusion.scan.pipeline import scan_turntable
from fusion.scan.settings import ScanSettings
from fusion.sensor.presets import preset
from fusion.sensor.sensor import Sensor
from fusion.simulation.demo.demo import demo_scene, demo_truth
from fusion.simulation.scene.course import turning
from fusion.simulation.scene.turntable import Turntable, TurntableErrors
from fusion.simulation.simulate import simulate

pytestmark = pytest.mark.slow  # whole scans; `make slow` runs them

SMALL = Camera(200, 150, 195.0, 196.0, 100.3, 74.1, depth_scale=5000.0, principle="itof")
FRAMES, STEP_DEG = 26, 15.0  # 375 degrees
SLIP_FRAME, SLIP_DEG = 18, 3.0
BROKEN = 7
VOXEL = 0.004
SENSOR = "kinect-v2-indoors"
CHEAP = ScanSettings(sensor=preset(SENSOR), voxel=VOXEL, truncation=0.015, color=False)
# .fusion.json: the mark by which a later run knows its own result
FILES = {
    "mesh.ply",
    "trajectory.txt",
    "trajectory_raw.txt",
    "turntable.json",
    "settings.json",
    "report.html",
    ".fusion.json",
}


def simulated(step_deg, seed=0):
    errors = TurntableErrors(uneven_sd_deg=0.1, slip_frame=SLIP_FRAME, slip_deg=SLIP_DEG)
    table = Turntable(degrees_per_frame=step_deg, frames=FRAMES, errors=errors)
    # no noise but that of lost edges and counts: with so few pixels a sensor's own would hide what is tested here
    scene = demo_scene(FRAMES)
    course = turning(table, scene.course.T_world_camera[0])
    return simulate(replace(scene, camera=SMALL, course=course), Sensor(), seed)


def recorded(simulation, folder) -> Recording:
    frames = (replace(frame, color=None, ir=None) for frame in simulation.frames())
    write_recording(folder, SMALL, frames, telemetry=simulation.telemetry)
    return open_recording(folder)


@pytest.fixture(scope="module")
def left(tmp_path_factory):
    """A table that turns left-handed against its log, with one file cut off in the middle: simulation, recording."""
    simulation, folder = simulated(-STEP_DEG), tmp_path_factory.mktemp("left") / "recording"
    recorded(simulation, folder)
    file = folder / f"depth/{BROKEN:06d}.png"
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])
    return simulation, open_recording(folder)


@pytest.fixture(scope="module")
def scan(left):
    """Without the table's log."""
    return scan_turntable(left[1], replace(CHEAP, use_log=False))


@pytest.fixture(scope="module")
def right(tmp_path_factory):
    """A table that turns right-handed, whole, scanned with its log: simulation, scan."""
    simulation = simulated(STEP_DEG, seed=1)
    return simulation, scan_turntable(recorded(simulation, tmp_path_factory.mktemp("right") / "recording"), CHEAP)


@pytest.fixture(scope="module")
def written(left, scan, tmp_path_factory):
    """The command's folder, with the circle as post-pass; the joint fit, the slow part, is that of the scan above."""
    out = tmp_path_factory.mktemp("command") / "out"
    given = f"--voxel {VOXEL} --truncation 0.015 --no-color --strength circle --sensor {SENSOR} --ignore-log".split()
    with pytest.MonkeyPatch.context() as patch:
        motion_known(patch, scan.motion)
        status = main(["turntable", str(left[1].path), "-o", str(out), *given])
    assert not status
    return out


def motion_known(patch, motion):
    """No motion is sought in what follows: it is this one."""
    patch.setattr("fusion.scan.finding.attempt.fit_pairs", lambda *_: PairFit(motion, None, None))
    patch.setattr("fusion.scan.finding.turn.find_motion", lambda *_: ModelFit(motion))


def angle_error_deg(angles, turned_deg):
    """Errors (n,) [deg] up to one constant."""
    error = np.rad2deg(angles) - turned_deg
    return error - np.nanmedian(error)


def distances(mesh, T_object_camera, simulation):
    """Signed distances [m] to the truth, brought there by the first camera alone: no alignment hides an error."""
    T_truth_mesh = simulation.truth.poses[0] @ pose.inverse(T_object_camera)
    return signed_distances(pose.transform(T_truth_mesh, mesh.vertices), demo_truth())


@pytest.fixture(params=["left", pytest.param("right", marks=pytest.mark.slow)])
def case(request):
    """Simulation and scan, of the left-handed table without log or the right-handed one with it."""
    if request.param == "right":
        return request.getfixturevalue("right")
    return request.getfixturevalue("left")[0], request.getfixturevalue("scan")


def test_the_mesh_is_the_object(case):
    simulation, found = case
    d = distances(found.mesh, found.trajectory.poses[0], simulation)
    # a pixel is 4 mm on the owl, as is the voxel; measured 0.83 mm
    assert np.sqrt(np.mean(d**2)) < 0.0015 and np.abs(np.median(d)) < 0.0005
    assert (np.abs(d) < 0.008).mean() > 0.995  # no second surface, no wall, no plate
    seen = np.ptp(found.mesh.vertices, axis=0)
    true = np.ptp(demo_truth().vertices, axis=0)
    assert seen[2] == pytest.approx(true[2], abs=0.015)  # thin ear tufts are below a pixel; 4 mm go with the plate
    assert seen[:2].max() < np.linalg.norm(true[:2]) + 0.02


def test_angles_direction_and_slip(case):
    simulation, found = case
    error = angle_error_deg(found.motion.angles, simulation.turned_deg)
    # the owl's radius is a dozen pixels: 1 deg is a fifth of a pixel at its rim; measured 0.3 to 0.65
    assert np.nanmax(np.abs(error)) < 1.0
    sign = np.sign(simulation.scene.course.turntable.degrees_per_frame)
    assert found.steps.direction == sign
    (slip,) = found.steps.slips  # uneven steps and angles that are off by a degree are none
    assert slip.frame == SLIP_FRAME
    assert np.rad2deg(slip.angle) == pytest.approx(sign * SLIP_DEG, abs=1.0)


def test_the_axis_and_the_poses_are_those_of_the_table(case):
    simulation, found = case
    up = pose.inverse(simulation.scene.course.T_world_camera[0])[:3, 2]
    assert np.rad2deg(np.arccos(min(1.0, up @ found.motion.axis.direction))) < 1.0
    centre = pose.transform(pose.inverse(simulation.scene.course.T_world_camera[0]), np.zeros((1, 3)))
    # along the axis the origin is the plate, which is seen at a grazing angle in pixels of 4 mm
    radius, height = found.motion.axis.distance(centre)
    assert radius[0] < 0.003 and abs(height[0]) < 0.005
    first = pose.inverse(found.trajectory.poses[0])
    for T, true in zip(found.trajectory.poses, simulation.truth.poses, strict=True):
        if np.isfinite(T).all():
            change = pose.inverse(first @ T) @ (pose.inverse(simulation.truth.poses[0]) @ true)
            assert np.rad2deg(pose.angle(change)) < 1.5


def test_the_loop_is_closed(case):
    _, found = case
    assert found.closure is not None
    # two views against each other: half a pixel, which is 4 mm; measured 1.0 to 1.2 mm
    assert found.closure.distance < 0.002


def test_a_broken_file_costs_one_frame(scan):
    assert set(scan.motion.rejected) == {BROKEN}
    assert np.flatnonzero(~scan.trajectory.valid).tolist() == [BROKEN]
    assert np.flatnonzero(np.isnan(scan.motion.angles)).tolist() == [BROKEN]
    assert any(str(BROKEN) in light.reason for light in scan.judgement.lights if light.subject == "Frames")


@pytest.mark.slow
def test_a_whole_recording_loses_no_frame(right):
    assert right[1].trajectory.valid.all() and not right[1].motion.rejected


def test_the_command_writes_the_contract(written, left):
    assert {p.name for p in written.iterdir()} == FILES
    assert not [p for p in written.parent.iterdir() if p != written]
    table = json.loads((written / "turntable.json").read_text())
    for name in ("axis_point", "axis_direction"):
        assert len(table[name]) == 3
    assert len(table["angles_rad"]) == FRAMES and table["angles_rad"][0] == 0
    assert table["angles_rad"][BROKEN] is None and table["rejected_frames"] == [BROKEN]
    assert table["direction"] == -1
    assert SLIP_FRAME in [s["frame"] for s in table["slips"]]
    assert table["closure"]["distance"] >= 0 and table["closure"]["angle_rad"] >= 0
    assert table["radius"] == pytest.approx(np.hypot(0.66, 0.06), abs=0.02)  # of the camera about the axis
    settings = json.loads((written / "settings.json").read_text())
    assert settings["strength"] == "circle" and settings["frames"] == FRAMES
    assert settings["judgement"][0].keys() == {"level", "subject", "reason", "do", "fails"}
    assert "<html" in (written / "report.html").read_text(encoding="utf-8")[:2000].lower()
    stamps = read_trajectory(written / "trajectory.txt").timestamps
    kept = np.delete(left[1].timestamps, BROKEN)
    assert stamps == pytest.approx(kept, abs=1e-6)


def test_the_circle_places_the_centres_and_the_mesh_is_close(written, left):
    from fusion.turntable.circle import fit_circle

    placed = read_trajectory(written / "trajectory.txt")
    circle = fit_circle(placed.centres)
    assert circle.radial_rms < 1e-5 and circle.axial_rms < 1e-5  # the file keeps some 6 digits
    d = distances(read_mesh(written / "mesh.ply"), placed.poses[0], left[0])
    # the weaker post-pass keeps each frame's own rotation, that of the first too, by which the truth is placed
    assert np.sqrt(np.mean(d**2)) < 0.003


def test_masks_keep_the_plate_out(left, scan, tmp_path, monkeypatch):
    """What the masks leave out is not in the mesh, even where the plate was asked for."""
    depths = {i: left[1][i].depth for i in range(FRAMES) if i != BROKEN}
    background = np.nanmax(np.stack(list(depths.values())), axis=0)
    for name in left[1].files.depth:
        index = int(Path(name).stem)
        moving = depths.get(index, background) < background - 0.015
        cv2.imwrite(str(tmp_path / Path(name).name), moving.astype(np.uint8))
    motion_known(monkeypatch, scan.motion)
    found = scan_turntable(left[1], replace(CHEAP, use_log=False, keep_plate=True, mask=tmp_path))
    d = distances(found.mesh, found.trajectory.poses[0], left[0])
    # the plate of 30 cm would be some 9 cm off the owl; a pixel of 4 mm in the mask's border may see it
    assert (np.abs(d) < 0.012).mean() > 0.995
    assert found.settings.mask == tmp_path


def test_an_interruption_leaves_nothing(left, tmp_path, monkeypatch):
    def interrupted(*_):
        raise KeyboardInterrupt

    out = tmp_path / "out"
    monkeypatch.setattr("fusion.scan.finding.turn.find_motion", interrupted)
    with pytest.raises((KeyboardInterrupt, SystemExit)):
        raise SystemExit(main(["turntable", str(left[1].path), "-o", str(out), "--sensor", SENSOR]))
    assert not list(tmp_path.iterdir())


def test_an_interruption_while_writing_leaves_nothing(scan, left, tmp_path, monkeypatch):
    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("fusion.report.scans.scan.scan_report", interrupted)
    from fusion.commands.scan.turntable import fill

    with pytest.raises(KeyboardInterrupt), output_folder(tmp_path / "out") as partial:
        fill(partial, left[1], scan)
    assert not list(tmp_path.iterdir())


def test_an_unknown_strength_and_a_still_scene_are_told(left, tmp_path):
    with pytest.raises(FusionError, match="strength"):
        scan_turntable(left[1], replace(CHEAP, strength="spiral"))
    still = replace(left[1], load=lambda i: replace(left[1].load(0), index=i))
    with pytest.raises(TrackingError, match="nothing turns"):
        scan_turntable(still, CHEAP)
