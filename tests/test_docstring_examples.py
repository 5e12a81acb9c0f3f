"""The examples in the docstrings of what `import fusion` offers, run in a folder with small recordings."""

import contextlib
import dataclasses
import doctest
import inspect
import io
from dataclasses import replace
from pathlib import Path

import numpy as np
import open3d
import pytest
import trimesh

import fusion

SMALL = fusion.Camera(160, 120, 144.0, 144.0, 80.0, 60.0, depth_scale=5000.0, principle="itof")
NAMES = [name for name in fusion.__all__ if name != "__version__"]
# whole scans and fits take seconds each
SLOW = {
    "scan_turntable", "reconstruct", "calibrate_depth", "calibrate_noise", "calibrate_intrinsics", "read_board",
    "explain", "evaluate", "merge_passes", "open_pass",
}  # fmt: skip


def examples(name):
    """The examples in the docstring of a public name and, of a class, in those of its methods."""
    known = {"fusion": fusion, "np": np, "dataclasses": dataclasses, "open3d": open3d, "trimesh": trimesh}
    found = doctest.DocTestFinder().find(getattr(fusion, name), f"fusion.{name}", module=False, globs=known)
    return [test for test in found if test.examples]


def write(folder, scene, settings, sensor, camera=SMALL):
    scene = replace(fusion.built_in(scene, settings), camera=camera)
    fusion.write_simulation(folder, fusion.simulate(scene, sensor, seed=1))


@pytest.fixture(scope="module")
def small_data(tmp_path_factory):
    """`my_scan` (the owl, turning) and `ball.ply`."""
    folder = tmp_path_factory.mktemp("examples")
    ideal = fusion.Sensor(principle="itof")
    write(folder / "my_scan", "turntable", {"frames": 26, "turns": 26 * 15 / 360}, ideal)
    ball = trimesh.creation.icosphere(3, 0.05)
    normals = np.asarray(ball.vertex_normals, np.float32)
    colors, sigma = np.full((642, 3), 200, np.uint8), np.full(642, 3e-4, np.float32)
    fusion.write_mesh(folder / "ball.ply", fusion.Mesh(ball.vertices, ball.faces, normals, colors, {"sigma": sigma}))
    return folder


@pytest.fixture(scope="module")
def more_data(small_data):
    """`wall_0` to `wall_4`, `my_room`, `board` and `my_scan_turned_over` beside it."""
    over = fusion.read_mesh(small_data / "my_scan" / "truth" / "mesh.ply")
    vertices = over.vertices * [1, -1, -1] + [0, 0, over.vertices[:, 2].max()]  # turned about x
    fusion.write_mesh(small_data / "over.ply", fusion.Mesh(vertices, over.faces, colors=over.colors))
    settings = {"mesh": str(small_data / "over.ply"), "frames": 26, "turns": 26 * 15 / 360}
    write(small_data / "my_scan_turned_over", "turntable", settings, fusion.Sensor(principle="itof"))
    sensor = fusion.read_sensor("kinect-v2-indoors")
    for i, distance in enumerate((0.6, 0.9, 1.2, 1.6, 2.0)):
        write(small_data / f"wall_{i}", "wall", {"distance_m": distance, "frames": 12}, sensor)
    write(small_data / "my_room", "room", {"frames": 6, "sweep_deg": 5}, sensor)
    larger = replace(SMALL, width=320, height=240, fx=288.0, fy=288.0, cx=160.0, cy=120.0)
    write(small_data / "board", "checkerboard", {"frames": 12}, sensor, larger)


@pytest.mark.slow
def test_results_tell_themselves_in_two_lines(small_data, more_data, monkeypatch):
    monkeypatch.chdir(small_data)
    walls = [fusion.open_recording(f"wall_{i}") for i in range(5)]
    results = [fusion.evaluate(walls), fusion.calibrate_depth(walls), fusion.calibrate_noise(walls)]
    results.append(fusion.calibrate_intrinsics("board", fusion.read_board("board/board.json")))
    for text in map(repr, results):
        assert text.startswith("<") and len(text.splitlines()) <= 2 and len(text) < 400 and "array(" not in text


@pytest.mark.slow
def test_the_example_of_the_readme_runs(small_data, monkeypatch, capsys):
    page = (Path(__file__).resolve().parent.parent / "README.md").read_text(encoding="utf-8")
    program = page.partition("```python\n")[2].partition("```")[0]
    assert program.count("import") == 1  # one import is all that is needed
    monkeypatch.chdir(small_data)
    fusion.write_mesh("cup.stl", fusion.read_mesh("my_scan/truth/mesh.ply"))
    exec(program, {})
    assert capsys.readouterr().out.startswith("<Scan: 26 of 26 frames placed")


def test_every_public_function_has_an_example_or_stands_in_one():
    shown = "".join(example.source for name in NAMES for test in examples(name) for example in test.examples)
    functions = [name for name in NAMES if inspect.isfunction(getattr(fusion, name))]
    assert [name for name in functions if f"fusion.{name}(" not in shown] == []


@pytest.mark.parametrize("name", [pytest.param(n, marks=[pytest.mark.slow] * (n in SLOW)) for n in ["", *NAMES]])
def test_examples_are_true(name, request, small_data, monkeypatch):
    if name in SLOW:
        request.getfixturevalue("more_data")
    monkeypatch.chdir(small_data)
    runner, told = doctest.DocTestRunner(), io.StringIO()
    with contextlib.redirect_stdout(told):
        for test in examples(name) if name else doctest.DocTestFinder(recurse=False).find(fusion, "fusion"):
            runner.run(test)
    assert not runner.failures, told.getvalue()
