"""The view keeps up with a camera: by a clock that goes on by a stated time for each step, on any machine."""

import json

import numpy as np
import pytest

import fusion.live.watch as watch_of
from fusion.commands.main import main
from fusion.live import feed, grow
from fusion.recording.open import open_recording
from fusion.volume.prepared import fuse
from tools.endurance.live_rate import fed

pytestmark = pytest.mark.slow
CAMERA = {"width": 320, "height": 240, "fx": 288, "fy": 288, "cx": 159.5, "cy": 119.5, "depth_scale": 5000}
FRAMES = 200


def recorded(folder, seed):
    """Most of a turn, as a Kinect v1 sees it."""
    (folder / "camera.json").write_text(json.dumps(CAMERA | {"principle": "structured_light"}))
    words = f"--set frames={FRAMES} --set turns=0.7 --camera {folder}/camera.json --sensor kinect-v1 --quiet"
    assert main(["simulate", "turntable", *words.split(), "--seed", str(seed), "-o", str(folder / "turn")]) == 0
    return open_recording(folder / "turn")


@pytest.fixture(scope="module")
def turn(tmp_path_factory):
    return recorded(tmp_path_factory.mktemp("rate"), 8)


@pytest.fixture(scope="module")
def kept_up(turn):
    """The view of a machine that is quick enough."""
    watch, _ = fed(turn, 30.0, pace=0.02)
    return watch


def test_every_frame_of_a_turn_is_placed_and_none_is_shown_late(kept_up):
    """How long a step takes is measured by tools/endurance/live_rate.py, at 640 x 480."""
    watch = kept_up
    assert (watch.tracked, watch.untracked, len(watch.waiting), watch.feed.dropped) == (FRAMES, 0, 0, 0)
    assert np.median(watch.behind) < 0.15


def test_while_the_view_is_late_every_frame_is_placed_but_not_fused(turn, kept_up, monkeypatch, tmp_path):
    """At the end of the turn it stands where it would otherwise, within a degree: the middle one of three recordings,
    as the noise of a single one moves it by as much."""
    apart = []
    for seed in (8, 9, 10):
        (folder := tmp_path / str(seed)).mkdir()
        one = turn if seed == 8 else recorded(folder, seed)
        usual = kept_up if seed == 8 else fed(one, 30.0, pace=0.02)[0]
        fused = []
        with monkeypatch.context() as late:
            late.setattr(grow, "fuse", lambda *told, into=fused: into.append(fuse(*told)))
            late.setattr(watch_of, "LATE", -1.0)
            watch, _ = fed(one, 30.0, pace=0.02)
        assert watch.tracked == FRAMES
        assert len(fused) == pytest.approx(FRAMES / grow.FUSED, abs=2)
        apart.append(abs(watch.grower.turned.angle - usual.grower.turned.angle))
    assert np.median(apart) < np.deg2rad(1.0)


def test_a_machine_that_is_too_slow_leaves_frames_out_of_the_view_and_counts_them(turn, monkeypatch):
    monkeypatch.setattr(feed, "PATIENCE", 2.0)  # [s] of the seven that there are
    watch, _ = fed(turn, 30.0, pace=0.05)
    assert watch.feed.dropped > FRAMES // 5 and watch.tracked > FRAMES // 2
    assert watch.tracked + watch.untracked + len(watch.waiting) + watch.feed.dropped == FRAMES
