"""The same quantity is the same number on the terminal, in the JSON and on the page."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from made_up import UP, bumpy_sphere

from fusion.commands.scan import turntable
from fusion.mesh.shape import shape_of
from fusion.report.scans.facts import fact_numbers
from fusion.results.facts import Gap, ScanFacts, TableFacts
from fusion.results.judgement import Worth

TABLE = TableFacts(
    float(np.radians(6.054)), float(np.radians(0.1149)), (), Gap(0.0162, 0.00249, 1.0), Gap(0.007, 0.0031, 2.0)
)
FACTS = ScanFacts(shape_of(bumpy_sphere(3), UP), 25, 23, 0.00123, 0.9, TABLE)


def test_terminal_and_page_print_the_same_numbers():
    settings = SimpleNamespace(voxel_m=0.002, correction=SimpleNamespace(text="none"))
    scan = SimpleNamespace(facts=FACTS, settings=settings, judgement=SimpleNamespace(lines=list, worth=Worth("good")))
    said = "\n".join(turntable.lines(scan))
    tiles = {number.name: number for number in fact_numbers(FACTS)}
    for name in ("Smallest upright box", "Volume", "Surface", "Triangles", "Frames placed", "Turn a frame"):
        assert tiles[name].value in said, name
    assert tiles["Closing gap"].value == "2.49 mm, 0.93 deg" and tiles["Closing gap"].value in said
    assert "worse than before the post-pass: 0.40 to 0.93 deg" in said
    assert "0.40 to 0.93 deg" in tiles["Closing gap"].note


def test_json_holds_what_is_printed():
    values = FACTS.values()
    tiles = {number.name: number for number in fact_numbers(FACTS)}
    assert " x ".join(f"{1e3 * side:.0f}" for side in values["size_m"]) == tiles["Smallest upright box"].value
    assert f"{values['step_mean_deg']:.2f}" == tiles["Turn a frame"].value
    assert f"{values['triangles']:,}" == tiles["Triangles"].value


def test_a_sphere_with_an_open_bottom_is_told_as_one():
    tiles = {number.name: number for number in fact_numbers(FACTS)}
    assert tiles["Surface"].value == "bottom open"
    # a ball of 0.1 m with bumps of 8 %, less the cap that was cut off
    assert float(tiles["Volume"].value) == pytest.approx(4.19, rel=0.1) and tiles["Volume"].unit == "litres"


def test_what_is_not_known_has_no_tile():
    bare = {number.name for number in fact_numbers(ScanFacts(FACTS.shape))}
    assert bare == {"Smallest upright box", "Height", "Volume", "Surface", "Triangles"}
    open_sheet = replace(FACTS.shape, volume=None)
    assert "Volume" not in {number.name for number in fact_numbers(ScanFacts(open_sheet))}
