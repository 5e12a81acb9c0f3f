"""The table of kernels: what stands in it, that plain ones share none with tuned ones, and that a scan runs on them."""

import ast
import inspect
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import fusion
from fusion.compute.choice import TABLE, named, plain
from fusion.compute.launch import Kernel
from fusion.errors import FusionError
from fusion.geometry.camera import Camera
from fusion.mesh.comparison.distances import signed_distances
from fusion.recording.open import open_recording
from fusion.recording.writing.write import write_recording
from fusion.scan.pipeline import scan_turntable
from fusion.scan.settings import ScanSettings
from fusion.sensor.presets import preset
from fusion.sensor.sensor import Sensor
from fusion.simulation.demo.demo import demo_scene
from fusion.simulation.scene.course import turning
from fusion.simulation.scene.turntable import Turntable
from fusion.simulation.simulate import simulate

PLAIN = sorted((Path(fusion.__file__).parent / "plain").glob("*.py"))
MARKS = ("_is_taichi_function", "_is_quadrants_function")  # of what kernels call
# rooms whose kernels nothing but a table's function calls: none of them may run where plain ones were chosen
REPLACED = (
    "fusion.geometry.relief",
    "fusion.volume.integration",
    "fusion.volume.raycasting",
    "fusion.volume.extraction",
)


@pytest.mark.parametrize("name", TABLE)
def test_both_take_the_same_arguments(name):
    tuned, other = named(name), named(TABLE[name])
    assert tuned is not other and hasattr(tuned, "__wrapped__")
    assert list(inspect.signature(tuned).parameters) == list(inspect.signature(other).parameters)


@pytest.mark.parametrize("path", PLAIN, ids=lambda path: path.stem)
def test_plain_kernels_share_none_with_the_tuned(path):
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("fusion"):
            for alias in node.names:
                what = named(f"{node.module}:{alias.name}") if "." in node.module else None
                ours = node.module.startswith(("fusion.plain", "fusion.compute"))
                kernel = isinstance(what, Kernel) or any(getattr(what, mark, False) for mark in MARKS)
                assert ours or not kernel, f"{path.name} imports the kernel {alias.name} of {node.module}"
                assert f"{node.module}:{alias.name}" not in TABLE, f"{path.name} calls what it stands in for"


@pytest.mark.parametrize("path", PLAIN, ids=lambda path: path.stem)
def test_plain_kernels_are_short(path):
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.FunctionDef):
            assert node.end_lineno - node.lineno < 60 and len(node.args.args) <= 8, node.name


def test_what_is_no_kind_of_kernels_is_told(monkeypatch):
    monkeypatch.setenv("FUSION_KERNELS", "fast")
    with pytest.raises(FusionError, match="unknown kernels"):
        plain()


@pytest.mark.slow  # a whole scan, twice
def test_a_whole_scan_runs_on_plain_kernels(monkeypatch, tmp_path):
    scene, used = demo_scene(24), set()
    camera = Camera(200, 150, 195.0, 196.0, 100.3, 74.1, depth_scale=5000.0, principle="itof")
    course = turning(Turntable(degrees_per_frame=15.0, frames=24), scene.course.T_world_camera[0])
    simulation = simulate(replace(scene, camera=camera, course=course), Sensor(), 0)
    frames = (replace(frame, color=None, ir=None) for frame in simulation.frames())
    write_recording(tmp_path / "recording", camera, frames)
    recording = open_recording(tmp_path / "recording")
    settings = ScanSettings(sensor=preset("kinect-v2-indoors"), voxel=0.004, truncation=0.015, color=False)
    tuned = scan_turntable(recording, settings)
    call = Kernel.__call__

    def noted(kernel, *args):
        used.add(f"{kernel.__module__}:{kernel.__name__}")
        return call(kernel, *args)

    monkeypatch.setattr(Kernel, "__call__", noted)
    monkeypatch.setenv("FUSION_KERNELS", "plain")
    found = scan_turntable(recording, settings)
    assert not {name for name in used if name.startswith(REPLACED)}
    assert {name.split(":")[0] for name in used} >= {name.split(":")[0] for name in TABLE.values()}
    apart = np.abs(signed_distances(found.mesh.vertices, tuned.mesh))
    assert np.sqrt(np.mean(apart**2)) < 0.0002  # [m] a twentieth of a voxel
    assert np.nanmax(np.abs(found.motion.angles - tuned.motion.angles)) < np.radians(0.1)
