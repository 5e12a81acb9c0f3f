"""Perfect depth of any simulator through a sensor: what is computed of it, what is told, and the bits."""

import json

import cv2
import numpy as np
import pytest

from fusion.commands.main import main
from fusion.errors import RecordingError, SensorError
from fusion.geometry.camera import Camera
from fusion.recording.native.camera_file import write_camera
from fusion.recording.open import open_recording
from fusion.sensor.files.sensor_file import read_sensor
from fusion.sensor.presets import PRESETS
from fusion.sensor.view import incidence_of
from fusion.simulation.ideal.edges import edges_of_perfect
from fusion.simulation.ideal.frame import IdealFrame
from fusion.simulation.ideal.sense import sense, sense_all
from fusion.simulation.ideal.slopes import facing_of
from fusion.simulation.ideal.view import reach_of, unknown_to, view_of_ideal

PINHOLE = Camera(160, 120, 131.25, 131.25, 79.5, 59.5, depth_scale=5000.0)
LENS = Camera(160, 120, 131.25, 130.0, 79.5, 59.5, (0.08, -0.1, 0.001, 0.002), depth_scale=5000.0)


def plane(camera: Camera, normal: np.ndarray, distance: float) -> np.ndarray:
    """Depth (h, w) [m] of the plane n x = -distance, n towards the camera."""
    rays = np.dstack([camera.rays(), np.ones(camera.shape, np.float32)])
    return (-distance / (rays @ normal)).astype(np.float32)


def towards(tilt: float, turned: float) -> np.ndarray:
    return -np.array([np.sin(tilt) * np.cos(turned), np.sin(tilt) * np.sin(turned), np.cos(tilt)])


@pytest.mark.parametrize(("camera", "tolerance"), [(PINHOLE, 2e-3), (LENS, 6e-3)], ids=["pinhole", "lens"])
@pytest.mark.parametrize("tilt", [0.0, 0.5, 1.0])
def test_the_normals_of_a_plane_are_its_own(camera, tolerance, tilt):
    # float32 leaves 1e-7 of the inverse depth, over a pixel 1e-5 rad; a lens bends rays within two pixels
    normal = towards(tilt, 0.7)
    depth = plane(camera, normal, 1.2)
    found = facing_of(np.where(depth > 0, depth, np.nan), camera)
    incidence, normals = found.incidence, found.normals
    there = (depth > 0.2) & (depth < 10)
    assert np.abs(normals - normal)[there].max() < tolerance
    expected = incidence_of(np.broadcast_to(normal.astype(np.float32), normals.shape), camera)
    assert np.abs(np.cos(incidence) - np.cos(expected))[there].max() < tolerance


def test_rounded_depth_is_compared_farther_apart():
    normal = towards(0.6, 0.3)
    depth = np.round(plane(PINHOLE, normal, 1.2) * 1000) / np.float32(1000)
    rough, smooth = (facing_of(depth, PINHOLE, rounding=step).normals for step in (0.0, 0.001))
    off = [np.arccos(np.clip(normals @ normal.astype(np.float32), -1, 1)).mean() for normals in (rough, smooth)]
    assert off[1] < 0.7 * off[0]


def card() -> np.ndarray:
    """A card at 1 m before a tilted wall."""
    depth = plane(PINHOLE, towards(0.4, 0.0), 1.6)
    depth[40:80, 50:110] = 1.0
    return depth


def test_an_edge_lies_between_the_pixels_that_it_parts_and_nowhere_else():
    depth = card()
    edges = edges_of_perfect(IdealFrame(depth), np.ones_like(depth))
    inside = np.zeros(depth.shape, bool)
    inside[40:80, 50:110] = True
    middle = cv2.distanceTransform(inside.astype(np.uint8), cv2.DIST_L2, 5)
    assert np.isinf(edges.distance[middle > 9]).all()  # farther than it reaches
    assert (edges.distance[60, [49, 50, 109, 110]] <= 1).all()
    # both pixels beside an edge share one pixel
    assert edges.distance[60, 49] + edges.distance[60, 50] == pytest.approx(1, abs=0.1)
    assert edges.jump[60, 50] == pytest.approx(depth[60, 49] - 1.0, abs=1e-5)
    assert edges.jump[60, 49] == pytest.approx(1.0 - depth[60, 49], abs=1e-5)


def test_where_edges_run_is_even_over_the_pixel():
    depth = np.where(np.arange(480)[:, None] % 40 < 20, 1.0, 1.5).astype(np.float32) * np.ones((480, 640), np.float32)
    edges = edges_of_perfect(IdealFrame(depth), np.ones_like(depth))
    place = edges.distance[19]  # from the last row of a stripe to its edge
    assert 0.3 < place.mean() < 0.7 and place.min() < 0.15 and place.max() > 0.85


@pytest.mark.parametrize("tilt", [0.0, 0.6, 1.2])
def test_a_plane_has_no_edge(tilt):
    depth = plane(PINHOLE, towards(tilt, 1.0), 1.5)
    depth[~((depth > 0.2) & (depth < 20))] = np.nan
    edges = edges_of_perfect(IdealFrame(depth), np.ones_like(depth))
    seen = np.isfinite(cv2.erode(np.nan_to_num(depth, nan=-1), np.ones((21, 21))))
    assert np.isinf(edges.distance[seen & (cv2.erode(np.nan_to_num(depth), np.ones((21, 21))) > 0)]).all()


def test_labels_find_an_edge_that_is_too_small_for_depth_alone():
    depth = np.full(PINHOLE.shape, 1.0, np.float32)
    depth[:, 80:] += 0.001  # a sheet of card
    labels = (np.arange(160) >= 80) * np.ones(PINHOLE.shape, int)
    alone = edges_of_perfect(IdealFrame(depth), np.ones_like(depth))
    told = edges_of_perfect(IdealFrame(depth, segmentation=labels), np.ones_like(depth))
    assert np.isinf(alone.distance).all() and (told.distance[:, 79:81] <= 1).all()


@pytest.mark.parametrize("name", PRESETS)
def test_the_bits_do_not_depend_on_threads(name):
    sensor = read_sensor(name)
    frames = [IdealFrame(card() + np.float32(0.01 * n), reflectance=0.5) for n in range(3)]
    one = list(sense_all(frames, PINHOLE, sensor, 7, threads=1))
    two = list(sense_all(frames, PINHOLE, sensor, 7, threads=3))
    alone = sense(frames[0], PINHOLE, sensor, 7)  # its infrared image is made in another thread
    assert np.array_equal(alone.depth, one[0].depth, equal_nan=True) and np.array_equal(alone.ir, one[0].ir)
    assert all(np.array_equal(a.depth, b.depth, equal_nan=True) for a, b in zip(one, two, strict=True))
    assert not np.array_equal(one[0].depth, sense(frames[0], PINHOLE, sensor, 8).depth, equal_nan=True)


def test_a_wall_gets_the_noise_that_the_model_states():
    sensor = read_sensor("azure-kinect")
    wall = np.full(PINHOLE.shape, 2.0, np.float32)
    seen = view_of_ideal(IdealFrame(wall), PINHOLE, sensor)
    stated = sensor.sigma(wall, seen.incidence, PINHOLE)
    frames = np.stack([frame.depth for frame in sense_all([wall] * 20, PINHOLE, sensor, 3)])
    error = frames - np.nanmean(frames, axis=0)
    # 20 frames of 19200 pixels tell a spread to 0.2 %; rounding to 1 mm is even for a noise of 1.8 mm
    assert np.nanstd(error) * np.sqrt(20 / 19) == pytest.approx(float(np.sqrt(np.nanmean(stated**2))), rel=0.01)


def test_what_is_missing_is_told_and_what_is_given_is_not():
    wall = np.full(PINHOLE.shape, 2.0, np.float32)
    sensor = read_sensor("kinect-v2-indoors")
    assert any("reflectance is not given" in text for text in unknown_to(sensor, IdealFrame(wall)))
    assert not any("reflectance" in text for text in unknown_to(sensor, IdealFrame(wall, reflectance=0.5)))
    assert not any("reflectance" in text for text in unknown_to(read_sensor("kinect-v1"), IdealFrame(wall)))


def test_edges_are_sought_as_far_as_effects_need_them():
    assert reach_of(read_sensor("azure-kinect"), PINHOLE) == pytest.approx(2.5)  # five times 0.5 px
    assert reach_of(read_sensor("kinect-v1"), PINHOLE) == pytest.approx(4.0)


@pytest.mark.parametrize(
    ("frame", "word"),
    [
        (IdealFrame(np.ones((10, 10))), "depth"),
        (IdealFrame(np.ones((120, 160)), normals=np.ones((120, 160))), "normals"),
        (IdealFrame(np.ones((120, 160)), reflectance=2.0), "reflectance"),
        (IdealFrame(np.ones((120, 160)), segmentation=np.ones((1, 2), int)), "segmentation"),
    ],
)
def test_what_does_not_fit_is_refused(frame, word):
    with pytest.raises(SensorError, match=word):
        sense(frame, PINHOLE, read_sensor("kinect-v1"))


@pytest.fixture
def ideal(tmp_path, monkeypatch):
    """A recording without errors of two frames, and images beside it."""
    monkeypatch.chdir(tmp_path)
    write_camera(tmp_path / "camera.json", PINHOLE)
    words = "simulate step --set frames=2 -o ideal --camera camera.json --quiet"
    assert main(words.split()) == 0
    depth = open_recording("ideal")[0].depth
    normals = facing_of(depth, PINHOLE).normals
    for name in ("normals", "labels", "grey", "gl"):
        (tmp_path / name).mkdir()
    for n in range(2):
        np.save(tmp_path / f"normals/{n}.npy", normals)
        as_gl = np.round((normals * [1, -1, -1] + 1) * 127.5).astype(np.uint8)
        cv2.imwrite(str(tmp_path / f"gl/{n}.png"), as_gl[..., ::-1])
        cv2.imwrite(str(tmp_path / f"labels/{n}.png"), (depth > 1.1).astype(np.uint8))
        cv2.imwrite(str(tmp_path / f"grey/{n}.png"), np.full(PINHOLE.shape, 128, np.uint8))
    (tmp_path / "table.json").write_text('{"0": 0.5, "1": 0.2}')
    return tmp_path


def run(words: str) -> int:
    return main(f"simulate --ideal ideal --sensor kinect-v2-indoors --seed 2 {words}".split())


def test_a_recording_comes_out_with_its_poses_and_its_truth(ideal, capsys):
    assert run("-o out --reflectance ir --json") == 0
    told = json.loads(capsys.readouterr().out)
    out = open_recording("out")
    assert told["frames"] == len(out) == 2 and out.poses is not None and out.camera.principle == "itof"
    truth = json.loads((ideal / "out" / "truth" / "truth.json").read_text())
    assert truth["seed"] == 2 and truth["not_known"] == told["not_known"] != []
    error = out[0].depth - open_recording("ideal")[0].depth
    assert 0.0005 < np.nanstd(error) < 0.05


def test_given_channels_are_read_in_the_axes_of_both_worlds(ideal):
    assert run("-o a --normals normals --segmentation labels --reflectance grey --quiet") == 0
    assert run("-o b --normals gl --segmentation labels --reflectance 0.50196 --quiet") == 0
    a, b = open_recording("a")[0].depth, open_recording("b")[0].depth
    # 8 bits of a normal are 0.4 deg: the same draws, nearly the same spread
    assert np.nanmax(np.abs(a - b)) <= 0.0011 and (a == b).mean() > 0.95
    assert run("-o c --segmentation labels --reflectance table.json --quiet") == 0


@pytest.mark.parametrize(
    "words",
    [
        "--normals grey", "--normals nowhere", "--reflectance 3", "--reflectance table.json", "--reflectance nowhere",
        "--segmentation ideal/ir", "--set frames=1", "--segmentation ideal",
    ],
)  # fmt: skip
def test_wrong_channels_are_one_line_and_write_nothing(ideal, capsys, words):
    np.save(ideal / "ideal/ir/extra.npy", np.zeros(3))  # a third image
    assert run(f"-o out {words}") == 1
    assert capsys.readouterr().err.count("\n") == 1 and not (ideal / "out").exists()


def test_normals_of_another_scene_are_refused(ideal):
    np.save(ideal / "normals/0.npy", np.broadcast_to(np.float32([1, 0, 0]), (*PINHOLE.shape, 3)))
    assert run("-o out --normals normals") == 1
    from fusion.simulation.ideal.channels import channel, normals_in

    with pytest.raises(RecordingError, match="do not fit the depth"):
        normals_in(channel(ideal / "normals", "normals", 2), 0, PINHOLE, open_recording("ideal")[0].depth)
