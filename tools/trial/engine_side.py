"""Runs in the engine's process: explains without pictures, which are most of the command's time; predicts with models.

python engine_side.py explain REC... --sensor S -o OUT           verdict.json and sensor.json into a folder
python engine_side.py explain ... --without EFFECT...            as if the catalogue did not have these effects
python engine_side.py predict REC... --sensor S S2... -o FILE    depth of each recording by each model, as .npy
"""

import argparse
from pathlib import Path

import numpy as np

from fusion.discrepancy.explain import explain
from fusion.discrepancy.naming.search import candidates
from fusion.discrepancy.observe.frame_block import blocks_of, stage_of, wanted_channels
from fusion.discrepancy.observe.observations import observe
from fusion.discrepancy.verdict.verdict import verdict_of
from fusion.files.json_values import json_text
from fusion.geometry.camera import Principle
from fusion.recording.open import open_recording
from fusion.sensor.files.sensor_file import read_sensor, write_sensor


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("task", choices=["explain", "predict"])
    parser.add_argument("recordings", type=Path, nargs="+")
    parser.add_argument("--sensor", type=Path, nargs="+", required=True)
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--without", nargs="+", default=[], metavar="EFFECT")
    options = parser.parse_args()
    candidates.EFFECTS = tuple(kind for kind in candidates.EFFECTS if kind.name not in options.without)
    if options.task == "explain":
        explain_into(options.recordings, options.sensor[0], options.output)
    else:
        np.save(options.output, predictions(options.recordings, options.sensor))


def explain_into(paths: list[Path], sensor: Path, out: Path) -> None:
    found = explain([open_recording(path) for path in paths], read_sensor(sensor))
    out.mkdir(parents=True, exist_ok=True)
    (out / "verdict.json").write_text(json_text(verdict_of(found)))
    write_sensor(out / "sensor.json", found.sensor)


def predictions(paths: list[Path], sensors: list[Path]) -> np.ndarray:
    """(sensors, recordings, h, w) [m] mean depth of the first look."""
    models = [read_sensor(path) for path in sensors]
    baseline = models[0].baseline if models[0].principle in ("structured_light", "active_stereo") else None
    channels = wanted_channels(baseline, models[0].principle == Principle.TIME_OF_FLIGHT)
    blocks = [blocks_of(stage_of(open_recording(path), place), channels)[0] for place, path in enumerate(paths)]
    return np.array([[patch.predicted for patch in observe(model, blocks).patches] for model in models], np.float64)


if __name__ == "__main__":
    main()
