"""`fusion calibrate intrinsics`: a camera from pictures of a checkerboard or ChArUco board."""

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from fusion.commands.options.numbers import number
from fusion.commands.options.results import add_output, add_topic
from fusion.files.json_values import json_text
from fusion.progress import stage
from fusion.quantity import WORKING_DISTANCE

if TYPE_CHECKING:
    from fusion.calibration.lens.intrinsics import Intrinsics
    from fusion.calibration.lens.write import CalibrationFigures

EXAMPLE = "fusion calibrate intrinsics board_recording --board board.json -o out"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The command's options."""
    add = parser.add_argument
    add("recording", type=Path, metavar="REC", help="recording with infrared or colour, or a plain folder of pictures")
    add(
        "--board",
        type=Path,
        required=True,
        metavar="FILE",
        help='board.json: {"columns": 7, "rows": 5, "square_m": 0.03}, which counts the INNER corners; a ChArUco board '
        'has "marker_m": 0.022, "dictionary": "DICT_5X5_100" (OpenCV\'s name) besides',
    )
    add_output(parser, "folder for camera.json and report.html")
    add(
        "--distance",
        type=number(WORKING_DISTANCE),
        metavar="M",
        help="working distance [m] for the uncertainty in mm; default: the boards'",
    )
    add_topic(parser)
    add("--keep-outliers", action="store_true", help="name views that do not fit, but use them all the same")
    add("--json", action="store_true", help="print one JSON object")


def run(options: argparse.Namespace) -> None:
    """Calibrate, write, print."""
    from fusion.calibration.lens.boards.board import read_board
    from fusion.calibration.lens.intrinsics import LensSettings, calibrate_intrinsics
    from fusion.calibration.lens.write import calibrated_camera, numbers
    from fusion.report.calibrations.lens import lens_report

    board = read_board(options.board)
    settings = LensSettings(options.keep_outliers, options.distance)
    result = calibrate_intrinsics(options.recording, board, settings, options.topic)
    with options.claim.folder() as partial:
        text = json_text(calibrated_camera(result))
        (partial / "camera.json").write_text(text + "\n", encoding="utf-8")
        if options.report:
            with stage("report"):
                lens_report(result, partial / "report.html", options.recording, "fusion " + " ".join(sys.argv[1:]))
    content = numbers(result)
    print(json_text(content) if options.json else "\n".join(_lines(result, content)))


def _lines(result: "Intrinsics", content: "CalibrationFigures") -> list[str]:
    lines = []
    for name, fit in content.cameras.items():
        values, std = fit.parameters, fit.std
        lines.append(f"{name}: board found in {fit.found} of {fit.pictures} pictures, {fit.used} used")
        lines += [f"  {key:<3}{value:>12.5f} +- {std[key]:.5f}" for key, value in values.items()]
        lines += ["  k3 is not established by these views: held at 0"] if fit.k3_held else []
        pitch, bow = fit.row_pitch, fit.bow
        lines.append(
            f"  board: rows {pitch.ratio:.4f} +- {pitch.std:.4f} times as far apart as columns; bows by "
            f"{1000 * bow.bow_m:.2f} +- {1000 * bow.std_m:.2f} mm over {1000 * bow.over_m:.0f} mm"
        )
        at = fit.uncertainty
        lines.append(f"  reprojection {fit.rms_px:.3f} px rms; board in {fit.coverage:.0%} of the picture")
        lines.append(
            f"  projection known to {at['centre_px']:.3f} px at the centre, {at['rms_px']:.3f} px over the picture "
            f"({at['centre_mm']:.2f} and {at['rms_mm']:.2f} mm at {at['distance_m']:.2f} m)"
        )
        lines.append(f"  most influential view {fit.most_influential.view}: up to "
                     f"{fit.most_influential.sigmas:.1f} standard deviations without it")  # fmt: skip
        kept = "named, kept" if fit.outliers_kept else "left out"
        lines += [f"  {kept}: {o.view}: {o.reason}" for o in fit.outliers]
        if unread := fit.unread:
            count = "1 picture" if len(unread) == 1 else f"{len(unread)} pictures"
            first, reason = next(iter(unread.items()))
            lines.append(f"  {count} could not be used, the first {first}: {reason}")
    if result.pair is not None:
        moved = ", ".join(f"{1000 * x:.1f}" for x in result.pair.T_color_depth[:3, 3])
        lines.append(f"colour camera at ({moved}) mm, {len(result.pair.used)} pairs, {result.pair.rms_px:.3f} px rms")
    return lines + [f"warning: {text}" for text in result.warnings]
