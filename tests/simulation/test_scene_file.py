"""Scene files: what docs/scenes.md says they hold, forms that are easy to write, one clear line for anything broken."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fusion.errors import SceneError
from fusion.geometry.camera import Camera
from fusion.geometry.pose import about_axis, inverse, pose
from fusion.geometry.trajectory import Trajectory
from fusion.mesh.files import write_mesh
from fusion.recording.native.camera_file import camera_to_dict, write_camera
from fusion.recording.native.trajectory_file import write_trajectory
from fusion.recording.open import open_recording
from fusion.sensor.presets import preset
from fusion.sensor.sensor import Sensor
from fusion.simulation.scene.course import looking_at
from fusion.simulation.scene.scene_file import read_scene
from fusion.simulation.scene.shapes import box
from fusion.simulation.scenes import built_in
from fusion.simulation.simulate import simulate
from fusion.simulation.write import write_simulation

CAMERA = Camera(80, 60, 70.0, 70.0, 39.5, 29.5, depth_scale=5000.0)
TABLE = {"axis_point": [0.0, 0.0, 1.0], "axis_direction": [0, -1, 0], "degrees_per_frame": 12, "frames": 5}


@pytest.fixture
def folder(tmp_path):
    """A cube a metre before the origin, a camera and two trajectories, as a person would lay them out."""
    write_mesh(tmp_path / "cube.ply", box((-0.1, -0.1, 0.9), (0.1, 0.1, 1.1), (204, 204, 204)))
    write_camera(tmp_path / "camera.json", CAMERA)
    poses = np.array([pose(np.eye(3), [0.002 * k, 0, 0]) for k in range(4)])
    write_trajectory(tmp_path / "path.txt", Trajectory(10 + np.arange(4) / 30, poses))
    return tmp_path


def scene(folder, **changes):
    content = {"mesh": "cube.ply", "camera": "camera.json", "trajectory": "path.txt"} | changes
    content = {key: value for key, value in content.items() if value is not ...}
    (folder / "my.json").write_text(json.dumps(content))
    return folder / "my.json"


@pytest.mark.slow
def test_a_trajectory_file_gives_frames_stamps_and_poses(folder):
    simulation = simulate(read_scene(scene(folder)), Sensor())
    assert np.allclose(simulation.timestamps, 10 + np.arange(4) / 30, atol=1e-6)  # six decimals
    assert np.allclose(simulation.truth.poses[:, 0, 3], 0.002 * np.arange(4))
    assert simulation.scene.course.continuous and simulation.camera.fx == CAMERA.fx
    depth = next(simulation.frames()).depth
    assert depth[30, 40] == pytest.approx(0.9, abs=1e-6)


def test_a_turntable_turns_the_mesh_about_the_axis_before_one_camera_pose(folder):
    T = looking_at(np.array([0.3, -0.2, 0.1]), np.array([0.0, 0.0, 1.0]))
    forms = [
        {"turntable": TABLE, "T_world_camera": T.tolist()},
        {"turntable": TABLE | {"camera_pose": T.tolist()}},
        {"turntable": TABLE, "camera_pose": {"eye": [0.3, -0.2, 0.1], "target": [0, 0, 1]}},
    ]
    for form in forms:
        simulation = simulate(read_scene(scene(folder, trajectory=form)), Sensor())
        turn = about_axis([0, 0, 1], [0, -1, 0], np.deg2rad(24))
        assert np.allclose(simulation.truth.poses[2], inverse(turn) @ T)
        assert np.allclose(simulation.telemetry["turntable_deg"], 12 * np.arange(5))
    # without a pose the camera's frame is the world's
    still = simulate(read_scene(scene(folder, trajectory={"turntable": TABLE})), Sensor())
    assert np.allclose(still.truth.poses[0], np.eye(4))


def test_errors_of_the_table_are_in_the_truth_and_not_in_the_log(folder):
    errors = {"slip_frame": 2, "slip_deg": 5, "wobble_deg": 0.0}
    form = {"turntable": TABLE | {"errors": errors}}
    simulation = simulate(read_scene(scene(folder, trajectory=form)), Sensor())
    assert np.allclose(simulation.turned_deg - simulation.telemetry["turntable_deg"], [0, 0, 5, 5, 5])


def test_parts_boxes_boards_and_what_stands_still(folder):
    parts = [
        {"box": [[-1, -1, 1.5], [1, 1, 1.6]], "turns": False, "reflectance": 0.3},
        {"board": {"columns": 5, "rows": 4, "square_m": 0.02}, "pose": {"eye": [0, -0.3, 1.4], "target": [0, -0.3, 2]}},
        {"mesh": "cube.ply", "pose": [0.3, 0, 0, 0, 0, 0, 1], "color": [10, 200, 30], "scanned": False},
    ]
    notes = []
    found = read_scene(scene(folder, parts=parts, reflectance=0.8, trajectory={"turntable": TABLE}), notes)
    assert [part.turns for part in found.parts] == [True, False, True, True]
    assert found.parts[0].reflectance == 0.8 and found.board.columns == 5 and len(found.paints) == 1
    assert np.allclose(found.parts[3].mesh.vertices[:, 0].mean(), 0.3, atol=1e-6)
    assert not notes and found.color and found.infrared


def test_a_fixed_camera_inline_and_keys_that_nobody_knows(folder):
    notes = []
    trajectory = {"T_world_camera": [0, 0, 0.1, 0, 0, 0, 1], "frames": 3, "frame_s": 150.0, "start_s": 60.0}
    content = read_scene(scene(folder, camera=camera_to_dict(CAMERA), trajectory=trajectory, colour=True), notes)
    assert np.allclose(content.course.timestamps, [60, 210, 360]) and not content.course.continuous
    assert len(notes) == 1 and '"colour"' in notes[0]


def test_a_recording_can_be_simulated_again(tmp_path):
    first = replace(built_in("wall", {"frames": "2", "distance_m": "1,1.5"}), camera=CAMERA)
    write_simulation(tmp_path / "a", simulate(first, preset("kinect-v2-indoors"), 1))
    again = read_scene(tmp_path / "a")
    assert again.poses.source == "surveyed" and again.ambient_lux == 300 and not again.course.continuous
    write_simulation(tmp_path / "b", simulate(again, Sensor(), 1))
    a, b = open_recording(tmp_path / "a"), open_recording(tmp_path / "b")
    assert np.allclose(a.timestamps, b.timestamps) and np.allclose(b.telemetry["distance_m"], [1, 1, 1.5, 1.5])
    # noise, and a wall tilted by half a milliradian and moved by half a millimetre
    assert np.nanmax(np.abs(a[3].depth - b[3].depth)) < 0.03


def test_the_example_of_the_documentation(folder):
    text = (Path(__file__).parents[2] / "docs" / "scenes.md").read_text(encoding="utf-8")
    (folder / "my.json").write_text(text.split("```json")[1].split("```")[0])
    (folder / "cube.ply").rename(folder / "part.ply")
    (folder / "board.json").write_text('{"columns": 5, "rows": 4, "square_m": 0.02}')
    notes = []
    scene = read_scene(folder / "my.json", notes)
    assert len(scene.course) == 72 and len(scene.parts) == 3 and not notes
    assert scene.course.turntable.errors.slip_frame == 40


def test_what_is_left_out_of_telemetry_is_named(folder):
    (folder / "log.csv").write_text("timestamp,temperature_c,distance_m,who\n9,20,1.0 m,me\n11,1e9,1.1,you\n")
    notes = []
    read_scene(scene(folder, telemetry="log.csv"), notes)
    assert notes[0] == "distance_m in log.csv is left out: '1.0 m' in line 2 is no number"
    assert "1 of 2 values of temperature_c in log.csv are left out" in notes[1] and len(notes) == 2


def test_telemetry_reaches_the_frames(folder):
    (folder / "log.csv").write_text("timestamp,temperature_c\n9,20\n11,30\n")
    simulation = simulate(read_scene(scene(folder, telemetry="log.csv")), Sensor())
    assert np.allclose(simulation.telemetry["temperature_c"], 25 + 5 * np.arange(4) / 30, atol=1e-4)
    assert simulation.moment(1).temperature == pytest.approx(25.17, abs=0.01)


BROKEN = [
    {"mesh": "nothing.ply"},
    {"mesh": ...},
    {"mesh": 7},
    {"mesh": "camera.json"},
    {"reflectance": 1.5},
    {"reflectance": "white"},
    {"camera": "nothing.json"},
    {"camera": 5},
    {"camera": {"width": 10}},
    {"camera": camera_to_dict(CAMERA) | {"fx": float("nan")}},
    {"camera": camera_to_dict(CAMERA) | {"width": 60000, "height": 60000}},
    {"trajectory": ...},
    {"trajectory": "nothing.txt"},
    {"trajectory": "camera.json"},
    {"trajectory": []},
    {"trajectory": {}},
    {"trajectory": {"frames": 0}},
    {"trajectory": {"frames": 10**8}},
    {"trajectory": {"frames": 2.5}},
    {"trajectory": {"frames": 3, "frame_s": 0}},
    {"trajectory": {"frames": 3, "frame_s": float("nan")}},
    {"trajectory": {"frames": 3, "T_world_camera": [[1, 0], [0, 1]]}},
    {"trajectory": {"frames": 3, "T_world_camera": {"eye": [0, 0, 0]}}},
    {"trajectory": {"frames": 3, "T_world_camera": {"eye": [0, 0, 0], "target": [0, 0, 0]}}},
    {"trajectory": {"turntable": {}}},
    {"trajectory": {"turntable": TABLE | {"frames": 0}}},
    {"trajectory": {"turntable": TABLE | {"frames": -3}}},
    {"trajectory": {"turntable": TABLE | {"frames": 10**9}}},
    {"trajectory": {"turntable": TABLE | {"axis_direction": [0, 0, 0]}}},
    {"trajectory": {"turntable": TABLE | {"axis_point": [0, 0]}}},
    {"trajectory": {"turntable": TABLE | {"degrees_per_frame": "six"}}},
    {"trajectory": {"turntable": TABLE | {"errors": {"slip_deg": "much"}}}},
    {"trajectory": {"turntable": TABLE | {"errors": 5}}},
    {"trajectory": {"turntable": 5}},
    {"poses": {"source": "guessed"}},
    {"poses": {"sigma_m": -1}},
    {"poses": []},
    {"ambient_lux": -1},
    {"ambient_lux": float("inf")},
    {"telemetry": "nothing.csv"},
    {"parts": {}},
    {"parts": [7]},
    {"parts": [{}]},
    {"parts": [{"box": [[0, 0, 0], [0, 0, 0]]}]},
    {"parts": [{"box": [[0, 0], [1, 1]]}]},
    {"parts": [{"board": "nothing.json"}]},
    {"parts": [{"board": {"columns": 5}}]},
    {"parts": [{"board": {"columns": 5, "rows": 4, "square_m": 0.02, "marker_m": 0.01, "dictionary": "Dictionary"}}]},
    {"trajectory": "path\0.txt"},
    {"parts": ["cube.ply", 7]},
    {"parts": [{"mesh": "cube.ply", "pose": "there"}]},
    {"parts": [{"mesh": "cube.ply", "scale": 0}]},
    {"parts": [{"mesh": "cube.ply", "color": [0, 0, 300]}]},
    {"color": "yes"},
]


@pytest.mark.parametrize("wrong", BROKEN, ids=lambda wrong: json.dumps(wrong, default=str)[:60])
def test_anything_broken_is_one_clear_line(folder, wrong):
    path = scene(folder, **wrong)
    with pytest.raises(SceneError) as error:
        read_scene(path)
    text = str(error.value)
    assert "\n" not in text and len(text) < 400


@pytest.mark.parametrize("text", ["", "[]", "{", "null", '{"mesh": ' + "[" * 5000, "\x00"])
def test_a_file_that_is_no_scene_is_told(tmp_path, text):
    (tmp_path / "scene.json").write_text(text)
    for path in (tmp_path / "scene.json", tmp_path, tmp_path / "nothing.json"):
        with pytest.raises(SceneError):
            read_scene(path)


def test_a_camera_that_sees_nothing_and_a_mesh_in_millimetres_are_told_before_the_run(folder, tmp_path):
    away = {"T_world_camera": {"eye": [0, 0, 0], "target": [0, 0, -1]}, "frames": 3}
    far = {"T_world_camera": {"eye": [0, 0, -50], "target": [0, 0, 1]}, "frames": 3}
    for form, more in ((away, {}), (far, {"mesh": ..., "parts": [{"mesh": "cube.ply", "scale": 1000}]})):
        simulation = simulate(read_scene(scene(folder, trajectory=form, **more)), Sensor())
        with pytest.raises(SceneError):
            write_simulation(tmp_path / "rec", simulation)
    assert not (tmp_path / "rec").exists()


@pytest.mark.parametrize(
    "names", [{"mesh": "../cube.ply"}, {"trajectory": "/etc/passwd"}, {"camera": "../camera.json"}]
)
def test_what_a_scene_names_stays_in_its_folder(folder, names):
    with pytest.raises(SceneError, match=r"outside its folder.*--follow-links"):
        read_scene(scene(folder, **names))


@pytest.mark.parametrize("wrong", BROKEN, ids=lambda wrong: json.dumps(wrong, default=str)[:60])
def test_every_message_names_the_scene_file_or_a_file_that_it_names(folder, wrong):
    with pytest.raises(SceneError) as error:
        read_scene(scene(folder, **wrong))
    assert str(folder) in str(error.value)
