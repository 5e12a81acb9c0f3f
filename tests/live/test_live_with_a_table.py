"""`fusion live --table`: the program turns the table, and the view grows by a frame of each place."""

import json
import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fusion.commands.main import main
from fusion.devices import open as opening
from fusion.devices.replay import Replay
from fusion.devices.source import SourceFrame
from fusion.recording.open import open_recording

pytestmark = pytest.mark.slow
CAMERA = {"width": 160, "height": 120, "fx": 144, "fy": 144, "cx": 79.5, "cy": 59.5, "depth_scale": 5000}
STEP = 10.0
WRITE = "import sys, pathlib; pathlib.Path(sys.argv[1]).write_text(sys.argv[2])"


class Before(Replay):
    """A camera at 30 a second before a table: shows the frame of a recorded turn that stands at the table's angle."""

    def __init__(self, turn: Path, place: Path) -> None:
        super().__init__(open_recording(turn), None)
        self.place = place

    def describe(self):
        return replace(super().describe(), rate=30.0, length=None)

    def frames(self) -> Iterator[SourceFrame]:
        every, begin, index = list(super().frames()), time.time(), 0
        while not self._stopped.wait(1 / 30):
            angle = float(self.place.read_text() or 0) if self.place.exists() else 0.0
            shown = every[round(angle / STEP) % len(every)]
            now = time.time()
            yield replace(shown, index=index, timestamp=now - begin, host_time=now, log={})
            index += 1


def test_a_table_is_turned_and_the_view_grows(tmp_path, capsys, monkeypatch):
    (tmp_path / "camera.json").write_text(json.dumps(CAMERA | {"principle": "structured_light"}))
    words = f"--set frames=36 --set turns=1 --camera {tmp_path}/camera.json --seed 3 --quiet"
    assert main(["simulate", "turntable", *words.split(), "-o", str(tmp_path / "turn")]) == 0
    capsys.readouterr()
    place = tmp_path / "place"
    monkeypatch.setattr(
        opening, "open_source", lambda name, camera=None, infrared=False: Before(tmp_path / "turn", place)
    )
    table = f'{sys.executable} -c "{WRITE}" {place} {{angle}}'
    words = ["live", "kinect-v1", "-o", str(tmp_path / "out"), "--table", table, "--settle", "0.05", "--no-view"]
    assert main([*words, "--no-report", "--quiet", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["recorded"] == 37 and told["missed"] == 0
    assert told["view"] == {"placed": 37, "lost": 0, "late": 0}
    angles = open_recording(tmp_path / "out_recording").telemetry_at_frames("turntable_deg")
    np.testing.assert_allclose(angles, STEP * np.arange(37), atol=1e-6)


def test_a_table_that_is_none_is_one_line_and_nothing_is_written(tmp_path, capsys):
    assert main(["live", "replay:nowhere", "-o", str(tmp_path / "out"), "--table", "turntable"]) == 1
    assert main(["live", "replay:nowhere", "-o", str(tmp_path / "out"), "--step", "5"]) == 1
    assert "there is no table to turn; in --step" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
