"""Closes the loop: explains recordings, simulates them with the model before and after, and tests which looks alike.

    python -m tools.reproduce.closed_loop CASE/rec_* --sensor CASE/sensor.json

Recordings and simulations go through `fusion explain` and `fusion simulate` as a user's would; `--extended` takes the
sensor.json of an explanation that was made before. Both simulations have the same seed.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

from fusion.discrepancy.inference.tile_covariance import covariance_of
from fusion.discrepancy.observe.frame_block import blocks_of, wanted_channels
from fusion.discrepancy.observe.observations import Observations, observe
from fusion.discrepancy.observe.scene.stage import stage_of
from fusion.geometry.camera import Principle
from fusion.recording.open import open_recording
from fusion.sensor.files.sensor_file import read_sensor
from fusion.sensor.sensor import Sensor
from tools.reproduce.likeness import Likeness, likeness

PROGRAM = [sys.executable, "-c", "import sys; from fusion.commands.main import main; sys.exit(main())"]


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("recordings", type=Path, nargs="+")
    parser.add_argument("--sensor", type=Path, required=True, help="the model as given")
    parser.add_argument("--extended", type=Path, help="the model that explain made of it; default: it is made now")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        extended = options.extended or _explained(options, Path(scratch))
        given = read_sensor(str(options.sensor))
        recorded = _observed(options.recordings, given)
        covariance = covariance_of(recorded)
        print(f"{len(options.recordings)} recordings, {len(recorded.residual)} tiles")
        for when, sensor in (("as given", options.sensor), ("extended", extended)):
            folder = Path(scratch) / when
            simulated = [_simulated(rec, sensor, folder, options.seed + k) for k, rec in enumerate(options.recordings)]
            found = likeness(recorded, _observed(simulated, given), covariance, options.seed)
            print(f"model {when}: {said(found)}", flush=True)


def said(found: Likeness) -> str:
    """One line."""
    differs = f", they differ along {', '.join(found.differs)}" if found.differs else ""
    word = "looks like the recordings" if found.alike else "does not look like the recordings"
    return f"{word}: p {found.probability:.4f}, chi2 of the difference {found.chi2_per_dof:.2f} per tile{differs}"


def _explained(options: argparse.Namespace, scratch: Path) -> Path:
    out = scratch / "explained"
    command = [*PROGRAM, "explain", *map(str, options.recordings), "--sensor", str(options.sensor), "-o", str(out)]
    command.append("--overwrite")
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    verdict = json.loads((out / "verdict.json").read_text())
    print("missing: " + (", ".join(entry["effect"] for entry in verdict["missing"]) or "nothing"))
    return out / "sensor.json"


def _simulated(recording: Path, sensor: Path, folder: Path, seed: int) -> Path:
    out = folder / recording.name
    folder.mkdir(exist_ok=True)
    command = [*PROGRAM, "simulate", str(recording), "-o", str(out), "--sensor", str(sensor), "--seed", str(seed)]
    command.append("--overwrite")
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return out


def _observed(folders: list[Path], sensor: Sensor) -> Observations:
    """Tiles of recordings under a sensor model."""
    baseline = None if sensor.principle == Principle.TIME_OF_FLIGHT else sensor.baseline
    channels = wanted_channels(baseline, sensor.principle == Principle.TIME_OF_FLIGHT)
    stages = [stage_of(open_recording(folder), place) for place, folder in enumerate(folders)]
    return observe(sensor, [block for stage in stages for block in blocks_of(stage, channels)])


if __name__ == "__main__":
    main()
