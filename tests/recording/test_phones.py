"""Recordings of phones, written as their formats are described: size, place, handedness, half pixels, confidence."""

import json
import shutil
import sys
import zipfile
from dataclasses import dataclass, field

import cv2
import numpy as np
import pytest
import rendered

from fusion import convert_recording, open_recording
from fusion.errors import RecordingError

lzfse = pytest.importorskip("lzfse")
from scipy.spatial.transform import Rotation  # noqa: E402

# 0.2 px of the coarsest image are 0.9 mm on what leans; a millimetre's rounding is far below that in a median
CLOSE = 0.15e-3
STAMPS = [12.5, 12.6, 12.75]


@dataclass
class Scene:
    """What a test writes: colour camera, depth size, and each frame's fx, fy, ox, oy of the colour camera."""

    width: int = 640
    height: int = 480
    depth: tuple[int, int] = (160, 120)
    lens: list = field(default_factory=lambda: [[500.0, 505.0, 331.0, 236.0]] * 3)

    def rendered(self, i):
        across, down = self.depth[0] / self.width, self.depth[1] / self.height
        fx, fy, ox, oy = self.lens[i]
        return rendered.depth(rendered.cameras()[i], *self.depth, fx * across, fy * down, ox * across, oy * down)

    def faces(self):
        return [self.rendered(i)[1] for i in range(3)]

    def picture(self, i):
        image = np.full((self.height, self.width, 3), (40 + 20 * i, 90, 200), np.uint8)  # RGB
        return cv2.imencode(".jpg", image[..., ::-1])[1].tobytes()


CONFIDENCE = np.full((120, 160), 2, np.uint8)
CONFIDENCE[:10] = 0
MOVED = [[500.0, 505.0, 331.0, 236.0], [503.0, 508.0, 337.0, 232.0], [500.0, 505.0, 327.0, 239.0]]


def record3d(path, scene, **changed):
    poses = [[*Rotation.from_matrix(T[:3, :3]).as_quat(), *T[:3, 3]] for T in rendered.cameras()]
    fx, fy, ox, oy = scene.lens[0]
    metadata = {"w": scene.width, "h": scene.height, "dw": scene.depth[0], "dh": scene.depth[1], "fps": 30,
                "K": [fx, 0, 0, 0, fy, 0, ox, oy, 1], "perFrameIntrinsicCoeffs": scene.lens,
                "frameTimestamps": STAMPS, "poses": poses, "initPose": [0, 0, 0, 1, 0, 0, 0]} | changed  # fmt: skip
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("metadata", json.dumps({k: v for k, v in metadata.items() if v is not None}))
        for i in range(3):
            z = scene.rendered(i)[0].astype("<f4")
            archive.writestr(f"rgbd/{i}.depth", lzfse.compress(z.tobytes()))
            archive.writestr(f"rgbd/{i}.conf", lzfse.compress(CONFIDENCE.tobytes()))
            archive.writestr(f"rgbd/{i}.jpg", scene.picture(i))
    return path


def polycam(path, scene):
    names = [str(int(stamp * 1e6)) for stamp in STAMPS]
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for i, (name, T) in enumerate(zip(names, rendered.cameras(), strict=True)):
            fx, fy, ox, oy = scene.lens[i]
            camera = {f"t_{r}{c}": T[r, c] for r in range(3) for c in range(4)} | {"blur_score": 9.0}
            camera |= {"fx": fx, "fy": fy, "cx": ox, "cy": oy, "width": scene.width, "height": scene.height}
            archive.writestr(f"capture/keyframes/cameras/{name}.json", json.dumps(camera))
            counts = np.rint(1000 * scene.rendered(i)[0]).astype(np.uint16)
            archive.writestr(f"capture/keyframes/depth/{name}.png", cv2.imencode(".png", counts)[1].tobytes())
            sure = (CONFIDENCE.astype(int) * 127).astype(np.uint8)
            archive.writestr(f"capture/keyframes/confidence/{name}.png", cv2.imencode(".png", sure)[1].tobytes())
            archive.writestr(f"capture/keyframes/images/{name}.jpg", scene.picture(i))
        archive.writestr("__MACOSX/capture/keyframes/cameras/._1.json", b"\0")
    return path


def stray(path, scene, numpy=False, old=False):
    (path / "depth").mkdir(parents=True)
    (path / "confidence").mkdir()
    fx, fy, ox, oy = scene.lens[0]
    (path / "camera_matrix.csv").write_text(f"{fx}, 0.0, {ox}\n0.0, {fy}, {oy}\n0.0, 0.0, 1.0\n")
    rows = ["x, y, z, qx, qy, qz, qw" if old else "timestamp, frame, x, y, z, qx, qy, qz, qw"]
    for i, T in enumerate(rendered.cameras()):
        counts = np.rint(1000 * scene.rendered(i)[0]).astype(np.uint16)
        if numpy:
            np.save(path / "depth" / f"{i:06d}.npy", counts)
        else:
            cv2.imwrite(str(path / "depth" / f"{i:06d}.png"), counts)
        cv2.imwrite(str(path / "confidence" / f"{i:06d}.png"), CONFIDENCE)
        turned = T[:3, :3] @ np.diag([1, -1, -1])  # z forward, y down
        values = [*T[:3, 3], *Rotation.from_matrix(turned).as_quat()]
        first = [] if old else [f"{STAMPS[i]}", f"{i:06d}"]
        rows.append(", ".join([*first, *(f"{v:.9f}" for v in values)]))
    (path / "odometry.csv").write_text("\n".join(rows) + "\n")
    return path


def close(recording, scene):
    worst = np.abs(rendered.errors(recording, scene.faces()))
    assert len(worst) >= 12 and worst.max() < CLOSE
    assert all(np.isnan(frame.depth[:10]).all() for frame in recording)
    assert any("confidence" in told for told in recording.warnings)


@pytest.mark.parametrize("write", [record3d, polycam])
@pytest.mark.parametrize("size", [(640, 480), (160, 120)])
def test_archives_of_phones(tmp_path, write, size):
    scene = Scene(*size, lens=[[v * size[0] / 640 for v in (500.0, 505.0, 331.0, 236.0)]] * 3)
    recording = open_recording(write(tmp_path / "x.zip", scene))
    close(recording, scene)
    np.testing.assert_allclose(recording.timestamps, STAMPS, atol=1e-9)
    if size == (640, 480):
        assert recording.color_is_apart and recording.camera.color.fx == pytest.approx(500.0)
        # the principal point is said from the corner, and the first pixel's centre is half a pixel from there
        assert recording.camera.color.cx == pytest.approx(330.5)
        np.testing.assert_allclose(recording.color_apart(1)[5, 5], [60, 90, 200], atol=3)
    else:
        np.testing.assert_allclose(recording[1].color[5, 5], [60, 90, 200], atol=3)
    convert_recording(recording, tmp_path / "native")
    native = open_recording(tmp_path / "native")
    worst = np.abs(rendered.errors(native, scene.faces()))
    assert worst.max() < CLOSE and (native.has_color.all())


def test_half_a_pixel_would_be_seen(tmp_path):
    """What the other tests would miss, they would not be worth."""
    scene = Scene()
    recording = open_recording(record3d(tmp_path / "x.r3d", scene))
    camera = recording.camera
    from dataclasses import replace

    shifted = open_recording(tmp_path / "x.r3d", replace(camera, cx=camera.cx + 0.5))
    assert np.abs(rendered.errors(shifted, scene.faces())).max() > 4 * CLOSE


@pytest.mark.parametrize("write", [record3d, polycam])
def test_a_lens_that_moves(tmp_path, write):
    scene = Scene(lens=MOVED)
    recording = open_recording(write(tmp_path / "x.zip", scene))
    assert any("another camera" in told for told in recording.warnings)
    # a face's pixels move by up to two: those of the first frame's camera are named by the common one's
    common = recording.camera
    faces = [rendered.depth(T, 160, 120, common.fx, common.fy, common.cx + 0.5, common.cy + 0.5)[1]
             for T in rendered.cameras()]  # fmt: skip
    assert np.abs(rendered.errors(recording, faces)).max() < CLOSE


def test_an_unpacked_archive_is_the_same_recording(tmp_path):
    scene = Scene()
    with zipfile.ZipFile(record3d(tmp_path / "x.r3d", scene)) as archive:
        archive.extractall(tmp_path / "folder")
    close(open_recording(tmp_path / "folder"), scene)


def test_the_size_of_depth_where_nothing_says_it(tmp_path):
    scene = Scene(width=480, height=640, depth=(192, 256), lens=[[400.0, 400.0, 236.0, 331.0]] * 3)
    path = record3d(tmp_path / "x.r3d", scene, dw=None, dh=None)
    with zipfile.ZipFile(path, "a") as archive:
        assert "rgbd/0.conf" in archive.namelist()
    # confidence of another size than depth is no confidence of this depth
    with pytest.raises(RecordingError, match="LZFSE"):
        open_recording(path)


def test_a_front_camera_without_poses_or_stamps(tmp_path):
    path = record3d(tmp_path / "x.r3d", Scene(), poses=[], frameTimestamps=[], perFrameIntrinsicCoeffs=[])
    recording = open_recording(path)
    assert recording.poses is None and any("time stamps" in told for told in recording.warnings)
    np.testing.assert_allclose(np.diff(recording.timestamps), 1 / 30)


@pytest.mark.parametrize(("numpy", "old"), [(False, False), (True, True)])
def test_stray_scanner(tmp_path, numpy, old):
    scene = Scene(width=1920, height=1440, lens=[[1500.0, 1515.0, 993.0, 708.0]] * 3)
    recording = open_recording(stray(tmp_path / "x", scene, numpy, old))
    close(recording, scene)
    if not old:
        np.testing.assert_allclose(recording.timestamps, STAMPS)


def test_stray_scanner_with_its_video(tmp_path):
    av = pytest.importorskip("av")
    scene = Scene()
    folder = stray(tmp_path / "x", scene)
    with av.open(str(folder / "rgb.mp4"), "w") as made:
        stream = made.add_stream("mpeg4", rate=30)
        stream.width, stream.height, stream.pix_fmt = 640, 480, "yuv420p"
        for i in range(3):
            image = np.full((480, 640, 3), (60 * i + 40, 90, 200), np.uint8)
            made.mux(stream.encode(av.VideoFrame.from_ndarray(image, format="rgb24")))
        made.mux(stream.encode())
    recording = open_recording(folder)
    close(recording, scene)
    for i in (2, 0, 1):  # in any order; 12: what the video's packing takes
        np.testing.assert_allclose(recording.color_apart(i)[100, 100], [60 * i + 40, 90, 200], atol=12)


def test_libraries_that_are_not_installed_are_named_with_their_extra(tmp_path, monkeypatch):
    packed, folder = record3d(tmp_path / "a.r3d", Scene()), stray(tmp_path / "x", Scene())
    (folder / "rgb.mp4").touch()
    for name in ("lzfse", "av"):
        monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(RecordingError, match=r'package lzfse.*pip install "fusion-scan\[iphone\]"'):
        open_recording(packed)[0]
    recording = open_recording(folder)  # its depth needs none
    assert any('package av; pip install "fusion-scan[iphone]"' in told for told in recording.warnings)
    assert np.isfinite(recording[0].depth).any()


@pytest.mark.parametrize("write", [record3d, polycam])
def test_cut_and_lying_archives_are_one_line(tmp_path, write):
    whole = write(tmp_path / "x.zip", Scene()).read_bytes()
    for size in (0, 10, 400, len(whole) // 2, len(whole) - 10):
        (tmp_path / "cut.zip").write_bytes(whole[:size])
        with pytest.raises(RecordingError):
            open_recording(tmp_path / "cut.zip")
    random = np.random.default_rng(3)
    for _ in range(40):
        data = bytearray(whole)
        for at in random.integers(0, len(data), 6):
            data[at] = random.integers(256)
        (tmp_path / "bad.zip").write_bytes(bytes(data))
        try:
            list(open_recording(tmp_path / "bad.zip"))
        except RecordingError as problem:
            assert "\n" not in str(problem)


def test_an_image_that_claims_to_be_huge_is_not_unpacked(tmp_path):
    scene = Scene(width=65535, height=65535, depth=(160, 120), lens=[[500.0] * 4] * 3)
    shutil.copy(record3d(tmp_path / "a.r3d", Scene()), tmp_path / "b.r3d")
    with zipfile.ZipFile(tmp_path / "b.r3d", "a") as archive, pytest.warns(UserWarning):
        metadata = json.loads(archive.read("metadata")) | {"dw": 65535, "dh": 65535, "w": scene.width}
        archive.writestr("metadata", json.dumps(metadata))
    with pytest.raises(RecordingError, match="too large"):
        open_recording(tmp_path / "b.r3d")


def test_poses_that_are_lost_or_none(tmp_path):
    good = [[0.0, 0, 0, 1, 0.1 * i, 0, 0] for i in range(3)]
    lost = [good[0], [0.0] * 7, good[2]]
    assert open_recording(record3d(tmp_path / "a", Scene(), poses=lost)).poses.valid.tolist() == [True, False, True]
    assert open_recording(record3d(tmp_path / "b", Scene(), poses=[good[0]] * 3)).poses is None
    with pytest.raises(RecordingError, match="unit length"):  # translation first
        open_recording(record3d(tmp_path / "c", Scene(), poses=[[0.3, 2.0, 1.0, 0, 0, 0, 1]] * 3))


def test_a_clock_that_was_set_back_is_told(tmp_path):
    recording = open_recording(record3d(tmp_path / "x.r3d", Scene(), frameTimestamps=[12.5, 12.6, 10.7]))
    assert any("go back 1 times (by 1.9 s at frame 2)" in told for told in recording.warnings)
    np.testing.assert_allclose(recording.timestamps, np.arange(3) / 10)  # the one step forward
    np.testing.assert_allclose(recording.poses.timestamps, recording.timestamps)


UPRIGHT = Scene(480, 640, (120, 160), [[500.0, 505.0, 236.0, 331.0]] * 3)


@pytest.mark.parametrize("write", [record3d, polycam])
def test_upright_images_come_out_upright_and_in_place(tmp_path, monkeypatch, write):
    """The app turns images, camera and poses together: what is stored is one camera, whose axes are the images'."""
    monkeypatch.setitem(globals(), "CONFIDENCE", np.full((160, 120), 2, np.uint8))
    recording = open_recording(write(tmp_path / "x", UPRIGHT))
    assert recording.camera.shape == (160, 120) and recording.camera.color.shape == (640, 480)
    worst = np.abs(rendered.errors(recording, UPRIGHT.faces()))
    assert len(worst) >= 6 and worst.max() < CLOSE


@pytest.mark.parametrize("write", [record3d, polycam])
def test_depth_that_lies_beside_colour_that_stands_is_not_squeezed(tmp_path, monkeypatch, write):
    monkeypatch.setitem(globals(), "CONFIDENCE", np.full((120, 160), 2, np.uint8))
    path = write(tmp_path / "x", Scene(480, 640))
    with pytest.raises(RecordingError, match=r"160 x 120, colour of 480 x 640.*--camera"):
        open_recording(path)
    assert open_recording(path, "125,126,80,60").camera.shape == (120, 160)
