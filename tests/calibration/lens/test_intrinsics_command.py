"""From pictures in a folder to camera.json and a report, and what is said when that cannot be."""

import json
from dataclasses import replace

import cv2
import numpy as np
import pytest
from rendered_boards import SIZE, TRUTH, picture

from fusion.calibration.lens.boards.board import Board
from fusion.calibration.lens.boards.pictures import find_pictures, thinned
from fusion.calibration.lens.intrinsics import calibrate_intrinsics
from fusion.commands.main import main
from fusion.errors import FusionError
from fusion.files.json_values import json_values
from fusion.geometry.camera import Camera
from fusion.recording.formats.bags.write import write_mcap
from fusion.recording.images.read import read_ir
from fusion.recording.native.camera_file import read_camera, write_camera
from fusion.recording.open import open_recording
from fusion.recording.recording import Frame
from fusion.recording.writing.write import write_recording

BOARD = Board(8, 5, 0.05)
# near, so that squares are large and quickly found; tilted in all directions
POSES = [
    np.array([a, b, c, -0.17 + dx, -0.1 + dy, z])
    for a, b, c, dx, dy, z in [
        (0.4, 0.0, 0.0, 0.0, 0.0, 0.55),
        (-0.4, 0.1, 0.1, 0.05, 0.02, 0.6),
        (0.1, 0.45, -0.1, -0.05, 0.0, 0.55),
        (0.0, -0.45, 0.0, 0.03, -0.02, 0.65),
        (0.3, 0.3, 0.2, 0.08, -0.06, 0.6),
        (-0.3, -0.3, -0.2, -0.06, 0.06, 0.65),
    ]
]

pytestmark = pytest.mark.slow  # whole calibrations from rendered pictures


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Six pictures of the board, one blank, one damaged, one of another size, and a depth picture to be left alone."""
    path = tmp_path_factory.mktemp("boards")
    for i, pose in enumerate(POSES):
        cv2.imwrite(str(path / f"{i:02d}_ir.png"), picture(BOARD, pose, seed=i))
    cv2.imwrite(str(path / "06_ir.png"), np.zeros(SIZE[::-1], np.uint16))
    cv2.imwrite(str(path / "07_ir.png"), np.zeros((50, 60), np.uint16))
    (path / "08_ir.png").write_bytes((path / "00_ir.png").read_bytes()[:5000])
    cv2.imwrite(str(path / "00_depth.png"), np.ones(SIZE[::-1], np.uint16))
    return path


@pytest.fixture(scope="module")
def both(tmp_path_factory):
    """The same boards seen by a second camera 52 mm to the right."""
    path = tmp_path_factory.mktemp("both")
    for i, pose in enumerate(POSES):
        beside = pose - [0, 0, 0, 0.052, 0, 0]
        cv2.imwrite(str(path / f"{i:02d}_ir.png"), picture(BOARD, pose, seed=i))
        grey = (picture(BOARD, beside, seed=100 + i) // 80).astype(np.uint8)
        cv2.imwrite(str(path / f"{i:02d}_color.png"), np.dstack([grey] * 3))
    return path


def board_file(tmp_path, **change):
    path = tmp_path / "board.json"
    path.write_text(json.dumps(json_values(BOARD.file()) | change))
    return path


def test_a_folder_becomes_a_camera_and_a_report(folder, tmp_path, capsys):
    out = tmp_path / "out"
    arguments = ["calibrate", "intrinsics", str(folder), "--board", str(board_file(tmp_path)), "-o", str(out), "--json"]
    assert main(arguments) == 0
    told = json.loads(capsys.readouterr().out)
    fit = told["cameras"]["ir"]
    assert fit["found"] == 6
    assert fit["missed"] == ["06"]
    assert set(fit["unread"]) == {"07", "08"}
    camera = read_camera(out / "camera.json")
    assert (camera.width, camera.height) == SIZE
    for name, true in zip(("fx", "fy", "cx", "cy"), TRUTH, strict=False):
        # six views: 5 standard deviations, because these are themselves uncertain to a third
        assert abs(getattr(camera, name) - true) < 5 * camera.std[name]
        assert camera.std[name] < 5
    assert np.array(fit["correlation"]["matrix"]).shape == (9, 9)
    assert fit["uncertainty"]["distance_m"] == pytest.approx(0.6, abs=0.1)
    page = (out / "report.html").read_text(encoding="utf-8")
    assert "Traceback" not in page
    for part in ("IR camera", "corners", "correlation", "Rays are known"):
        assert part in page


def test_pictures_that_cannot_be_used_are_named(folder, tmp_path, capsys):
    arguments = ["calibrate", "intrinsics", str(folder), "--board", str(board_file(tmp_path)), "--no-report"]
    assert main([*arguments, "-o", str(tmp_path / "out")]) == 0
    printed = capsys.readouterr().out
    assert "2 pictures could not be used, the first 0" in printed


def test_two_cameras_are_placed_beside_each_other(both, tmp_path):
    result = calibrate_intrinsics(both, BOARD)
    assert result.pair is not None
    write_camera(tmp_path / "camera.json", result.camera)
    camera = read_camera(tmp_path / "camera.json")
    assert camera.color is not None
    # six views: the principal points are known to a few pixels, which is a few millimetres at 0.6 m
    np.testing.assert_allclose(camera.T_color_depth[:3, 3], [-0.052, 0, 0], atol=0.006)
    assert result.pair.rms_px < 0.3


def test_squares_of_another_size_than_the_depth_tells_are_warned_of(folder, tmp_path):
    camera = Camera(*SIZE, *TRUTH[:4], tuple(TRUTH[4:]))
    ir = [read_ir(path) for path in sorted(folder.glob("0[0-5]_ir.png"))]
    frames = [
        Frame(i, float(i), depth_of(pose), ir=image) for i, (pose, image) in enumerate(zip(POSES, ir, strict=True))
    ]
    write_recording(tmp_path / "rec", camera, frames)
    (warning,) = calibrate_intrinsics(tmp_path / "rec", replace(BOARD, square_m=0.04)).warnings
    assert "square_m" in warning
    assert "1.25" in warning


def depth_of(pose):
    """Depth [m] of the board's plane, everywhere: the corners are all on it."""
    R, _ = cv2.Rodrigues(pose[:3])
    rays = Camera(*SIZE, *TRUTH[:4], tuple(TRUTH[4:])).rays().astype(float)
    return (R[:, 2] @ pose[3:]) / (rays @ R[:2, 2] + R[2, 2])


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"columns": 6, "rows": 4}, "8 x 5 inner corners"),
        ({"square_m": 50}, "millimetres"),
        ({"columns": 1}, "from 3 to 60 (INNER"),
    ],
)
def test_a_wrong_board_is_told_in_one_line(folder, tmp_path, capsys, change, said):
    out = tmp_path / "out"
    board = board_file(tmp_path, **change)
    assert main(["calibrate", "intrinsics", str(folder), "--board", str(board), "-o", str(out), "-q"]) == 1
    told = capsys.readouterr().err
    assert said in told
    assert told.count("\n") == 1
    assert not out.exists()


def test_blank_pictures_are_told_in_one_line(tmp_path, capsys):
    (tmp_path / "pictures").mkdir()
    for i in range(3):
        cv2.imwrite(str(tmp_path / "pictures" / f"{i}.png"), np.full((100, 120), 7, np.uint8))
    arguments = [
        "calibrate",
        "intrinsics",
        str(tmp_path / "pictures"),
        "--board",
        str(board_file(tmp_path)),
        "-o",
        str(tmp_path / "o"),
    ]
    assert main(arguments) == 1
    told = capsys.readouterr().err
    assert "found 0 of 3 pictures that show it" in told
    assert told.count("\n") == 1


@pytest.mark.parametrize("text", ["", "[]", '{"columns": 9}', '{"columns": 9, "rows": 6, "square_m": 1e999}'])
def test_a_broken_board_file_is_told_in_one_line(folder, tmp_path, capsys, text):
    (tmp_path / "board.json").write_text(text)
    arguments = [
        "calibrate",
        "intrinsics",
        str(folder),
        "--board",
        str(tmp_path / "board.json"),
        "-o",
        str(tmp_path / "o"),
    ]
    assert main(arguments) == 1
    assert capsys.readouterr().err.count("\n") == 1


def test_pictures_are_told_apart_by_their_names(tmp_path):
    for name in ("0001_ir.png", "0001_color.png", "0001_depth.png", "0001_grey_ir.png", "ir-2.png", "color-2.jpg"):
        (tmp_path / name).write_bytes(b"")
    pictures = find_pictures(tmp_path)
    assert {key: path.name for key, path in pictures.ir.items()} == {"0001": "0001_ir.png", "2": "ir-2.png"}
    assert {key: path.name for key, path in pictures.color.items()} == {"0001": "0001_color.png", "2": "color-2.jpg"}


def test_a_recording_is_read_by_its_lists_and_pairs_by_time(tmp_path):
    (tmp_path / "ir.txt").write_text("1.0 ir/a.png\n2.0 ir/b.png\n")
    (tmp_path / "rgb.txt").write_text("1.005 rgb/a.png\n2.5 rgb/b.png\n")
    pictures = find_pictures(tmp_path)
    assert list(pictures.ir) == ["1.000000", "2.000000"]
    assert list(pictures.color) == ["1.000000", "2.500000 (color)"]


def test_long_recordings_are_thinned_evenly(tmp_path):
    many = {str(i): tmp_path / str(i) for i in range(5000)}
    some = list(thinned(many, 200))
    assert len(some) == 200
    assert (some[0], some[-1]) == ("0", "4999")


def test_no_pictures_is_told(tmp_path):
    with pytest.raises(FusionError, match="no pictures"):
        find_pictures(tmp_path)
    with pytest.raises(FusionError, match="no pictures"):
        find_pictures(tmp_path / "none")


def test_pictures_of_a_file_give_the_camera_that_those_of_a_folder_give(folder, tmp_path):
    """A bag's infrared as it is; its own camera, which a driver may have stated wrongly, is not used."""
    ir = [read_ir(path) for path in sorted(folder.glob("0[0-5]_ir.png"))]
    frames = [Frame(i, i / 10, np.ones(SIZE[::-1], np.float32), ir=image) for i, image in enumerate(ir)]
    write_recording(tmp_path / "rec", Camera(*SIZE, 300.0, 300.0, 250.0, 200.0), frames)
    write_mcap(tmp_path / "rec.mcap", open_recording(tmp_path / "rec"))
    found = find_pictures(tmp_path / "rec.mcap")
    assert len(found.ir) == 6 and not found.color
    one, other = (calibrate_intrinsics(tmp_path / name, BOARD).camera for name in ("rec", "rec.mcap"))
    np.testing.assert_array_equal(one.parameters, other.parameters)


CHARUCO = {"columns": 8, "rows": 5, "square_m": 0.04, "marker_m": 0.03, "dictionary": "DICT_5X5_100"}


@pytest.mark.parametrize("missing", ["marker_m", "dictionary"])
def test_a_charuco_board_without_its_keys_is_told_them(tmp_path, capsys, missing):
    pictures, board = tmp_path / "pictures", tmp_path / "board.json"
    pictures.mkdir()
    board.write_text(json.dumps({k: v for k, v in CHARUCO.items() if k != missing}))
    out = str(tmp_path / "out")
    assert main(["calibrate", "intrinsics", str(pictures), "--board", str(board), "-o", out]) == 1
    told = capsys.readouterr().err
    assert told.count("\n") == 1
    assert f'"{missing}" of the board cannot be used' in told
    assert 'a ChArUco board has "marker_m" [m] and "dictionary"' in told


def test_a_charuco_board_that_is_not_in_the_pictures_is_one_line(tmp_path, capsys):
    """NumPy warned of an empty mean; pytest makes an error of that."""
    (tmp_path / "pictures").mkdir()
    grey = np.random.default_rng(1).integers(0, 255, (240, 320), np.uint8)
    for k in range(4):
        cv2.imwrite(str(tmp_path / "pictures" / f"{k}.png"), grey)
    (tmp_path / "board.json").write_text(json.dumps(CHARUCO))
    arguments = ["--board", str(tmp_path / "board.json"), "-o", str(tmp_path / "out")]
    assert main(["calibrate", "intrinsics", str(tmp_path / "pictures"), *arguments]) == 1
    told = capsys.readouterr().err
    assert told.count("\n") == 1
    assert "hardly seen" in told
    assert "DICT_5X5_100" in told
    assert "check columns and rows (inner corners), dictionary and marker_m" in told


def test_pictures_of_no_board_are_told_as_such(tmp_path, capsys):
    (tmp_path / "pictures").mkdir()
    rng = np.random.default_rng(0)
    for k in range(4):
        room = cv2.GaussianBlur(rng.normal(size=(240, 320)), (0, 0), 3.0)
        cv2.imwrite(str(tmp_path / "pictures" / f"{k}_ir.png"), np.clip(600 * room + 128, 0, 255).astype(np.uint8))
    arguments = ["--board", str(board_file(tmp_path)), "-o", str(tmp_path / "out")]
    assert main(["calibrate", "intrinsics", str(tmp_path / "pictures"), *arguments]) == 1
    told = capsys.readouterr().err
    assert "no board is seen" in told and "0 of 4 pictures" in told and "another board" not in told


def test_help_says_what_a_charuco_board_has(capsys):
    with pytest.raises(SystemExit):
        main(["calibrate", "intrinsics", "--help"])
    told = " ".join(capsys.readouterr().out.split())
    assert '"marker_m": 0.022' in told
    assert '"dictionary": "DICT_5X5_100"' in told
