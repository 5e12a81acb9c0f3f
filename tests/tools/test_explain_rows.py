"""Rows of what was once explained wrongly: each is made with what its name says, and judged strictly."""

import json
from pathlib import Path

import numpy as np
import pytest

from tools.trial.once_wrong.row import verdict_on
from tools.trial.once_wrong.rows import ROWS
from tools.trial.spoiled.case import put
from tools.trial.spoiled.running import Run
from tools.trial.spoiled.scoring import Score


def made(name, folder, variant=0):
    number = next(k for k, row in enumerate(ROWS) if row.name == name)
    return ROWS[number].make(variant, np.random.default_rng([7, number]), folder / "made")


def test_copies_are_the_same_counts_by_other_names(tmp_path):
    _, spoiled = made("copies of one recording", tmp_path)
    recordings = spoiled.case.recordings
    assert len({taken.name for taken in recordings}) == len(recordings) == 8
    assert all(np.array_equal(taken.depth, recordings[0].depth, equal_nan=True) for taken in recordings)
    assert len({taken.times[0] for taken in recordings}) == 8


def test_what_is_unsaid_is_not_in_the_file_that_is_explained(tmp_path):
    base, spoiled = made("speckle of 0.05 px", tmp_path)
    _, sensor = put(spoiled.case, tmp_path / "case")
    named = {entry["effect"] for entry in json.loads(Path(sensor).read_text(encoding="utf-8"))["effects"]}
    assert "speckle_noise" not in named and "axial_noise" in named
    assert [one["effect"] for one in base.missing] == ["speckle_noise"]


def test_an_effect_is_planted_and_its_model_lacks_it(tmp_path):
    base, spoiled = made("disparity off by 0.15 px", tmp_path)
    label = base.missing[0]
    assert label["effect"] == "disparity_offset"
    assert label["parameters"]["offset"]["value"] == pytest.approx(0.15)
    assert len(spoiled.case.recordings) > 3


@pytest.mark.parametrize(
    ("outcome", "told", "said"),
    [
        ("right", None, "right"), ("right", True, "right"), ("right", False, "silent"), ("set", None, "right"),
        ("refused", True, "right"), ("silent", True, "told"), ("silent", False, "silent"), ("silent", None, "silent"),
        ("WRONG", True, "WRONG"), ("failed", True, "WRONG"),
    ],
)  # fmt: skip
def test_words_are_strict(outcome, told, said):
    assert verdict_on(Run(0, "", True, "", "", Score(outcome, told, (), (), ()), 1.0, "")) == said
