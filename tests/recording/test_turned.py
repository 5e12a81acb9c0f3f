"""Colour that stands beside depth that lies, or the other way round: turned where it is clear which way, else told."""

import io
import json
import zipfile

import cv2
import numpy as np
import pytest
import rendered
from PIL import Image

from fusion import inspect, open_recording
from fusion.errors import RecordingError
from fusion.geometry.camera import Camera
from fusion.recording.cameras.turned import fit_of
from fusion.recording.writing.folders import write_png

FRAMES, WIDTH, HEIGHT, TIMES = 5, 160, 120, 2
LENS = 125.0, 126.25, 82.75, 59.0  # of depth, from the corner
PAINT = np.array([[200, 60, 40], [40, 160, 60], [60, 60, 220], [230, 220, 60], [30, 200, 210], [150, 40, 160],
                  [240, 240, 240], [20, 20, 20], [90, 90, 90]], np.uint8)  # fmt: skip
LEFT, RIGHT = 1, 3
NOTES = {LEFT: 8, RIGHT: 6}  # EXIF: which turn is asked for


def scene(i, times=1):
    return rendered.depth(rendered.cameras(FRAMES)[i], WIDTH * times, HEIGHT * times, *(times * x for x in LENS))


def picture(i, times=TIMES):
    """(h, w, 3) each face in its own colour."""
    return PAINT[scene(i, times)[1]]


def jpeg(pixels, orientation=None):
    data, note = io.BytesIO(), Image.Exif()
    if orientation:
        note[0x112] = orientation
    Image.fromarray(np.ascontiguousarray(pixels)).save(data, "JPEG", exif=note, quality=95, subsampling=0)
    return data.getvalue()


def open3d(folder, stored):
    """`stored`: bytes of the colour image of a frame, in the depth's pixels once it is turned."""
    (folder / "depth").mkdir(parents=True)
    (folder / "color").mkdir()
    fx, fy, ox, oy = LENS
    K = [fx, 0, 0, 0, fy, 0, ox - 0.5, oy - 0.5, 1]
    told = {"width": WIDTH, "height": HEIGHT, "intrinsic_matrix": K}
    (folder / "intrinsic.json").write_text(json.dumps(told))
    for i in range(FRAMES):
        write_png(folder / f"depth/{i:06d}.png", np.rint(1000 * scene(i)[0]).astype(np.uint16))
        (folder / f"color/{i:06d}.jpg").write_bytes(stored(i))
    return open_recording(folder)


def nerfstudio(folder, stored):
    (folder / "depth").mkdir(parents=True)
    frames = []
    for i, T in enumerate(rendered.cameras(FRAMES)):
        write_png(folder / f"depth/{i}.png", np.rint(1000 * scene(i)[0]).astype(np.uint16))
        (folder / f"{i}.jpg").write_bytes(stored(i))
        frames.append({"file_path": f"{i}.jpg", "depth_file_path": f"depth/{i}.png", "transform_matrix": T.tolist()})
    fx, fy, ox, oy = (TIMES * x for x in LENS)
    told = {"w": TIMES * WIDTH, "h": TIMES * HEIGHT, "fl_x": fx, "fl_y": fy, "cx": ox, "cy": oy, "frames": frames}
    (folder / "transforms.json").write_text(json.dumps(told))
    return open_recording(folder)


def polycam(path, stored, poses=None, lens=LENS, size=(WIDTH, HEIGHT)):
    poses = rendered.cameras(FRAMES) if poses is None else poses
    with zipfile.ZipFile(path, "w") as archive:
        for i, T in enumerate(poses):
            fx, fy, ox, oy = (TIMES * x for x in lens)
            camera = {f"t_{r}{c}": T[r, c] for r in range(3) for c in range(4)} | {"fx": fx, "fy": fy, "cx": ox}
            camera |= {"cy": oy, "width": TIMES * size[0], "height": TIMES * size[1]}
            name = f"keyframes/{{}}/{100_000 * (i + 1)}"
            archive.writestr(name.format("cameras") + ".json", json.dumps(camera))
            counts = np.rint(1000 * scene(i)[0]).astype(np.uint16)
            archive.writestr(name.format("depth") + ".png", cv2.imencode(".png", counts)[1].tobytes())
            archive.writestr(name.format("images") + ".jpg", stored(i))
    return open_recording(path)


def shown(recording, i):
    return recording.color_apart(i) if recording.color_is_apart else recording[i].color


def right(recording, times):
    """Colour lies where it should: JPEG changes little but at edges."""
    for i in range(FRAMES):
        color = shown(recording, i)
        assert color is not None and color.shape == (HEIGHT * times, WIDTH * times, 3)
        assert np.median(np.abs(color.astype(int) - picture(i, times))) <= 3
        assert (np.abs(color.astype(int) - picture(i, times)).max(axis=2) > 40).mean() < 0.05


WRITERS = [(open3d, 1), (nerfstudio, TIMES), (polycam, TIMES)]


@pytest.mark.parametrize("turn", [LEFT, RIGHT])
@pytest.mark.parametrize(("write", "times"), WRITERS)
def test_pictures_that_were_turned_by_hand(tmp_path, write, times, turn):
    recording = write(tmp_path / "a", lambda i: jpeg(np.rot90(picture(i, times), -turn)))
    right(recording, times)
    way = "left" if turn == LEFT else "right"
    assert any(f"turned by 90 degrees to the {way}" in one and "guess" in one for one in recording.warnings)
    assert any(f"to the {way}" in finding.seen for finding in inspect(recording).findings)


@pytest.mark.parametrize("turn", [LEFT, RIGHT])
@pytest.mark.parametrize(("write", "times"), WRITERS)
def test_notes_say_it_before_anything_is_guessed(tmp_path, write, times, turn):
    recording = write(tmp_path / "a", lambda i: jpeg(np.rot90(picture(i, times), -turn), NOTES[turn]))
    right(recording, times)
    assert any("EXIF" in one for one in recording.warnings) and not any("guess" in one for one in recording.warnings)


@pytest.mark.parametrize("orientation", [None, *NOTES.values()])
@pytest.mark.parametrize(("write", "times"), WRITERS)
def test_pictures_that_fit_stay(tmp_path, write, times, orientation):
    recording = write(tmp_path / "a", lambda i: jpeg(picture(i, times), orientation))
    right(recording, times)
    assert not any("turned" in one for one in recording.warnings)


@pytest.mark.parametrize(("write", "times"), WRITERS)
def test_what_is_not_clear_is_left_out_and_told(tmp_path, write, times):
    plain = np.random.default_rng(0).integers(0, 255, (WIDTH * times, HEIGHT * times, 3)).astype(np.uint8)
    recording = write(tmp_path / "a", lambda i: jpeg(plain))
    assert shown(recording, 0) is None and len(recording) == FRAMES
    assert any("which way is not clear" in one for one in recording.warnings)


def stands(turn):
    """The lens and the turn of the axes (4, 4; x right, y up) of pictures that were turned away from how depth lies."""
    fx, fy, ox, oy = LENS
    lens = (fy, fx, oy, WIDTH - ox) if turn == LEFT else (fy, fx, HEIGHT - oy, ox)
    T = np.eye(4)
    T[:2, :2] = np.array([[0, 1], [-1, 0]] if turn == LEFT else [[0, -1], [1, 0]])
    return lens, T


@pytest.mark.parametrize("whose", ["depth", "color"])
@pytest.mark.parametrize("turn", [LEFT, RIGHT])
def test_depth_that_lies_beside_a_camera_that_stands(tmp_path, turn, whose):
    lens, T = stands(turn)
    poses = rendered.cameras(FRAMES) @ (T if whose == "color" else np.eye(4))
    made = polycam(tmp_path / "a", lambda i: jpeg(np.rot90(picture(i), turn)), poses, lens, (HEIGHT, WIDTH))
    right(made, TIMES)
    assert made.camera.shape == (HEIGHT, WIDTH)
    assert np.allclose([made.camera.cx + 0.5, made.camera.cy + 0.5], LENS[2:])
    off = rendered.errors(made, [scene(i)[1] for i in range(FRAMES)])
    assert len(off) > 12 and np.abs(off).max() < 0.3e-3  # a millimetre's rounding, in medians
    assert any("guess" in one for one in made.warnings)
    assert any("before the turn" in one for one in made.warnings) == (whose == "color")


@pytest.mark.parametrize("turn", [LEFT, RIGHT])
def test_pictures_that_lie_and_notes_that_make_them_stand_as_their_camera(tmp_path, turn):
    lens, T = stands(turn)
    poses = rendered.cameras(FRAMES) @ T
    made = polycam(tmp_path / "a", lambda i: jpeg(picture(i), NOTES[turn]), poses, lens, (HEIGHT, WIDTH))
    right(made, TIMES)
    off = rendered.errors(made, [scene(i)[1] for i in range(FRAMES)])
    assert len(off) > 12 and np.abs(off).max() < 0.3e-3 and not any("guess" in one for one in made.warnings)


def test_a_camera_that_stands_beside_pictures_that_tell_nothing_is_refused(tmp_path):
    plain = np.full((WIDTH * TIMES, HEIGHT * TIMES, 3), 90, np.uint8)
    with pytest.raises(RecordingError, match=r"of other shapes.*pass --camera"):
        polycam(tmp_path / "a", lambda _: jpeg(plain), None, stands(LEFT)[0], (HEIGHT, WIDTH))


def test_colour_of_a_camera_beside_the_depth_camera():
    T = np.eye(4)
    T[:3, 3] = [-0.03, 0.004, 0.0]
    fx, fy, ox, oy = LENS
    near = Camera(WIDTH, HEIGHT, fx, fy, ox - 0.5, oy - 0.5)
    apart = Camera(WIDTH, HEIGHT, fx, fy, ox - 0.5, oy - 0.5, color=near, T_color_depth=T)
    moved = rendered.cameras(FRAMES)
    moved[:, :3, 3] += moved[:, :3, :3] @ [0.03, 0.004, 0.0]  # up and not down
    for turn in (LEFT, RIGHT):
        seen = [PAINT[rendered.depth(T_world, WIDTH, HEIGHT, *LENS)[1]] for T_world in moved]
        looks = [(scene(i)[0].astype(np.float32), np.rot90(seen[i], -turn)) for i in range(FRAMES)]
        assert fit_of(looks, apart).turn == turn
