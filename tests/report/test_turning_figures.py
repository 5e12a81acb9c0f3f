"""What the turntable's figures show: steps against the log, slips, the closing gap."""

from dataclasses import replace

import numpy as np
import pytest
from made_up import made_up_scan

from fusion.report.scans.turning import excess_degrees, expected_degrees, steps_figure
from fusion.report.scans.wobble import wobble_figure
from fusion.results.facts import TableFacts
from fusion.results.table_motion import ClosingGap, SlipFound, TableMotion

N = 24


def table(sign=1, log=1, slip=0.0):
    """A table that turns by `sign` 15 deg a frame, told as `log` 15 deg, and slips before frame 16."""
    angles = sign * (15.0 * np.arange(N) + slip * (np.arange(N) >= 16))
    told = np.radians(log * 15.0 * np.arange(N) + 40.0)  # a log need not begin at 0
    slips = (SlipFound(16, float(np.radians(sign * slip))),) if slip else ()
    return turned(np.radians(angles), told_rad=told, slips=slips)


def turned(angles, **more):
    return TableMotion(axis_point=np.zeros(3), axis_direction=np.array([0, 0, 1.0]), angles_rad=angles, **more)


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("log", [1, -1])
def test_a_slip_stays_as_a_jump_against_the_log(sign, log):
    content = table(sign, log, slip=3.0)
    assert expected_degrees(content)[1] == "log"
    excess = excess_degrees(content)
    assert excess[:16] == pytest.approx(0, abs=1e-9) and excess[16:] == pytest.approx(sign * 3.0)


def test_without_a_log_steps_are_judged_against_even_ones():
    content = replace(table(slip=3.0), told_rad=None)
    assert expected_degrees(content)[1] == "even"
    assert excess_degrees(content)[16:] == pytest.approx(3.0)
    assert "even steps" in steps_figure(content).caption


def test_the_steps_have_the_numbers_of_the_facts():
    facts = TableFacts(float(np.radians(6.054)), float(np.radians(0.11)), (16,))
    title = steps_figure(table(slip=3.0), facts).title
    assert title == "The table turned 6.05 deg a frame (std 0.11), slip before frame 16"


def test_frames_without_an_angle_and_a_log_of_another_length_are_harmless():
    content = table()
    content.angles_rad[5] = np.nan
    content = replace(content, told_rad=content.told_rad[:3])
    assert np.isnan(excess_degrees(content)[5]) and expected_degrees(content)[1] == "even"
    steps_figure(content)
    steps_figure(turned(np.full(2, np.nan)))


def test_the_closing_gap_is_told_before_and_after():
    report = made_up_scan()
    title = wobble_figure(report.trajectory_raw, report.turntable).title
    assert "9.40 mm, 1.78 deg before and 2.10 mm, 0.23 deg after" in title
    open_turn = replace(report.turntable, closure=ClosingGap(), closure_raw=ClosingGap())
    assert "gap" not in wobble_figure(report.trajectory_raw, open_turn).title
