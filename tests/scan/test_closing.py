"""Closing: two views where a turn closes are held against other views of the same scan."""

from types import SimpleNamespace

import numpy as np
import pytest

from fusion.results.facts import Gap
from fusion.scan.judging import missed

ANGLES = np.deg2rad(np.arange(0.0, 400.0, 20.0))


@pytest.mark.parametrize(("usual", "closing", "said"), [(0.3, 1.5, 5.0), (2.0, 2.0, 1.0), (0.0, 0.2, 2.0)])
def test_what_other_views_miss_each_other_by_is_the_measure(monkeypatch, usual, closing, said):
    """Noise that neighbours do not share lets views fit better than expected, and bent depth worse; see SHARPEST."""
    pair = missed.closing_pair(ANGLES)

    def gap(frames, region, trajectory, of, direct):
        return Gap(0.01, 0.001, closing if of == pair else usual)

    monkeypatch.setattr(missed, "aligned", lambda *_: SimpleNamespace())
    monkeypatch.setattr(missed, "gap_of", gap)
    after, before = missed.closing_gaps([], None, (None, None), ANGLES)
    assert after.deviations == before.deviations == pytest.approx(said)
