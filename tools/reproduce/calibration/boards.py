"""Figures of the camera calibration: real boards of a Kinect v2, detectors against each other, challenges with truth.

python -m tools.reproduce.calibration.boards [--shared ../shared] [--detectors]
"""

import argparse
import json
import re
import time
from pathlib import Path

import cv2
import numpy as np

from fusion.calibration.lens.boards.board import Board, read_board
from fusion.calibration.lens.boards.charuco import find_charuco
from fusion.calibration.lens.boards.detect import ATTEMPTS, DetectorTry, find_checkerboard
from fusion.calibration.lens.boards.grid import upright
from fusion.calibration.lens.boards.pictures import read_picture
from fusion.calibration.lens.fit.solve import NAMES, matrix
from fusion.calibration.lens.intrinsics import CameraFit, LensSettings, calibrate_intrinsics, fit_camera
from fusion.calibration.lens.views import BoardView, view_of
from tools.reproduce.calibration.photogrammetric import PhotogrammetricCamera, to_opencv, to_photogrammetric

KINECT = "data/kinect_v2_checkerboard"
KINECT_BOARD, KINECT_SIZE = Board(5, 7, 0.03), (512, 424)
# the author found corners in pictures of twice the size and halved them: 2 u + 0.5 becomes u + 0.25
AUTHOR_SHIFT = 0.25
BAD = {"0010", "0011", "0079", "0080"}
BEYOND_TRUTH = 6  # grid rows and columns of the comparison with a true camera
PAGLIARI = {
    "rgb": PhotogrammetricCamera(
        640, 480, (3.58, 2.87), 3.099, (-0.040, -0.020), (-1.366e-3, 7.857e-4, 0.0), (-1.518e-4, -9.514e-4)
    ),
    "ir": PhotogrammetricCamera(
        640, 480, (6.66, 5.32), 6.497, (-0.005, -0.004), (1.795e-3, -8.337e-5, 0.0), (-1.835e-4, 2.538e-4)
    ),
}


def author_corners(path: Path) -> np.ndarray:
    """(35, 2) corners [px] of an author's list, as written."""
    text = re.search(r"\[(.*)\]", path.read_text(encoding="utf-8"), re.S)
    return np.array([float(x) for x in text.group(1).split(",")]).reshape(-1, 2) if text else np.zeros((0, 2))


def author_views(folder: Path, pictures_only: bool) -> list[BoardView]:
    """The author's lists: of the 102 single pictures, or of the 55 whose pictures are here."""
    lists = sorted(folder.glob("*_ir_points.yaml"))
    if pictures_only:
        lists = [p for p in lists if (folder / p.name.replace("_points.yaml", ".png")).is_file()]
    else:
        lists = [p for p in lists if "sync" not in p.name]
    names = [p.name.removesuffix("_ir_points.yaml") for p in lists]
    return [view_of(n, author_corners(p) - AUTHOR_SHIFT, KINECT_BOARD) for n, p in zip(names, lists, strict=True)]


def own_corners(folder: Path, attempts: tuple[DetectorTry, ...] = ATTEMPTS) -> dict[str, np.ndarray]:
    """Name to corners (35, 2) [px] found in the pictures."""
    found = {}
    for path in sorted(folder.glob("*_ir.png")):
        board = find_checkerboard(read_picture(path), KINECT_BOARD, attempts)
        if board is not None:
            found[path.name.removesuffix("_ir.png")] = board.pixels
    return found


def against_author(folder: Path, own: dict[str, np.ndarray]) -> dict:
    """Share found, and distance [px rms] from the author's corners once his quarter pixel is taken out."""
    author = {view.name: upright(view.pixels, KINECT_BOARD) for view in author_views(folder, True)}
    off = {name: own[name] - author[name] for name in own}
    per_view = {name: float(np.sqrt((d**2).sum(axis=1).mean())) for name, d in off.items()}
    worst = sorted(per_view, key=lambda name: -per_view[name])[:3]
    every = np.concatenate(list(off.values()))
    return {
        "pictures": len(author),
        "found": len(own),
        "rms_px": float(np.sqrt((every**2).sum(axis=1).mean())),
        "median_view_px": float(np.median(list(per_view.values()))),
        "shift_px": (every.mean(axis=0) + AUTHOR_SHIFT).tolist(),
        "worst_views": {name: per_view[name] for name in worst},
    }


def fitted(fit: CameraFit) -> dict:
    """The numbers of a fit that are worth a line."""
    return {
        "views": len(fit.judged.views),
        "rms_px": fit.judged.solution.rms,
        "parameters": dict(zip(NAMES, fit.judged.solution.parameters.round(5).tolist(), strict=True)),
        "std": dict(zip(NAMES, fit.spread.std.round(5).tolist(), strict=True)),
        "k3_held": fit.k3_held,
        "outliers": {o.name: o.reason for o in fit.judged.outliers},
        "corners_left_out": fit.judged.wild,
        "row_pitch": fit.shape.pitch,
        "bow_m": fit.shape.bow,
        "uncertainty": {key: round(value, 4) for key, value in fit.uncertainty.numbers().items()},
    }


def kinect(shared: Path) -> dict:
    """The real board: corners, reprojection, outliers named, two sets of views against each other."""
    folder = shared / KINECT
    start = time.perf_counter()
    own = own_corners(folder)
    seconds = time.perf_counter() - start
    ours = fit_camera([view_of(name, pixels, KINECT_BOARD) for name, pixels in own.items()], KINECT_SIZE)
    with_all = LensSettings(keep_outliers=True)
    ours_all = fit_camera([view_of(n, p, KINECT_BOARD) for n, p in own.items()], KINECT_SIZE, with_all)
    listed = fit_camera(author_views(folder, False), KINECT_SIZE)
    author55 = fit_camera(author_views(folder, True), KINECT_SIZE)
    return {
        "corners": against_author(folder, own) | {"seconds": seconds},
        "own_55": fitted(ours) | {"rms_px_with_every_corner": ours_all.judged.solution.rms},
        "author_55": fitted(author55),
        "author_102": fitted(listed),
        "named_are_the_bad_ones": {o.name for o in listed.judged.outliers} == BAD,
        "102_minus_55_in_combined_sigma": combined(listed, author55),
        "102_minus_own_55_in_combined_sigma": combined(listed, ours),
    }


def combined(one: CameraFit, other: CameraFit) -> dict:
    """Difference of fx, fy, cx, cy over the root sum of both squared standard deviations."""
    difference = one.judged.solution.parameters - other.judged.solution.parameters
    sigmas = difference / np.hypot(one.spread.std, other.spread.std)
    return dict(zip(NAMES[:4], sigmas[:4].round(2).tolist(), strict=True))


def detectors(shared: Path) -> dict:
    """Each way of looking alone: boards found, time, distance from the author, reprojection."""
    out = {}
    for attempt in (*ATTEMPTS, DetectorTry("sectors", 2)):
        start = time.perf_counter()
        own = own_corners(shared / KINECT, (attempt,))
        seconds = time.perf_counter() - start
        fit = fit_camera([view_of(n, p, KINECT_BOARD) for n, p in own.items()], KINECT_SIZE)
        close = against_author(shared / KINECT, own)
        out[attempt.name] = {
            "found": len(own),
            "seconds": seconds,
            "rms_px": close["rms_px"],
            "reprojection_px": fit.judged.solution.rms,
        }
    return out


def challenge(shared: Path, name: str) -> dict:
    """A simulated recording with known truth."""
    case = shared / "challenges/turntable" / name
    start = time.perf_counter()
    fit = calibrate_intrinsics(case / "board", read_board(case / "board.json")).fits["ir"]
    seconds = time.perf_counter() - start
    camera = json.loads((shared / "challenges/turntable_truth" / name / "truth.json").read_text())["camera"]
    truth = np.array([*(camera[key] for key in NAMES[:4]), *camera["distortion"]])
    z = (fit.judged.solution.parameters - truth) / fit.spread.std
    return fitted(fit) | {
        "truth": dict(zip(NAMES, truth.round(5).tolist(), strict=True)),
        "z": dict(zip(NAMES, z.round(2).tolist(), strict=True)),
        "true_error_px_rms": true_error(fit, truth),
        "seconds": seconds,
    }


def true_error(fit: CameraFit, truth: np.ndarray) -> float:
    """Root mean square over the picture of where true rays are seen, a turn of the camera taken out [px]."""
    rays = fit.camera.rays()[::BEYOND_TRUTH, ::BEYOND_TRUTH].reshape(-1, 2).astype(float)
    rays = np.hstack([rays, np.ones((len(rays), 1))])
    seen, J = cv2.projectPoints(rays, np.zeros(3), np.zeros(3), matrix(truth), truth[4:])
    off = (seen.reshape(-1, 2) - fit.camera.project(rays)).ravel()
    left = off - J[:, :3] @ np.linalg.lstsq(J[:, :3], off, rcond=None)[0]
    return float(np.sqrt((left.reshape(-1, 2) ** 2).sum(axis=1).mean()))


def pagliari() -> dict:
    """Table 1 to OpenCV's form and back."""
    out = {}
    for name, camera in PAGLIARI.items():
        there, gap = to_opencv(camera)
        back, _ = to_photogrammetric(there, camera.format_mm)
        pairs = zip([*camera.K[:2], *camera.P, camera.focal_mm], [*back.K[:2], *back.P, back.focal_mm], strict=True)
        v, u = np.mgrid[0 : camera.height : 4, 0 : camera.width : 4]
        pixels = np.stack([u.ravel(), v.ravel()], axis=1).astype(float)
        tangents = camera.tangents(pixels)
        off = np.linalg.norm(there.project(np.hstack([tangents, np.ones((len(pixels), 1))])) - pixels, axis=1)
        out[name] = {
            "there_and_back_relative": max(abs(b / a - 1) for a, b in pairs),
            "own_forward_form_px": float(np.abs(camera.pixels(tangents) - pixels).max()),
            "opencv_rms_px": float(np.sqrt((off**2).mean())),
            "opencv_worst_px": gap,
            "opencv": [there.fx, there.fy, there.cx, there.cy, *there.distortion[:5]],
        }
    return out


def azure(shared: Path) -> dict:
    """ChArUco corners of an Azure Kinect, against the published camera: reprojection with only the pose free."""
    folder = shared / "data/azure_kinect_charuco"
    board = Board(13, 8, 0.04, 0.03, "DICT_5X5_250")
    out: dict[str, dict] = {}
    for name in ("ir-0.png", "color-0.jpg", "color-4.jpg"):
        calib = f"calib_{name.split('-')[0]}.yml"
        numbers = cv2.FileStorage(str(folder / calib), cv2.FILE_STORAGE_READ)
        K, lens = numbers.getNode("K").mat(), numbers.getNode("dist").mat()
        found = find_charuco(read_picture(folder / name), board)
        if found is None or K is None:
            out[name] = {"corners": 0}
            continue
        points = board.points()[found.ids]
        _, turn, shift = cv2.solvePnP(points, found.pixels, K, lens)
        seen, _ = cv2.projectPoints(points, turn, shift, K, lens)
        rms = float(np.sqrt(((seen.reshape(-1, 2) - found.pixels) ** 2).sum(axis=1).mean()))
        out[name] = {"corners": len(found.ids), "of": board.corners, "rms_px": rms, "how": found.how}
    return out


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--shared", type=Path, default=Path("../shared"))
    parser.add_argument("--detectors", action="store_true", help="compare the detectors one by one (minutes)")
    options = parser.parse_args()
    result = {
        "kinect_v2_checkerboard": kinect(options.shared),
        "pagliari_table_1": pagliari(),
        "azure_kinect_charuco": azure(options.shared),
    }
    for name in ("turntable_v1_statue", "turntable_v2_bricks"):
        result[name] = challenge(options.shared, name)
    if options.detectors:
        result["detectors"] = detectors(options.shared)
    print(json.dumps(result, indent=1, default=float))


if __name__ == "__main__":
    main()
