"""`fusion live` of a simulated turn, replayed: the view places its frames, the result is that of the recording."""

import json

import numpy as np
import pytest

from fusion.commands.main import main
from fusion.mesh.files import read_mesh
from fusion.recording.open import open_recording

pytestmark = pytest.mark.slow
CAMERA = {"width": 160, "height": 120, "fx": 144, "fy": 144, "cx": 79.5, "cy": 59.5, "depth_scale": 5000}


def test_a_live_scan_is_the_scan_of_its_recording(tmp_path, capsys):
    (tmp_path / "camera.json").write_text(json.dumps(CAMERA | {"principle": "structured_light"}))
    words = f"--set frames=40 --set turns=1.1 --camera {tmp_path}/camera.json --seed 3 --quiet"
    assert main(["simulate", "turntable", *words.split(), "-o", str(tmp_path / "turn")]) == 0
    capsys.readouterr()
    shared = ["--no-report", "--quiet", "--json"]
    out, again = tmp_path / "out", tmp_path / "again"
    assert main(["live", f"replay:{tmp_path / 'turn'}@4", "-o", str(out), "--no-view", *shared]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["recorded"] == 40
    assert told["missed"] == 0
    assert told["view"] == {"placed": told["view"]["placed"], "lost": 0, "late": 0}
    assert told["view"]["placed"] >= 30  # the first ones show that something turns
    recording = open_recording(tmp_path / "out_recording")
    assert len(recording) == 40
    assert main(["turntable", str(recording.path), "-o", str(again), *shared]) == 0
    one, other = read_mesh(out / "mesh.ply"), read_mesh(again / "mesh.ply")
    assert np.sqrt(np.mean((one.vertices - other.vertices) ** 2)) < 1e-4  # the figure of the task; they are the same
