"""Scenes by name: each becomes a recording that every reader takes, the same bytes for the same seed."""

import hashlib
import json
from dataclasses import replace

import numpy as np
import pytest

from fusion.errors import FusionError, SceneError
from fusion.geometry.camera import Camera
from fusion.geometry.pose import inverse
from fusion.progress import following
from fusion.recording.looking.inspect import inspect
from fusion.recording.native.trajectory_file import read_trajectory
from fusion.recording.open import open_recording
from fusion.sensor.effects.light.subsurface_scattering import SubsurfaceScattering
from fusion.sensor.effects.phase.motion_artifact import MotionArtifact
from fusion.sensor.presets import preset
from fusion.sensor.sensor import Sensor
from fusion.simulation.scenes import SCENES, about, built_in, settings_of
from fusion.simulation.simulate import simulate
from fusion.simulation.write import write_simulation

CAMERA = Camera(96, 72, 86.0, 86.0, 47.2, 35.9, depth_scale=5000.0)


def scene(name, **settings):
    return replace(built_in(name, {key: str(value) for key, value in settings.items()}), camera=CAMERA)


def written(folder, name, sensor="kinect-v2-indoors", seed=1, **settings):
    write_simulation(folder, simulate(scene(name, **settings), preset(sensor), seed))
    return open_recording(folder)


def digest(folder):
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    return {str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


@pytest.mark.slow
@pytest.mark.parametrize("name", SCENES)
def test_every_scene_is_a_recording_without_complaint(tmp_path, name):
    recording = written(tmp_path / "rec", name, frames=3)
    findings = inspect(recording)
    assert findings.severity == "ok", [f.seen for f in findings.findings]
    assert recording.format == "native" and len(recording) == 3
    assert recording.scene["mesh"] == "scene.ply" and (tmp_path / "rec" / "scene.ply").is_file()
    frame = recording[0]
    # a bright board within 0.7 m saturates this sensor
    assert np.isfinite(frame.depth).mean() > 0.5 and frame.ir is not None
    assert len(about(name)) < 100 and "\n" not in about(name)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["turntable", "checkerboard"])
def test_the_same_seed_gives_the_same_bytes_and_another_does_not(tmp_path, name):
    for folder, seed in (("a", 4), ("b", 4), ("c", 5)):
        written(tmp_path / folder, name, seed=seed, frames=2)
    first = digest(tmp_path / "a")
    assert first == digest(tmp_path / "b")
    other = digest(tmp_path / "c")
    assert first.keys() == other.keys()
    assert all(first[file] != other[file] for file in first if file.startswith(("depth/", "ir/")))


def test_a_wall_has_the_depth_that_it_should(tmp_path):
    simulation = simulate(scene("wall", distance_m="0.8,2.5", tilt_deg="0,40", frames=1), Sensor())
    for index, frame in enumerate(simulation.frames()):
        distance, tilt = (0.8, 2.5)[index % 2], np.deg2rad((0, 40)[index // 2])
        # the plane x = 0 in the camera frame: a turn about the vertical axis
        x = CAMERA.rays()[..., 0]
        expected = distance * np.cos(tilt) / (np.cos(tilt) + np.sin(tilt) * x)
        other = distance * np.cos(tilt) / (np.cos(tilt) - np.sin(tilt) * x)
        error = min(np.abs(frame.depth - expected).max(), np.abs(frame.depth - other).max())
        assert error < 1e-5 * distance  # single precision of the ray caster
    assert np.allclose(simulation.telemetry["distance_m"], [0.8, 2.5, 0.8, 2.5])


def test_stated_poses_share_one_error_of_the_stated_size():
    errors = []
    for seed in range(60):
        simulation = simulate(scene("wall", frames=2, sigma_m=0.004, sigma_rad=0.01), Sensor(), seed)
        T = inverse(simulation.truth.poses) @ simulation.stated.poses
        assert np.allclose(T[0], T[1])
        errors.append([*T[0, :3, 3], T[0, 2, 1], T[0, 0, 2], T[0, 1, 0]])
    sigma = np.sqrt((np.array(errors) ** 2).mean(axis=0))
    # five standard deviations of a standard deviation from 60 draws
    assert np.abs(sigma / np.repeat([0.004, 0.01], 3) - 1).max() < 5 / np.sqrt(2 * 60)


def test_a_turntable_states_what_it_was_told_and_the_truth_stands_apart(tmp_path):
    folder = tmp_path / "rec"
    recording = written(folder, "turntable", sensor="kinect-v1", frames=6, turns=0.5, slip_frame=3, slip_deg=4)
    truth = json.loads((folder / "truth" / "truth.json").read_text())
    turned = np.array(truth["turned_deg"])
    assert np.allclose(turned - recording.telemetry["turntable_deg"], [0, 0, 0, 4, 4, 4])
    true = read_trajectory(folder / "truth" / "trajectory.txt").poses
    step = inverse(recording.poses.poses) @ true
    degrees = np.rad2deg(np.arccos(np.clip((np.trace(step[:, :3, :3], axis1=1, axis2=2) - 1) / 2, -1, 1)))
    assert np.allclose(degrees, [0, 0, 0, 4, 4, 4], atol=1e-3)  # nine decimals of a quaternion
    assert recording.scene["poses"]["source"] == "nominal"
    assert {p.name for p in (folder / "truth").iterdir()} == {
        "trajectory.txt", "mesh.ply", "camera.json", "sensor.json", "truth.json",
    }  # fmt: skip


def test_a_new_simulation_leaves_nothing_of_an_older_recording(tmp_path):
    written(tmp_path / "rec", "checkerboard", frames=3)
    (tmp_path / "rec" / "notes.txt").write_text("mine")
    written(tmp_path / "rec", "wall", frames=2)
    names = {path.name for path in (tmp_path / "rec").iterdir()}
    assert "board.json" not in names and "rgb.txt" not in names and "notes.txt" in names
    assert len(list((tmp_path / "rec" / "depth").iterdir())) == 2


def test_a_stopped_simulation_leaves_nothing(tmp_path):
    class Impatient:
        """Presses Ctrl-C when the second frame is made."""

        def at(self, stages, done, total) -> None:
            if done == 1:
                raise KeyboardInterrupt

        def note(self, text) -> None:
            """Nothing."""

    with pytest.raises(KeyboardInterrupt), following(Impatient()):
        write_simulation(tmp_path / "rec", simulate(scene("wall"), Sensor()))
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
@pytest.mark.parametrize("name", ["checkerboard", "charuco"])
def test_board_corners_lie_where_they_should(name):
    import cv2

    camera = Camera(640, 480, 580.0, 582.0, 322.3, 238.8, distortion=(0.08, -0.2, 0.001, -0.0005, 0.05))
    simulation = simulate(replace(scene(name, frames=3), camera=camera), Sensor())
    paint = simulation.scene.paints[0]
    errors = []
    for frame, T in zip(simulation.frames(), simulation.truth.poses, strict=True):
        for image in (frame.ir, frame.color[..., 0]):
            grey = np.clip(image / np.percentile(image, 99.5) * 255, 0, 255).astype(np.uint8)
            corners, ids = _corners(cv2, grey, simulation.scene.board)
            if corners is None or len(corners) < 20:
                continue
            T_picture_camera = inverse(paint.T_world_picture) @ T
            columns, square = simulation.scene.board.columns, simulation.scene.board.square_m
            local = np.column_stack([ids % columns + 1.5, ids // columns + 1.5, np.zeros(len(ids))]) * square
            expected = camera.project((local - T_picture_camera[:3, 3]) @ T_picture_camera[:3, :3])
            error = corners - expected
            if np.abs(error).max() > 5:  # a checkerboard may be found from its other end
                error = corners[::-1] - expected
            errors.append(error)
    assert len(errors) >= 4
    # measured: a mean of 0.002 to 0.02 px, and up to 0.18 px where the finder meets the lamp's falling light
    assert np.abs(np.concatenate(errors).mean(axis=0)).max() < 0.05
    assert max(np.median(np.linalg.norm(error, axis=1)) for error in errors) < 0.25


def _corners(cv2, grey, board):
    shape = (board.columns, board.rows)
    if not board.marker_m:
        found, corners = cv2.findChessboardCornersSB(grey, shape, flags=cv2.CALIB_CB_ACCURACY)
        return (corners.reshape(-1, 2), np.arange(shape[0] * shape[1])) if found else (None, None)
    markers = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, board.dictionary))
    size = (shape[0] + 1, shape[1] + 1)
    known = cv2.aruco.CharucoBoard(size, board.square_m, board.marker_m, markers)
    corners, ids, _, _ = cv2.aruco.CharucoDetector(known).detectBoard(grey)
    return (None, None) if corners is None else (corners.reshape(-1, 2), ids.ravel())


def test_a_black_wall_and_no_card_change_what_they_should():
    def light(name, **settings):
        frame = next(simulate(scene(name, frames=1, **settings), preset("kinect-v2-indoors")).frames())
        return frame.ir.astype(float)

    bright, dark = light("corner"), light("corner", black="yes")
    halves = [np.s_[:, :44], np.s_[:, 52:]]
    ratios = sorted(float(np.median(dark[half]) / np.median(bright[half])) for half in halves)
    assert ratios[0] < 0.1 and ratios[1] == pytest.approx(1.0, abs=0.05)  # the noise of one frame
    assert np.percentile(light("near-card"), 95) > 5 * np.percentile(light("near-card", card="no"), 95)


def test_only_a_bare_slab_lets_light_in():
    sensor = Sensor(principle="itof", effects=(SubsurfaceScattering(0.01),))

    def longer(**settings):
        made = scene("slab", frames=1, **settings)
        off = [next(simulate(made, one).frames()).depth for one in (sensor, Sensor(principle="itof"))]
        return off[0] - off[1]

    bare, covered = longer(), longer(covered="yes")
    middle, rim = np.s_[bare.shape[0] // 2, bare.shape[1] // 2], np.s_[5, 5]
    assert bare[middle] == pytest.approx(0.01, abs=0.0005) and abs(bare[rim]) < 0.0005
    assert np.nanmax(np.abs(covered)) < 0.0005


def test_a_wall_comes_nearer_while_frames_are_taken():
    frames = list(simulate(scene("approach", frames=4, near_m=0.9, far_m=1.2), Sensor(principle="itof")).frames())
    assert [float(np.median(frame.depth)) for frame in frames] == pytest.approx([1.2, 1.1, 1.0, 0.9], abs=1e-3)
    late = Sensor(principle="itof", effects=(MotionArtifact(duration=0.02),))
    moved = next(simulate(scene("approach", frames=4, near_m=0.9, far_m=1.2), late).frames()).depth - frames[0].depth
    assert 0.0005 < abs(float(np.median(moved))) < 0.01  # 3 m/s for 20 ms / 8, times the cosine of twice the phase


def test_the_sensor_warms_up_over_fifty_minutes():
    simulation = simulate(scene("warm-up"), Sensor())
    assert len(simulation) == 20
    assert simulation.timestamps[-1] - simulation.timestamps[0] == pytest.approx(3000.0)
    temperature = simulation.telemetry["temperature_c"]
    assert (np.diff(temperature) > 0).all() and 5 < np.ptp(temperature) < 15


@pytest.mark.parametrize(
    ("name", "settings"),
    [
        ("nowhere", {}),
        ("wall", {"colour": "red"}),
        ("wall", {"frames": "many"}),
        ("wall", {"frames": "0"}),
        ("wall", {"frames": "1000000000"}),
        ("wall", {"distance_m": "0"}),
        ("wall", {"distance_m": "nan"}),
        ("wall", {"tilt_deg": "90"}),
        ("wall", {"distance_m": ""}),
        ("wall", {"reflectance": "2"}),
        ("patches", {"columns": "0"}),
        ("patches", {"reflectance": "0.5,7"}),
        ("checkerboard", {"columns": "1"}),
        ("charuco", {"dictionary": "DICT_NONE"}),
        ("charuco", {"columns": "60", "rows": "60"}),
        ("near-card", {"card": "perhaps"}),
        ("turntable", {"frames": "0"}),
        ("turntable", {"scale": "0"}),
        ("turntable", {"scale": "1e-9"}),
    ],
)
def test_settings_that_cannot_be_are_told_in_one_line(name, settings):
    with pytest.raises(SceneError) as error:
        built_in(name, settings)
    assert "\n" not in str(error.value) and len(str(error.value)) < 300


def test_every_setting_is_read_back_from_its_usual_value():
    for name in SCENES:
        usual = settings_of(name)
        texts = {k: ",".join(map(str, v)) if isinstance(v, tuple) else str(v) for k, v in usual.items()}
        if name in ("wall", "step", "corner"):  # the others take longer, by the same code
            assert built_in(name, texts).name == name


@pytest.mark.parametrize(
    ("name", "setting", "value"),
    [
        ("turntable", "turns", "nan"), ("turntable", "turns", "1e9"), ("turntable", "elevation_deg", "inf"),
        ("turntable", "distance_m", "-1"), ("turntable", "uneven_sd_deg", "-3"), ("turntable", "wobble_deg", "400"),
        ("turntable", "slip_frame", "999"), ("wall", "distance_m", "nan"), ("wall", "distance_m", "1,inf"),
        ("wall", "distance_m", ""), ("wall", "reflectance", "7"), ("wall", "frames", "0"), ("room", "sweep_deg", "nan"),
    ],
)  # fmt: skip
def test_a_setting_that_is_not_possible_is_told(name, setting, value):
    with pytest.raises(FusionError, match=r"cannot be|is not possible|not there"):
        built_in(name, {setting: value})
