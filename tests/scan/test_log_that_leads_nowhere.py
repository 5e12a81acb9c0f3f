"""A log that no motion follows is left out, and the images are asked alone; a step that was told is not."""

import numpy as np
import pytest

from fusion.errors import TrackingError
from fusion.scan.finding import pair_fit as motion
from fusion.turntable.guess import told_step

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


@pytest.mark.parametrize(("misfit", "left", "followed"), [(0.06, 0.05, True), (0.4, 0.06, False), (0.4, 0.35, True)])
def test_a_log_beside_which_the_images_fit_clearly_better_is_left_out(monkeypatch, misfit, left, followed):
    of = {True: Motion(misfit), False: Motion(left)}
    asked = []

    def estimate(views, region, commanded, known, start):
        asked.append(commanded is not None)
        return of[asked[-1]]

    monkeypatch.setattr(motion, "estimate_motion", estimate)
    for room in (motion, told_step):
        monkeypatch.setattr(room, "neighbours_misfit", lambda views, turned: turned.angles)
    found, told = motion._motion([], None, motion._Known(TOLD, None, True))
    assert found is of[followed] and (told is TOLD) == followed
    assert asked == ([True] if misfit < told_step.GOOD else [True, False])


class Motion:
    """One that misses by so much."""

    def __init__(self, misfit):
        self.axis, self.angles = None, misfit
