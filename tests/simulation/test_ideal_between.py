"""Ideal frames with all that a renderer can tell: a sensor makes of them what the own simulator makes of the scene."""

from dataclasses import replace

import numpy as np
import pytest

from fusion.commands.main import main
from fusion.errors import SensorError
from fusion.geometry.camera import Camera
from fusion.recording.open import open_recording
from fusion.sensor.files.sensor_file import read_sensor
from fusion.sensor.sensor import Sensor
from fusion.simulation.ideal.frame import checked
from fusion.simulation.ideal.passes import ideal_of
from fusion.simulation.ideal.sense import sense, stated_by
from fusion.simulation.ideal.view import unknown_to, view_of_ideal
from fusion.simulation.rendering.exposure import Exposures
from fusion.simulation.scenes import built_in
from fusion.simulation.simulate import Simulation, simulate
from fusion.simulation.write import write_simulation

SMALL = Camera(96, 72, 78.0, 78.0, 47.5, 35.5, depth_scale=5000.0)
SENSORS = ("kinect-v1", "kinect-v2-indoors")


def seen(name: str, word: str) -> Simulation:
    return simulate(replace(built_in(name, {"frames": 1}), camera=SMALL), read_sensor(word), seed=3)


@pytest.mark.parametrize("word", SENSORS)
@pytest.mark.parametrize("name", ["target", "checkerboard", "room"])
def test_a_sensor_makes_of_it_what_the_own_simulator_makes(name, word):
    made = seen(name, word)
    own = next(made.frames()).depth
    depth = sense(next(ideal_of(made)), made.camera, made.sensor, seed=3).depth
    # the same random numbers: all that is left is where rays meet a thin edge, by rounding
    same = (own == depth) | (np.isnan(own) & np.isnan(depth))
    assert same.mean() > 0.998
    alone = sense(next(ideal_of(made)).depth, made.camera, made.sensor, seed=3).depth
    assert ((own == alone) | (np.isnan(own) & np.isnan(alone))).mean() < same.mean()


def test_the_finer_the_images_the_nearer_the_edges():
    made = seen("target", "kinect-v1")
    exposures = Exposures(made.scene, made.sensor, made.camera, made.turned_deg)
    true = exposures.view(0, made.moment(0), np.random.default_rng(0)).edges.distance
    off = []
    for finer in (4, 16, 64):
        camera = stated_by(made.camera, made.sensor)
        found = view_of_ideal(checked(next(ideal_of(made, finer)), camera), camera, made.sensor).edges.distance
        near = np.isfinite(true) & np.isfinite(found) & (true < 2)
        off.append(np.abs(found[near] - true[near]).max())
    # a step is 1/n px, and its middle taken; 1/64 is what the truth is bisected to; corners turn
    assert off[0] < 0.3
    assert off[0] > off[1] > off[2]
    assert off[2] < 1e-3


def test_what_is_given_is_not_told_as_unknown():
    made = seen("target", "kinect-v1")
    full = next(ideal_of(made, 4))
    assert unknown_to(made.sensor, full) == []
    assert len(unknown_to(made.sensor, replace(full, rows=None, columns=None, lit=None))) == 2


@pytest.mark.parametrize(
    ("rows", "columns", "word"),
    [((72, 192), None, "belong together"), ((72, 191), (144, 96), "rows"), ((72, 192), (72, 96), "columns")],
)
def test_depth_between_pixels_that_does_not_fit_is_refused(rows, columns, word):
    images = {"rows": np.ones(rows), "columns": None if columns is None else np.ones(columns)}
    frame = replace(next(ideal_of(seen("wall", "kinect-v1"), 1)), **images)
    with pytest.raises(SensorError, match=word):
        checked(frame, SMALL)


def test_light_across_an_edge_is_that_of_the_print():
    made = seen("checkerboard", "kinect-v2-indoors")
    exposures = Exposures(made.scene, made.sensor, made.camera, made.turned_deg)
    view = exposures.view(0, made.moment(0), np.random.default_rng(0))
    with np.errstate(all="ignore"):
        light = view.reflectance * np.cos(view.incidence) / (view.depth * view.stretch) ** 2
    edges = view.edges
    beside = (edges.distance < 0.5) & (edges.light > 0) & (np.abs(np.sin(2 * edges.direction)) < 0.1)
    v, u = np.nonzero(beside)
    across = (
        np.clip(v + np.rint(np.sin(edges.direction[v, u])).astype(int), 0, 71),
        np.clip(u + np.rint(np.cos(edges.direction[v, u])).astype(int), 0, 95),
    )
    assert len(v) > 3
    assert np.median(np.abs(edges.light[v, u] / (light[across] / light[v, u]) - 1)) < 0.01


def test_the_command_takes_them_from_folders(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    made = seen("target", "kinect-v1")
    ideal = next(ideal_of(made, 8))
    write_simulation("rec", simulate(made.scene, Sensor(), seed=3))
    for name in ("normals", "rows", "columns", "lit"):
        (tmp_path / name).mkdir()
        np.save(tmp_path / name / "0.npy", getattr(ideal, name))
    words = "simulate --ideal rec -o out --sensor kinect-v1 --seed 3 --normals normals"
    assert main(f"{words} --rows rows".split()) == 1
    assert "belong together" in capsys.readouterr().err
    assert main(f"{words} --rows rows --columns columns --lit lit".split()) == 0
    assert "cannot be known" not in capsys.readouterr().err
    found, own = open_recording("out")[0].depth, next(made.frames()).depth
    # depth in counts of 0.2 mm, edges to 1/8 px
    assert (np.isnan(found) == np.isnan(own)).mean() > 0.99
    assert (np.abs(found - own) < 0.0005).sum() > 0.9 * np.isfinite(own).sum()
