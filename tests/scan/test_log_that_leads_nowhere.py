"""A log that no motion follows is left out, and the images are asked alone; a step that was told is not."""

import numpy as np
import pytest

from fusion.errors import TrackingError
from fusion.scan.finding import turn as motion

TOLD = np.arange(3.0)


@pytest.fixture
def asked(monkeypatch):
    """What the motion was looked for with; with told angles there is none."""
    calls = []

    def estimate(views, region, commanded, known, start):
        calls.append(commanded)
        if commanded is not None:
            raise TrackingError("the views do not fit a turn about one axis")
        return "by the images"

    monkeypatch.setattr(motion, "estimate_motion", estimate)
    return calls


def test_without_the_log(asked):
    assert motion._motion([], None, motion._Known(TOLD, None, True)) == ("by the images", None)
    assert [commanded is None for commanded in asked] == [False, True]


@pytest.mark.parametrize(("told", "logged"), [(TOLD, False), (None, True)])
def test_a_told_step_stays_and_nothing_is_asked_twice(asked, told, logged):
    if told is None:
        assert motion._motion([], None, motion._Known(None, None, logged))[0] == "by the images"
    else:
        with pytest.raises(TrackingError):
            motion._motion([], None, motion._Known(told, None, logged))
    assert len(asked) == 1
