"""`fusion live` of a simulated turn, replayed: the view places its frames, the result is that of the recording."""

import json

import numpy as np
import pytest

from fusion.commands.main import main
from fusion.mesh.files import read_mesh
from fusion.recording.open import open_recording

pytestmark = pytest.mark.slow
CAMERA = {"width": 160, "height": 120, "fx": 144, "fy": 144, "cx": 79.5, "cy": 59.5, "depth_scale": 5000}
SHARED = ["--no-report", "--quiet", "--json"]


def simulated(folder, capsys):
    """A recording of a turn, by the program's own simulation."""
    (folder / "camera.json").write_text(json.dumps(CAMERA | {"principle": "structured_light"}))
    words = f"--set frames=40 --set turns=1.1 --camera {folder}/camera.json --seed 3 --quiet"
    assert main(["simulate", "turntable", *words.split(), "-o", str(folder / "turn")]) == 0
    capsys.readouterr()
    return folder / "turn"


def live(source, out, capsys):
    """What the command tells of a scan."""
    assert main(["live", source, "-o", str(out), "--no-view", *SHARED]) == 0
    return json.loads(capsys.readouterr().out)


def test_a_live_scan_is_the_scan_of_its_recording(tmp_path, capsys):
    turn, out, again = simulated(tmp_path, capsys), tmp_path / "out", tmp_path / "again"
    told = live(f"replay:{turn}@4", out, capsys)
    assert told["recorded"] == 40 and told["missed"] == 0
    assert sum(told["view"].values()) <= 40
    recording = open_recording(tmp_path / "out_recording")
    assert len(recording) == 40
    assert main(["turntable", str(recording.path), "-o", str(again), *SHARED]) == 0
    one, other = read_mesh(out / "mesh.ply"), read_mesh(again / "mesh.ply")
    assert np.sqrt(np.mean((one.vertices - other.vertices) ** 2)) < 1e-4  # the figure of the task; they are the same
