"""The whole chain of an open turntable challenge: its calibration recordings, then its scan, against the truth.

    python -m tools.reproduce.calibration.chain    all cases: 5 to 10 min on 2 cores
    python -m tools.reproduce.calibration.chain --case turntable_v1_statue --keep OUT

Per case, as a user would: `fusion calibrate intrinsics` on the board, `fusion calibrate depth` on the walls, the scan
with that camera.json and sensor.json. Then the figures of `turntable_challenge`, beside those of the same scan with
the true camera and the true depth errors undone. Prints what was asked and what was reached; leaves 1 where not all
was. The truth is read for the comparison only.
"""

import argparse
import contextlib
import io
import json
import os
import re
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fusion.commands.main import main as fusion

CASES = ("turntable_v1_statue", "turntable_v2_bricks", "turntable_v2_statue")
LASER = "0.0007"  # [m] standard deviation of distance_m, as the challenges say
TOOL = "tools.reproduce.scans.turntable_challenge"


@dataclass(frozen=True)
class Line:
    """One figure: what it is, what was asked for (at most) and reached, and how it is written."""

    name: str
    most: float
    reached: float
    form: str

    def __str__(self) -> str:
        sign = " " if self.reached <= self.most else "!"
        return f"  {self.name:<44} at most {self.form.format(self.most):<9} {self.form.format(self.reached):>9} {sign}"


def main(arguments: list[str] | None = None) -> int:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--shared", type=Path, default=Path(os.environ.get("FUSION_SHARED", "../shared")))
    parser.add_argument("--case", choices=CASES, action="append", help="default: all")
    parser.add_argument("--keep", type=Path, help="folder for the calibrations; default: none is kept")
    options = parser.parse_args(arguments)
    good = True
    with tempfile.TemporaryDirectory() as scratch:
        for case in options.case or CASES:
            folder = (options.keep or Path(scratch)) / case
            camera, sensor = calibrated(options.shared / "challenges" / "turntable" / case, folder)
            own = scanned(options.shared, case, str(camera), str(sensor))
            best = scanned(options.shared, case, "true", "true")
            table = lines(own, best)
            print(f"{case}\n" + "\n".join(map(str, table)))
            for name, found in (("own calibration", own), ("true correction", best)):
                print(f"  {name}: {found['distances']}\n  {'':<{len(name)}}  slip {found['slip found']}")
            good &= all(line.reached <= line.most for line in table)
    return 0 if good else 1


def calibrated(case: Path, folder: Path) -> tuple[Path, Path]:
    """camera.json and sensor.json from the board and the walls of a case, written below a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    board = ["--board", str(case / "board.json")]
    _fusion("calibrate", "intrinsics", str(case / "board"), *board, "-o", str(folder / "lens"))
    camera = folder / "lens" / "camera.json"
    walls = sorted(str(wall) for wall in case.glob("wall_*"))
    known = ["--camera", str(camera), "--sensor", str(case / "sensor.json"), "--distance-std", LASER]
    _fusion("calibrate", "depth", *walls, *known, "-o", str(folder / "depth"))
    return camera, folder / "depth" / "sensor.json"


def scanned(shared: Path, case: str, camera: str, correction: str) -> dict[str, Any]:
    """What `turntable_challenge` says of a case, in a process of its own: its memory is given back."""
    given = ["--shared", str(shared), "--case", case, "--camera", camera, "--correction", correction, "--json"]
    found: list[dict[str, Any]] = json.loads(_run([sys.executable, "-m", TOOL, *given]))
    return found[0]


def lines(own: dict[str, Any], best: dict[str, Any]) -> list[Line]:
    """The figures asked for (issues: depth calibration, turntable)."""
    scale = _number(r"scale ([\d.]+)", own["distances"])
    std, true_std = (_number(r"std ([\d.]+) mm", found["distances"]) for found in (own, best))
    return [
        Line("scale error", 0.2, 100 * abs(scale - 1), "{:.2f} %"),
        Line("distance std over that with true correction", 1.15, std / true_std, "{:.3f}"),
        Line("largest error of an angle", 0.3, _number(r"([\d.]+) /", own["angle error largest / rms"]), "{:.3f} deg"),
    ]


def _number(pattern: str, text: str) -> float:
    found = re.search(pattern, text)
    if found is None:
        raise SystemExit(f"no {pattern} in: {text}")
    return float(found[1])


def _fusion(*arguments: str) -> None:
    with contextlib.redirect_stdout(io.StringIO()) as said:
        code = fusion([*arguments, "--overwrite"])
    if code:
        raise SystemExit(f"fusion {' '.join(arguments)}\n{said.getvalue()}")


def _run(command: list[str]) -> str:
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise SystemExit(f"{' '.join(command)}\n{done.stderr}")
    return done.stdout


if __name__ == "__main__":
    sys.exit(main())
