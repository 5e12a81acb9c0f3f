"""What compiles kernels is imported in one room only, may be another one, and is left alone where it is not known."""

import ast
import os
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from fusion.compute.back_end import KNOWN
from fusion.compute.choice import plain, quadrants
from fusion.compute.language import F32
from fusion.compute.launch import Kernel, kernel
from fusion.compute.start import start
from fusion.errors import FusionError

PROJECT = Path(__file__).resolve().parents[2]
BACK_ENDS = {"taichi", "quadrants"}
# a frame fused, seen and meshed, as bytes that a change of any number changes
WORK = """
import hashlib
import numpy as np
import fusion
from fusion.compute.launch import Kernel

camera = fusion.Camera(64, 48, 60.0, 60.0, 31.5, 23.5)
volume = fusion.Volume(fusion.VolumeSettings(voxel=0.01, truncation=0.04))
depth = (1 + 0.1 * np.sin(np.arange(48 * 64).reshape(48, 64) / 500)).astype(np.float32)
volume.integrate(depth, camera, np.eye(4))
seen, mesh = volume.raycast(camera, np.eye(4)), volume.surface()
arrays = (seen.depth, seen.normals, mesh.vertices, mesh.faces)
told = hashlib.sha256(b"".join(np.ascontiguousarray(a).tobytes() for a in arrays)).hexdigest()
"""


def run(program: str, **variables: str) -> str:
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(PROJECT), os.environ.get("PYTHONPATH", "")])}
    command = [sys.executable, "-W", "ignore", "-c", program]
    done = subprocess.run(command, env=environment | variables, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr[-3000:]
    return done.stdout


def imported(path: Path) -> set[str]:
    """Packages that a file imports, at its top or inside functions."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name.partition(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            found.add(node.module.partition(".")[0])
    return found


def test_only_compute_imports_a_back_end():
    files = [*(PROJECT / "fusion").rglob("*.py"), *(PROJECT / "tools").rglob("*.py")]
    rooms = {path.relative_to(PROJECT).parts[:2] for path in files if BACK_ENDS & imported(path)}
    peers = ("tools", "bench_stages")  # Taichi as a peer, in an environment of its own
    assert rooms - {peers} == {("fusion", "compute")}


@pytest.mark.parametrize(
    ("said", "chosen"),
    [
        ("", (False, False)),
        ("tuned", (False, False)),
        ("plain", (True, False)),
        ("quadrants", (False, True)),
        ("plain,quadrants", (True, True)),
    ],
)
def test_words_choose_kernels_and_back_end(said, chosen, monkeypatch):
    monkeypatch.setenv("FUSION_KERNELS", said)
    assert (plain(), quadrants()) == chosen


@pytest.mark.parametrize("said", ["fast", "plain,fast", "tuned,plain", "plain quadrants"])
def test_other_words_are_refused(said, monkeypatch):
    monkeypatch.setenv("FUSION_KERNELS", said)
    with pytest.raises(FusionError, match="unknown kernels"):
        quadrants()


@pytest.mark.skipif(find_spec("quadrants") is not None, reason="Quadrants is installed")
def test_without_quadrants_the_extra_is_named():
    program = """
from fusion.errors import FusionError
try:
    import fusion.compute.back_end
except FusionError as problem:
    print(problem)
"""
    assert 'pip install "fusion-scan[quadrants]"' in run(program, FUSION_KERNELS="quadrants")


@pytest.mark.skipif(not KNOWN, reason="no call is quick here")
def test_quick_calls_can_be_turned_off(monkeypatch):
    start()

    @kernel
    def double(values: F32):
        for n in range(values.shape[0]):
            values[n] *= 2.0

    monkeypatch.setattr(Kernel, "quick", False)
    slowly, quickly = np.arange(9, dtype=np.float32), np.arange(9, dtype=np.float32)
    double(slowly)
    assert not double.ready
    monkeypatch.setattr(Kernel, "quick", True)
    double(quickly)
    assert double.ready and np.array_equal(slowly, quickly)


@pytest.mark.skipif(not KNOWN, reason="this Taichi is such a one")
def test_a_taichi_that_is_not_known_is_called_as_it_is_made():
    """Nothing of it is changed, no call is quick, and every number is the same."""
    another = f"""
import taichi
taichi.__version__ = (1, 8, 0)
{WORK}
from fusion.compute.launch import Kernel
from fusion.compute.back_ends.taichi_copy import kernel_impl
from taichi.lang.ast.ast_transformer_utils import ASTTransformerContext
assert kernel_impl.ASTTransformerContext is ASTTransformerContext and not Kernel.quick
print(told)
"""
    usual = f"{WORK}\nassert Kernel.quick\nprint(told)"
    assert run(another, FUSION_KERNELS="").splitlines()[-1] == run(usual, FUSION_KERNELS="").splitlines()[-1]


@pytest.mark.slow  # minutes: kernels are compiled by another back end
@pytest.mark.skipif(find_spec("quadrants") is None, reason="Quadrants is not installed: the extra `quadrants`")
@pytest.mark.parametrize("room", ["geometry", "tracking", "turntable", "volume"])
def test_rooms_with_kernels_run_on_quadrants(room):
    """The same tests, in a process whose kernels Quadrants compiles."""
    command = [sys.executable, "-m", "pytest", "-n", "0", "-m", "not slow and not real", f"tests/{room}"]
    environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTEST_")}
    environment |= {"FUSION_KERNELS": "quadrants", "FUSION_DEVICE": "cpu"}
    done = subprocess.run(command, cwd=PROJECT, env=environment, capture_output=True, text=True, timeout=1800)
    assert done.returncode == 0, done.stdout[-3000:]
    assert " passed" in done.stdout
