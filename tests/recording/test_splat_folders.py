"""nerfstudio data sets and plain folders of depth, written as they are described elsewhere."""

import json
from dataclasses import replace
from functools import partial

import cv2
import numpy as np
import pytest
import rendered

from fusion import convert_recording, open_recording, read_mesh
from fusion.commands.main import main
from fusion.errors import RecordingError

CLOSE = 0.15e-3  # as of phones: 0.2 px are 0.9 mm
LENS = (150.0, 152.0, 84.0, 57.0)  # fl_x, fl_y, cx, cy of 160 x 120, from the corner


def nerfstudio(folder, lenses=(LENS,) * 3, applied=None, bent=None, **changed):
    (folder / "images").mkdir(parents=True)
    (folder / "depths").mkdir()
    frames, faces = [], []
    for i, T in enumerate(rendered.cameras()):
        z, face = rendered.depth(T, 160, 120, *lenses[i], bent)
        faces.append(face)
        # numbers without zeros in front: 10 comes after 9
        cv2.imwrite(str(folder / f"depths/{i + 8}.png"), np.rint(1000 * z).astype(np.uint16))
        cv2.imwrite(
            str(folder / f"images/{i + 8}.png"), np.full((120, 160, 3), (30 * i, 100, 200), np.uint8)[..., ::-1]
        )
        stated = T if applied is None else np.vstack([applied, [0, 0, 0, 1]]) @ T
        frame = {"file_path": f"./images/{i + 8}.png", "depth_file_path": f"depths/{i + 8}.png"}
        frame |= {"transform_matrix": stated.tolist()}
        if len(set(lenses)) > 1:
            frame |= dict(zip(("fl_x", "fl_y", "cx", "cy"), lenses[i], strict=True))
        frames.append(frame)
    content = {"camera_model": "OPENCV", "w": 160, "h": 120, "frames": frames[::-1]}
    if len(set(lenses)) == 1:
        content |= dict(zip(("fl_x", "fl_y", "cx", "cy"), lenses[0], strict=True))
    content |= {} if applied is None else {"applied_transform": np.asarray(applied).tolist()}
    (folder / "transforms.json").write_text(json.dumps(content | changed))
    return faces


@pytest.mark.parametrize("applied", [None, [[1, 0, 0, 0.3], [0, 0, 1, -0.2], [0, -1, 0, 0.1]]])
def test_a_data_set_of_nerfstudio(tmp_path, applied):
    faces = nerfstudio(tmp_path / "x", applied=applied)
    for path in (tmp_path / "x", tmp_path / "x" / "transforms.json"):
        recording = open_recording(path)
        assert recording.camera.cx == LENS[2] - 0.5  # its pixels are counted from the corner
        worst = np.abs(rendered.errors(recording, faces))
        assert len(worst) >= 12 and worst.max() < CLOSE
        assert [int(frame.color[0, 0, 0]) for frame in recording] == [0, 30, 60]
    shifted = open_recording(tmp_path / "x", replace(recording.camera, cx=LENS[2]))
    assert np.abs(rendered.errors(shifted, faces)).max() > 4 * CLOSE


def test_frames_with_cameras_of_their_own(tmp_path):
    lenses = (LENS, (151.0, 153.0, 85.2, 56.0), (150.0, 152.0, 83.5, 58.1))
    nerfstudio(tmp_path / "x", lenses)
    recording = open_recording(tmp_path / "x")
    assert any("another camera" in told for told in recording.warnings)
    c = recording.camera
    faces = [rendered.depth(T, 160, 120, c.fx, c.fy, c.cx + 0.5, c.cy + 0.5)[1] for T in rendered.cameras()]
    worst = np.sort(np.abs(rendered.errors(recording, faces)))
    # a side seen at 80 degrees looks like a rim from pixel to pixel and keeps the nearest: 0.2 px are 0.9 mm
    assert worst[-2] < CLOSE and worst[-1] < 0.9e-3


WIDE = (70.0, 71.0, 81.5, 58.5)  # 120 degrees over the corners


def test_a_fisheye_lens(tmp_path):
    k = (0.02, -0.015, 0.006, -0.001)
    seen = partial(cv2.fisheye.undistortPoints, K=np.eye(3), D=np.array(k))
    names = dict(zip(("k1", "k2", "k3", "k4"), k, strict=True))
    faces = nerfstudio(tmp_path / "x", (WIDE,) * 3, bent=seen, camera_model="OPENCV_FISHEYE", **names)
    recording = open_recording(tmp_path / "x")
    # a pixel is twice as wide as of the other lens: 0.1 px
    assert np.abs(rendered.errors(recording, faces)).max() < CLOSE
    assert main(["convert", str(tmp_path / "x"), str(tmp_path / "y"), "--format", "nerfstudio"]) == 0
    written = json.loads((tmp_path / "y" / "transforms.json").read_text())
    assert written["camera_model"] == "OPENCV_FISHEYE"
    assert np.abs(rendered.errors(open_recording(tmp_path / "y"), faces)).max() < CLOSE


def test_four_radial_terms(tmp_path):
    k = (-0.25, 0.12, -0.04, 0.006)

    def straight(bent):
        r = np.linspace(0, 1.5, 100_000)
        far = np.hypot(*np.moveaxis(bent, -1, 0))
        true = np.interp(far, r * (1 + k[0] * r**2 + k[1] * r**4 + k[2] * r**6 + k[3] * r**8), r)
        return bent * (true / np.maximum(far, 1e-12))[..., None]

    faces = nerfstudio(tmp_path / "x", bent=straight, **dict(zip(("k1", "k2", "k3", "k4"), k, strict=True)))
    assert np.abs(rendered.errors(open_recording(tmp_path / "x"), faces)).max() < CLOSE


@pytest.mark.parametrize(
    ("changed", "match"),
    [
        ({"camera_model": "EQUIRECTANGULAR"}, "EQUIRECTANGULAR.*undistort"),
        ({"camera_model": "OPENCV_FISHEYE", "k1": -0.9}, "does not reach the image's corners.*undistort"),
        ({"frames": []}, "no frame has depth"),
        ({"k1": -1.5, "k4": 0.1}, "does not reach.*undistort"),
        ({"applied_transform": [[2, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]]}, "applied_transform"),
        ({"fl_x": "wide"}, "fl_x"),
        ({"fl_x": None}, "fl_x"),
    ],
)
def test_what_cannot_be_read_is_named(tmp_path, changed, match):
    nerfstudio(tmp_path / "x", **changed)
    with pytest.raises(RecordingError, match=match):
        open_recording(tmp_path / "x")


def test_names_stay_inside_the_folder(tmp_path):
    nerfstudio(tmp_path / "x")
    path = tmp_path / "x" / "transforms.json"
    path.write_text(path.read_text().replace("depths/8.png", "../../8.png"))
    with pytest.raises(RecordingError, match="outside"):
        open_recording(tmp_path / "x")


@pytest.mark.parametrize("kind", ["png", "counts", "metres", "in depth/"])
def test_a_folder_of_depth_and_a_camera_that_is_said(tmp_path, kind):
    folder = tmp_path / "x"
    place = folder / "depth" if kind == "in depth/" else folder
    place.mkdir(parents=True)
    depths = [rendered.depth(T, 160, 120, *LENS)[0] for T in rendered.cameras()]
    for i, z in enumerate(depths):
        counts = np.rint(1000 * z).astype(np.uint16)
        if kind in ("png", "in depth/"):
            cv2.imwrite(str(place / f"d{i + 8}.png"), counts)
        else:
            np.save(place / f"d{i + 8}.npy", z.astype(np.float32) if kind == "metres" else counts)
    with pytest.raises(RecordingError, match=r"--camera fx,fy,cx,cy"):
        open_recording(folder)
    recording = open_recording(folder, "150,152,83.5,56.5")
    camera = recording.camera
    assert (camera.width, camera.height, camera.fx, camera.cy) == (160, 120, 150.0, 56.5)
    for frame, z in zip(recording, depths, strict=True):
        # half a millimetre: the counts
        np.testing.assert_allclose(np.nan_to_num(frame.depth), z, atol=0.51e-3)
    assert any("unit" in told for told in recording.warnings) == (kind != "metres")


def test_four_numbers_leave_what_a_recording_says_itself(tmp_path):
    nerfstudio(tmp_path / "x", depth_unit_scale_factor=0.0005)
    recording = open_recording(tmp_path / "x", "140,141,80,60")
    assert recording.camera.fx == 140 and recording.camera.depth_scale == pytest.approx(2000)
    with pytest.raises(RecordingError, match="fx,fy,cx,cy"):
        open_recording(tmp_path / "x", "0,0,80,60")


def test_real_numbers_that_are_no_metres_are_told(tmp_path):
    np.save(tmp_path / "0.npy", np.full((60, 80), 850.0, np.float32))
    assert any("850 m" in told for told in open_recording(tmp_path, "70,70,40,30").warnings)


def test_photographs_are_no_depth(tmp_path):
    cv2.imwrite(str(tmp_path / "0.png"), np.full((60, 80), 85, np.uint8))
    with pytest.raises(RecordingError, match="no recording"):
        open_recording(tmp_path, "70,70,40,30")


@pytest.mark.parametrize("source", ["nerfstudio", "native"])
def test_written_for_splats_and_read_again(tmp_path, capsys, source):
    faces = nerfstudio(tmp_path / "x")
    given = tmp_path / "x"
    if source == "native":
        assert main(["convert", str(given), str(tmp_path / "native")]) == 0
        given = tmp_path / "native"
    assert main(["convert", str(given), str(tmp_path / "out"), "--format", "nerfstudio"]) == 0
    one, other = open_recording(given), open_recording(tmp_path / "out")
    assert other.format == "nerfstudio" and not other.warnings
    for a, b in zip(one, other, strict=True):
        np.testing.assert_array_equal(a.depth, b.depth)
        np.testing.assert_array_equal(a.color, b.color)
    np.testing.assert_allclose(one.timestamps, other.timestamps, atol=1e-6)
    np.testing.assert_allclose(one.poses.poses, other.poses.poses, atol=1e-6)
    assert np.abs(rendered.errors(other, faces)).max() < CLOSE
    # the cloud lies where the scene is: each point on one of its faces, to the counts and a metre's slope
    points = read_mesh(tmp_path / "out" / "points.ply").vertices
    assert len(points) > 10_000
    off = np.min([np.abs(points @ n - d) for n, d in rendered.FACES], axis=0)
    assert np.percentile(off, 99) < 1e-3


def test_what_splats_cannot_be_made_of(tmp_path, capsys):
    np.save(tmp_path / "0.npy", np.full((60, 80), 0.8, np.float32))
    words = ["convert", str(tmp_path), str(tmp_path.parent / "no_splats"), "--camera", "70,70,40,30"]
    assert main([*words, "--format", "nerfstudio"]) == 1
    assert "no colour images" in capsys.readouterr().err


def test_poses_from_a_trajectory(tmp_path, capsys):
    nerfstudio(tmp_path / "x")
    recording = open_recording(tmp_path / "x")
    lines = [f"{t:.6f} {k} 2 3 0 0 0 1" for k, t in enumerate(recording.timestamps)]
    (tmp_path / "t.txt").write_text("\n".join(lines) + "\n")
    words = ["convert", str(tmp_path / "x"), str(tmp_path / "out"), "--poses", str(tmp_path / "t.txt")]
    assert main([*words, "--format", "nerfstudio"]) == 0
    np.testing.assert_allclose(open_recording(tmp_path / "out").poses.centres[2], [2, 2, 3])


def test_arrays_of_metres_in_a_data_set(tmp_path):
    faces = nerfstudio(tmp_path / "x", depth_unit_scale_factor=1.0)
    path = tmp_path / "x" / "transforms.json"
    path.write_text(path.read_text().replace('.png", "transform', '.npy", "transform'))
    for i, T in enumerate(rendered.cameras()):
        np.save(tmp_path / f"x/depths/{i + 8}.npy", rendered.depth(T, 160, 120, *LENS)[0].astype(np.float32))
    recording = open_recording(tmp_path / "x")
    assert np.abs(rendered.errors(recording, faces)).max() < CLOSE
    convert_recording(recording, tmp_path / "native")
    # 0.2 mm a count
    np.testing.assert_allclose(open_recording(tmp_path / "native")[1].depth, recording[1].depth, atol=0.11e-3)


def test_a_camera_that_is_said_leaves_the_unit_alone(tmp_path):
    nerfstudio(tmp_path / "x", depth_unit_scale_factor=0.0005)
    recording = open_recording(tmp_path / "x")
    other = open_recording(tmp_path / "x", replace(recording.camera, depth_scale=1000.0))
    np.testing.assert_array_equal(recording[0].depth, other[0].depth)
