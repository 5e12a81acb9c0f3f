"""The benchmark compares with peers that do the work right only."""

import numpy as np
import pytest

from tools.benchmarks.stages.contest import CONTESTANTS, Score
from tools.benchmarks.stages.judge import misses
from tools.benchmarks.stages.table import Row, Table, text


def table(*rows):
    return Table("raycast", "object", "ms", rows, 0.4, ())


def test_the_fastest_peer_that_is_wrong_does_not_count():
    ours, right = Row("fusion", 5.0, 5.0, 5.0), Row("slow", 10.0, 9.0, 11.0)
    wrong = Row("fast", 1.0, 1.0, 1.0, wrong="it sees nothing")
    assert table(ours, wrong, right).ratio == pytest.approx(0.5)
    assert "does not count: it sees nothing" in text(table(ours, wrong, right))
    assert np.isnan(table(ours, wrong).ratio) and np.isnan(table(ours).ratio)


@pytest.mark.parametrize(
    ("stage", "answer", "word"),
    [
        ("raycast", {"depth_error": 0.001, "seen": 0.99}, ""),
        ("raycast", {"depth_error": 0.02, "seen": 0.99}, "off"),
        ("raycast", {"depth_error": 0.001, "seen": 0.2}, "seen"),
        ("align", {"shift_mm": 0.2, "turn_deg": 0.02}, ""),
        ("align", {"shift_mm": 48.0, "turn_deg": 1.5}, "off"),
    ],
)
def test_a_result_far_off_is_wrong(stage, answer, word):
    score = Score(CONTESTANTS[1], [answer])
    said = misses(stage, "object", score)
    assert (word in said) if word else not said
