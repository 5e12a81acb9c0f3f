"""The view keeps up with a camera: by a fed clock, so that what else the machine does changes nothing."""

import json
import sys
from pathlib import Path

import numpy as np
import pytest

from fusion.commands.main import main
from fusion.recording.open import open_recording

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tools"))
from live_rate import fed

pytestmark = pytest.mark.slow
CAMERA = {"width": 320, "height": 240, "fx": 288, "fy": 288, "cx": 159.5, "cy": 119.5, "depth_scale": 5000}
FRAMES = 200


def test_every_frame_of_a_turn_is_placed_and_none_is_shown_late(tmp_path):
    """640 x 480, as the figure is asked for, takes a minute to simulate: see tools/live_rate.py."""
    (tmp_path / "camera.json").write_text(json.dumps(CAMERA | {"principle": "structured_light"}))
    words = f"--set frames={FRAMES} --set turns=0.7 --camera {tmp_path}/camera.json --sensor kinect-v1 --seed 8 --quiet"
    assert main(["simulate", "turntable", *words.split(), "-o", str(tmp_path / "turn")]) == 0
    recording = open_recording(tmp_path / "turn")
    fed(recording, 30.0)  # compiles
    watch, took = fed(recording, 30.0)
    assert (watch.tracked, watch.untracked, len(watch.waiting), watch.feed.dropped) == (FRAMES, 0, 0, 0)
    assert np.median(watch.behind) < 0.15
    assert np.mean(took) < 1 / 30
