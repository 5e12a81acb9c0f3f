"""Runs in a process of its own: what plainer methods make of a case, from the same tiles and the same footprints.

python naive.py REC... --sensor S -o FILE       names that each method claims, the first first
"""

import argparse
import json
import sys
from pathlib import Path

from fusion.discrepancy.inference.tile_covariance import covariance_of
from fusion.discrepancy.naming.search.candidates import candidates_of
from fusion.discrepancy.observe.frame_block import blocks_of, stage_of, wanted_channels
from fusion.discrepancy.observe.observations import observe
from fusion.geometry.camera import Principle
from fusion.recording.open import open_recording
from fusion.sensor.files.sensor_file import read_sensor

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from tools.trial.pixelwise import lasso, nearest_cosine, pixelwise, stepwise_bic

METHODS = {"pixel BIC stepwise": stepwise_bic, "lasso": lasso, "nearest cosine": nearest_cosine}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("recordings", type=Path, nargs="+")
    parser.add_argument("--sensor", type=Path, required=True)
    parser.add_argument("-o", "--output", type=Path, required=True)
    options = parser.parse_args()
    sensor = read_sensor(options.sensor)
    baseline = sensor.baseline if sensor.principle in ("structured_light", "active_stereo") else None
    channels = wanted_channels(baseline, sensor.principle == Principle.TIME_OF_FLIGHT)
    blocks = []
    for place, path in enumerate(options.recordings):
        blocks += blocks_of(stage_of(open_recording(path), place), channels)
    observations = observe(sensor, blocks)
    data = pixelwise(observations, candidates_of(observations, covariance_of(observations)))
    options.output.write_text(json.dumps({name: method(data) for name, method in METHODS.items()}))


if __name__ == "__main__":
    main()
