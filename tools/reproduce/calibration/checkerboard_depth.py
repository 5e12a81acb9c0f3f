"""Depth of the real Kinect v2 checkerboard recording, calibrated with the public commands and held out by views.

    python -m tools.reproduce.calibration.checkerboard_depth [--shared ../shared] [--folds 11] [--output DIR]

The 55 pairs of IR and depth become a recording, `fusion calibrate intrinsics` makes its camera, and `fusion calibrate
depth --board` its law. Then the views are left out in turns: the law is CHOSEN and fitted on the others, and the
corrected depth of those left out (median of 3 x 3 px at each of the 24 squares' centres) is held against the board's
pose. The yardstick is a straight line over the distance, fitted to the same other views; what is asked for counts what
it leaves of the MEASURED depth. A law is undone, and undoing a scale of -2 % makes what is left 2 % larger: line_undone
is the line as a correction, like for like.

Dark squares of this board mirror a chair in some views. The share of light that they mirror is ONE number, fitted with
the law on the other views; what it does to a view follows from that view's picture of everything but the board.
law_and_gloss undoes both, law the camera's law alone, as any other object would have it. With --output the recording,
camera.json, sensor.json and both reports are kept.

What this cannot tell: the printed size of the squares (30 mm is nominal), so a scale of all distances; how flat the
board is.
"""

import argparse
import contextlib
import json
import os
import sys
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from fusion.calibration.depth.calibration import DepthSettings, calibrate_walls, walls_of
from fusion.calibration.depth.known import start
from fusion.calibration.depth.walls.board_patches import projected, square_centres
from fusion.calibration.depth.walls.board_walls import middle_of_nine, seen_board
from fusion.calibration.depth.walls.wall import Wall
from fusion.calibration.lens.boards.board import Board, read_board
from fusion.calibration.lens.boards.pictures import read_picture
from fusion.commands.main import main as fusion
from fusion.files.json_values import json_text
from fusion.geometry.camera import Camera
from fusion.recording.cameras.presets import PRESETS
from fusion.recording.native.camera_file import read_camera
from fusion.recording.open import open_recording
from fusion.recording.recording import Frame
from fusion.recording.writing.write import write_recording
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import View, stretch

SOURCE = "data/kinect_v2_checkerboard"
BOARD = Board(5, 7, 0.03)
# libfreenect2 makes depth along the rays of the unit's factory values; this unit's are not told, so another's stand in
STATED = replace(PRESETS["kinect-v2"][0], distortion=(0.0905474, -0.26819, 0.0, 0.0, 0.0950862))
ASKED = 0.85  # of the held-out error of a line
LAWS = ("law", "law_and_gloss")
LOST = 0.1  # [m] from the median: a lost phase, dropped as the recording's notes do


@dataclass(frozen=True)
class Squares:
    """Squares' centres of all views (n): view, pixel, the board's depth [m], measured less board [m], amplitude."""

    view: NDArray[np.intp]
    pixel: NDArray[np.intp]
    depth: NDArray[np.floating]
    error: NDArray[np.floating]
    ir: NDArray[np.floating]
    dark: NDArray[np.bool_]


def write_pairs(source: Path, folder: Path) -> list[str]:
    """The pairs of IR and depth as a recording, one second apart; the names of the views in its order."""
    names = sorted(p.name.removesuffix("_depth.png") for p in source.glob("*_depth.png"))

    def frames() -> Any:
        for i, name in enumerate(names):
            depth = read_picture(source / f"{name}_depth.png").astype(np.float32) / 1000
            yield Frame(i, float(i), np.where(depth > 0, depth, np.nan), ir=read_picture(source / f"{name}_ir.png"))

    write_recording(folder / "recording", STATED, frames())
    (folder / "board.json").write_text(json_text(BOARD.file()) + "\n")
    return names


def squares(folder: Path, camera: Camera) -> Squares:
    """What the recording says at every square's centre, before any correction."""
    recording, board = open_recording(folder / "recording"), read_board(folder / "board.json")
    rows = []
    centres = square_centres(board)
    parity = np.indices((board.rows - 1, board.columns - 1)).sum(axis=0).ravel() % 2
    for frame in tqdm(recording, desc="boards", disable=None):
        seen = seen_board(frame, camera, board)
        if seen is None:
            continue
        pose = seen.pose
        depth = (centres @ cv2.Rodrigues(pose[:3])[0].T + pose[3:])[:, 2]
        found = []
        assert frame.ir is not None  # seen_board found the board in it
        seen_depth, seen_ir = middle_of_nine(frame.depth), middle_of_nine(frame.ir)
        for (u, v), z in zip(np.rint(projected(centres, pose, camera)).astype(int), depth, strict=True):
            found.append((frame.index, u, v, z, seen_depth[v, u] - z, seen_ir[v, u]))
        bright = [np.median([f[5] for f, p in zip(found, parity, strict=True) if p == side]) for side in (0, 1)]
        rows += [(*f, p == int(np.argmin(bright))) for f, p in zip(found, parity, strict=True)]
    view, u, v, z, error, ir, dark = np.array(rows, float).T
    keep = np.abs(error - np.nanmedian(error)) < LOST
    pixel = np.column_stack([u, v]).astype(np.intp)[keep]
    return Squares(view[keep].astype(np.intp), pixel, z[keep], error[keep], ir[keep], dark[keep] > 0)


def corrected(
    folder: Path, camera: Camera, sensor: Sensor, at: Squares, mirrors: dict[int, NDArray[np.floating]]
) -> NDArray:
    """Errors (n,) [m] at the squares of some views, NaN elsewhere, after the correction of the whole images.

    `mirrors`: per view what its board mirrors, (h, w) change of the range [m].
    """
    recording, left = open_recording(folder / "recording"), np.full(len(at.error), np.nan)
    for index, mirror in mirrors.items():
        frame = recording[index]
        depth = middle_of_nine(frame.depth) - mirror / stretch(camera)
        assert frame.ir is not None  # every pair has one
        true = sensor.correct(depth, View(camera, depth, ir=middle_of_nine(frame.ir)))
        mine = at.view == index
        left[mine] = true[at.pixel[mine, 1], at.pixel[mine, 0]] - at.depth[mine]
    return left


def held_out(
    folder: Path, camera: Camera, at: Squares, folds: int
) -> tuple[dict[str, NDArray], list[str], list[float]]:
    """Errors (n,) [m] of views left out, by what was fitted to the others; per fold the law's name and the gloss."""
    recording = open_recording(folder / "recording")
    begin = start([recording], camera, None)
    settings = DepthSettings(camera, board=read_board(folder / "board.json"))
    walls = walls_of(recording, begin, settings)
    number = np.array([round(float(wall.name.rsplit("/")[-1])) for wall in walls])
    turn = np.random.default_rng(0).permutation(number) % folds if folds < len(number) else np.arange(len(number))
    left = {name: np.full(len(at.error), np.nan) for name in ("constant", "line", "line_undone", *LAWS)}
    laws, shares = [], []
    for fold in tqdm(range(int(np.max(turn)) + 1), desc="folds", disable=None):
        out, use = number[turn == fold], np.isin(at.view, number[turn != fold])
        found = calibrate_walls([w for w, t in zip(walls, turn, strict=True) if t != fold], begin, surface=False)
        laws.append(found.best.candidate.name)
        mine = np.isin(at.view, out)
        for name, values in straight(at, use).items():
            left[name][mine] = values[mine]
        shares.append(found.fitted.numbers.value.get("gloss", 0.0))
        for name, share in zip(LAWS, (0.0, shares[-1]), strict=True):
            mirrors = {int(n): share * _gloss(wall) for n, wall in zip(number, walls, strict=True) if n in out}
            left[name][mine] = corrected(folder, camera, found.sensor, at, mirrors)[mine]
    return left, laws, shares


def _gloss(wall: Wall) -> NDArray[np.floating]:
    return np.zeros(wall.mask.shape) if wall.gloss is None else wall.gloss


def straight(at: Squares, use: NDArray[np.bool_]) -> dict[str, NDArray]:
    """Errors (n,) [m] after a constant and a line fitted where `use`, and after the line is undone like a law."""
    left = {}
    for degree, name in enumerate(("constant", "line")):
        fit = np.polyfit(at.depth[use], at.error[use], degree)
        left[name] = at.error - np.polyval(fit, at.depth)
    # measured = depth + slope depth + offset, so depth = (measured - offset) / (1 + slope)
    return left | {"line_undone": left["line"] / (1 + fit[0])}


def share_of(at: Squares, law: NDArray, line: NDArray) -> tuple[float, float]:
    """Errors of a law over those of a line, rms, and the standard deviation of that over views (jackknife)."""
    views = np.unique(at.view)
    sums = np.array([[np.nansum(values[at.view == v] ** 2) for values in (law, line)] for v in views])
    without = np.sqrt(np.divide(*(sums.sum(axis=0) - sums).T))
    spread = np.sqrt((len(views) - 1) * np.mean((without - without.mean()) ** 2))
    return rms(law) / rms(line), float(spread)


def rms(values: NDArray) -> float:
    """Root mean square of what is known."""
    return float(np.sqrt(np.nanmean(values**2)))


def figures(at: Squares, left: dict[str, NDArray], laws: list[str], gloss: list[float]) -> dict[str, Any]:
    """The numbers asked for, and what they hide: dark and bright squares, far and near, the worst views."""
    share, deviation = share_of(at, left["law_and_gloss"], left["line"])
    far = at.depth > 1
    per_view = {int(v): rms(left["law_and_gloss"][at.view == v]) for v in np.unique(at.view)}
    worst = sorted(per_view, key=lambda v: -per_view[v])[:4]
    ordinary = ~np.isin(at.view, worst)
    return {
        "points": len(at.error),
        "missing_after_correction": int(np.isnan(left["law"]).sum()),
        "in_sample_constant_mm": 1e3 * float(np.std(at.error)),
        "in_sample_line_mm": 1e3 * rms(at.error - np.polyval(np.polyfit(at.depth, at.error, 1), at.depth)),
        **{f"held_out_{name}_mm": 1e3 * rms(values) for name, values in left.items()},
        "share_of_line": share,
        "share_of_line_std": deviation,
        "share_of_line_undone": share_of(at, left["law_and_gloss"], left["line_undone"])[0],
        "share_of_line_law_alone": share_of(at, left["law"], left["line"])[0],
        "share_mirrored_by_the_board": [min(gloss), max(gloss)],
        "asked": ASKED,
        "reached": bool(share <= ASKED),
        "verdict": verdict(share, share_of(at, left["law"], left["line"])[0]),
        "dark_squares_mm": {name: 1e3 * rms(values[at.dark]) for name, values in left.items()},
        "bright_squares_mm": {name: 1e3 * rms(values[~at.dark]) for name, values in left.items()},
        "without_the_four_worst_views_mm": {name: 1e3 * rms(values[ordinary]) for name, values in left.items()},
        "dark_less_bright_beyond_1_m_mm": 1e3 * contrast(at, at.error, far),
        "the_same_after_correction_mm": 1e3 * contrast(at, left["law_and_gloss"], far),
        "laws_chosen": {law: laws.count(law) for law in sorted(set(laws))},
    }


def verdict(share: float, alone: float) -> str:
    """The figure in words, with what it cannot tell."""
    reached = "reached" if share <= ASKED else "NOT reached"
    said = f"{share:.3f} of the line's held-out error, {ASKED} asked: {reached} by the law and what the board mirrors; "
    said += f"the law alone leaves {alone:.3f}. Not known: the printed size of the squares (a scale of all distances) "
    return said + "and how flat the board is"


def contrast(at: Squares, error: NDArray, which: NDArray[np.bool_]) -> float:
    """By how much dark squares read farther than the bright ones of the same view [m], mean over views."""
    found = []
    for v in np.unique(at.view[which]):
        mine = at.view == v
        found.append(np.nanmean(error[mine & at.dark]) - np.nanmean(error[mine & ~at.dark]))
    return float(np.mean(found))


def measure(shared: Path, folder: Path, folds: int) -> dict[str, Any]:
    """The whole chain in a folder; the public commands first."""
    write_pairs(shared / SOURCE, folder)
    recording, board = str(folder / "recording"), str(folder / "board.json")
    lens, depth = str(folder / "lens"), str(folder / "depth")
    camera_file = str(folder / "lens" / "camera.json")
    with contextlib.redirect_stdout(sys.stderr):
        failed = fusion(["calibrate", "intrinsics", recording, "--board", board, "-o", lens, "--overwrite"]) or fusion(
            ["calibrate", "depth", recording, "--board", board, "--camera", camera_file, "-o", depth, "--overwrite"]
        )
    if failed:
        sys.exit(int(failed))
    camera = read_camera(Path(camera_file))
    at = squares(folder, camera)
    return figures(at, *held_out(folder, camera, at, folds))


def main() -> int:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--shared", type=Path, default=Path(os.environ.get("FUSION_SHARED", "../shared")))
    parser.add_argument("--folds", type=int, default=11, help="55 leaves single views out")
    parser.add_argument("--output", type=Path)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = options.output or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        found = measure(options.shared, folder, options.folds)
    print(json.dumps(found, indent=1))
    return 0 if found["reached"] else 1


if __name__ == "__main__":
    sys.exit(main())
