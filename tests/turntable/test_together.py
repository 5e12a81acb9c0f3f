"""What errors of camera and depth must bring to be believed."""

from dataclasses import replace

import numpy as np

from fusion.turntable.all_views.camera_fit import believed
from fusion.turntable.all_views.loop import Loop
from fusion.turntable.axis import Axis
from fusion.turntable.selfcheck import NAMES, SelfCheck

FRAMES = 36
NONE = SelfCheck(np.zeros(len(NAMES)), 0.5, 1.0)
AXIS = Axis(np.zeros(3), np.array([0.0, -1.0, 0.0]))


def loop(residual, pairs, values=()):
    """A fit that leaves so much [m] over, with so many pairs of points, and the first so many errors free."""
    check = replace(NONE, values=np.append(values, np.zeros(len(NAMES) - len(values))))
    one = np.ones(FRAMES)
    return Loop(AXIS, 0 * one, one, residual * one, one, pairs / FRAMES * one, check, 0 * NONE.values)


def test_many_errors_that_bring_little_are_not_believed():
    """Ten errors and 3 % of 1,000 effective pairs: chi2 falls by 61, and ten numbers cost 69."""
    few = loop(0.97e-3, 200_000, 0.1 * NONE.prior)
    assert not believed(few, loop(1e-3, 200_000))
    assert believed(loop(0.97e-3, 200_000, 0.1 * NONE.prior[:1]), loop(1e-3, 200_000))
    assert believed(loop(0.8e-3, 200_000, 0.1 * NONE.prior), loop(1e-3, 200_000))


def test_errors_that_would_surprise_must_bring_more():
    plain = loop(1e-3, 200_000)
    assert believed(loop(0.95e-3, 200_000, NONE.prior[:1]), plain)
    assert not believed(loop(0.95e-3, 200_000, 11 * NONE.prior[:1]), plain)


def test_what_lowers_the_misfit_by_next_to_nothing_is_not_believed_however_many_pairs_there_are():
    assert not believed(loop(0.99e-3, 1e9, 0.1 * NONE.prior[:1]), loop(1e-3, 1e9))


def test_a_fit_without_any_pair_is_not_believed():
    assert not believed(loop(0.0, 0, 0.1 * NONE.prior), loop(1e-3, 200_000))
    assert not believed(loop(0.0, 0, 0.1 * NONE.prior), loop(0.0, 0))
