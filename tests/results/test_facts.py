"""The facts of a scan have one value and one wording."""

import json

import numpy as np
import pytest

from fusion.mesh.shape import MeshShape
from fusion.results.facts import Gap, ScanFacts, TableFacts
from fusion.results.words import closing_words, size_words, volume_words


def shape(size=(0.134, 0.133, 0.169), volume=8.12e-4) -> MeshShape:
    return MeshShape(100, 200, size, 0.1, volume, (), 1, 1.0)


def table(before: tuple[float, float], after: tuple[float, float]) -> TableFacts:
    gaps = [Gap(float(np.deg2rad(degrees)), mm / 1e3, 1.0) for degrees, mm in (after, before)]
    return TableFacts(0.1, 0.01, (), *gaps)


def test_a_gap_that_got_worse_is_said():
    assert "worse than before the post-pass: 0.40 to 0.90 deg" in closing_words(table((0.4, 3), (0.9, 2)))
    assert "2.00 to 3.00 mm" in closing_words(table((0.4, 2), (0.4, 3)))
    assert "worse" not in closing_words(table((0.9, 3), (0.4, 2)))
    assert "worse" not in closing_words(table((0.400, 3), (0.4001, 3)))  # the printed digits say the same
    assert closing_words(TableFacts(0.1, 0.01)) == "no full turn"


@pytest.mark.parametrize(
    ("volume", "words"),
    [(8.12e-4, ("812", "cm3")), (2.414e-3, ("2.41", "litres")), (2.5, ("2.50", "m3")), (4e-6, ("4", "cm3"))],
)
def test_volumes_have_a_unit_that_suits_them(volume, words):
    assert volume_words(shape(volume=volume)) == words


def test_sizes_have_a_unit_that_suits_them():
    assert size_words(shape()) == ("134 x 133 x 169", "mm")
    assert size_words(shape(size=(4.2, 3.1, 2.4))) == ("4.20 x 3.10 x 2.40", "m")
    assert volume_words(shape(volume=None)) is None


def test_values_are_plain_json():
    values = ScanFacts(shape(), 5, 4, 1e-3, 0.9, table((0.4, 3), (0.9, 2))).values()
    assert json.loads(json.dumps(values)) == values
    assert values["closure_deg"] == pytest.approx({"before": 0.4, "after": 0.9})
    assert "step_mean_deg" not in ScanFacts(shape()).values()
