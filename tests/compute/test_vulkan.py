"""On a card: the tests of volume, tracking and turntable, and a whole scan that comes out as on the processor."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

PROJECT = Path(__file__).resolve().parents[2]
SAME = 2e-5  # [m] rms: 500 of a vertex' places of rounding at a depth of 1 m, a fiftieth of a voxel of 1 mm
VOXEL = 0.001  # [m] a scan that errs by so much is none
# a frame fused by plain kernels and meshed, wherever it is
WORK = """
import os, sys
os.environ["FUSION_KERNELS"] = "plain"
import numpy as np
import fusion

camera = fusion.Camera(80, 60, 70.0, 70.0, 39.5, 29.5)
volume = fusion.Volume(fusion.VolumeSettings(voxel=0.01, truncation=0.04))
v, u = np.indices(camera.shape)
for k in range(3):
    depth = (1 + 0.05 * np.sin(u / 9 + k / 20) + 0.05 * np.cos(v / 7)).astype(np.float32)
    volume.integrate(depth, camera, np.eye(4))
np.save(sys.argv[1], volume.surface().vertices)
"""
pytestmark = pytest.mark.slow  # minutes each


def run(*command: str, device: str) -> "subprocess.CompletedProcess[str]":
    environment = {**os.environ, "FUSION_DEVICE": device, "FUSION_KERNELS": "", "PYTHONPATH": str(PROJECT)}
    environment.pop("PYTEST_XDIST_WORKER", None)
    whole = [sys.executable, *command]
    return subprocess.run(
        whole, env=environment, capture_output=True, text=True, cwd=PROJECT, timeout=3000, check=False
    )


@pytest.fixture(scope="module", params=["vulkan", "cuda"])
def card(request):
    tried = run("-c", "from fusion.compute.start import start; start()", device=request.param)
    if tried.returncode:
        pytest.skip(f"{request.param}: {tried.stderr.strip().splitlines()[-1]}")
    return request.param


FILES = [
    path for room in ("volume", "tracking", "turntable") for path in sorted(PROJECT.glob(f"tests/{room}/test_*.py"))
]


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_the_tests_of_kernels_pass(path, card):
    """Each file in a process of its own: every launch on Mesa's device takes a mapping of memory, of which a process
    has 65,530."""
    chosen = ["-q", "-n", "0", "-p", "no:cacheprovider", "-k", "not tuned", "-m", "not slow and not real"]
    done = run("-m", "pytest", *chosen, str(path), device=card)
    assert done.returncode in (0, 5), done.stdout[-3000:]


def test_a_frame_fused_and_meshed_is_the_processors(card, tmp_path):
    for device in ("cpu", card):
        done = run("-c", WORK, str(tmp_path / f"{device}.npy"), device=device)
        assert done.returncode == 0, done.stderr[-3000:]
    there, here = (np.load(tmp_path / f"{device}.npy") for device in (card, "cpu"))
    assert len(here) > 1000 and there.shape == here.shape
    assert np.sqrt(np.mean(np.sum((there - here) ** 2, axis=1))) < SAME


def test_a_whole_scan_is_done(card, tmp_path):
    """Found motions may differ: of twelve frames they hang on little, and rounding moves them on a processor too."""
    program = "import sys; from fusion.commands.main import main; sys.exit(main(sys.argv[1:]))"
    done = run("-c", program, "demo", "--frames", "12", "-o", str(tmp_path / "demo"), device=card)
    assert done.returncode == 0, done.stderr[-3000:]
    told = json.loads((tmp_path / "demo" / "comparison.json").read_text(encoding="utf-8"))
    assert told["accuracy"]["rms"] < VOXEL, told
