"""The table's log and the measured angles together."""

import numpy as np
import pytest

from fusion.turntable.all_views.log import departure, log_equations, with_log

N = 200
STEP = np.deg2rad(5.0)


def table(scatter_deg, noise_deg, seed=0, slip_deg=0.0):
    """What the log says, how far the table turned, and what was measured."""
    rng = np.random.default_rng(seed)
    told = STEP * np.arange(N)
    steps = STEP + np.deg2rad(scatter_deg) * rng.normal(size=N - 1)
    steps[N // 2] += np.deg2rad(slip_deg)
    true = np.concatenate([[0.0], np.cumsum(steps)])
    measured = true + np.deg2rad(noise_deg) * rng.normal(size=N)
    return told, true, measured - measured[0], np.full(N, np.deg2rad(noise_deg))


def rms_deg(angles, true):
    error = np.rad2deg(angles - true)
    return float(np.nanstd(error))


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_steady_table_halves_the_noise(sign):
    told, true, measured, std = table(0.03, 0.1)
    found = with_log(measured, std, sign * told)
    # for a random walk of s and noise of r, theory says r * sqrt(s / 2 r) = 0.04 deg; half as much
    # again as the scatter must be found
    assert rms_deg(found, true) < 0.06
    assert found[0] == 0


def test_an_uneven_table_changes_little_and_harms_nothing():
    told, true, measured, std = table(1.0, 0.1)
    assert np.rad2deg(np.abs(with_log(measured, std, told) - measured)).max() < 0.15  # a tenth of what the log is off
    assert rms_deg(with_log(measured, std, told), true) < 1.02 * rms_deg(measured, true)


def test_angles_that_err_about_a_place_are_not_pulled_to_the_log():
    """A drive that stops a little off each place: its steps scatter more than the views do, and add up to nothing."""
    rng = np.random.default_rng(3)
    told = STEP * np.arange(N)
    true = told + np.deg2rad(0.4) * rng.normal(size=N)
    measured = true + np.deg2rad(0.1) * rng.normal(size=N)
    found = with_log(measured - measured[0], np.full(N, np.deg2rad(0.1)), told)
    assert rms_deg(found, true) < 1.05 * rms_deg(measured, true)  # of little use: at most a twentieth worse


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_steps_that_were_told_to_differ_are_followed(sign):
    rng = np.random.default_rng(4)
    true = np.cumsum(np.deg2rad(rng.uniform(2, 8, N)))
    measured = true + np.deg2rad(0.1) * rng.normal(size=N)
    found = with_log(measured - measured[0], np.full(N, np.deg2rad(0.1)), sign * true)
    assert rms_deg(found, true) < 0.6 * rms_deg(measured, true)  # as beside a steady table


def test_a_slip_stays_whole():
    told, true, measured, std = table(0.05, 0.1, slip_deg=4.0)
    found = with_log(measured, std, told)
    jump = np.rad2deg(found[N // 2 + 1] - found[N // 2] - STEP)
    assert jump == pytest.approx(4.0, abs=0.3)  # three standard deviations of a step
    assert rms_deg(found, true) < rms_deg(measured, true)


def test_rejected_frames_stay_out_and_few_frames_stay_as_they_are():
    told, _, measured, std = table(0.05, 0.1)
    measured[[3, 4, 50]] = np.nan
    found = with_log(measured, std, told)
    assert np.flatnonzero(np.isnan(found)).tolist() == [3, 4, 50]
    assert np.array_equal(with_log(measured[5:25], std[5:25], told[5:25]), measured[5:25], equal_nan=True)


def test_a_log_is_no_better_than_its_steps_and_does_not_pull_slips_back():
    told, _, measured, _ = table(1.0, 0.1, slip_deg=8.0)
    known, weight, excess = log_equations(measured, told)
    assert len(known) == N and excess == pytest.approx(np.diff(measured) - np.diff(told))
    slip = N // 2
    usual = np.median(np.delete(weight, slip))
    # the spread about zero is 1 deg: a usual step counts as that, or a little less
    assert np.rad2deg(usual**-0.5) == pytest.approx(1.1, abs=0.25)
    pull = weight * np.abs(excess)
    assert pull[slip] < 0.2 * np.max(np.delete(pull, slip))
    assert np.isfinite(log_equations(told, told)[1]).all()  # a log that is followed exactly is not exact


def test_frames_left_out_make_longer_steps():
    told, _, measured, _ = table(1.0, 0.1)
    measured[[5, 6, 7]] = np.nan
    known, weight, _ = log_equations(measured, told)
    assert len(known) == N - 3 and weight[4] < 0.7 * np.median(weight)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_smooth_departure_from_the_log_is_told_from_uneven_steps_and_slips(sign):
    for seed in range(5):
        told, _, measured, _ = table(0.5, 0.1, seed, slip_deg=6.0)
        left, allowed = departure(measured, sign * told, [N // 2 + 1])
        assert left < allowed
    told, _, measured, _ = table(0.1, 0.05)
    bent = measured + np.deg2rad(9.0) * np.sin(np.linspace(0, 6 * np.pi, N))
    left, allowed = departure(bent, sign * told)
    assert left > 2 * allowed and np.rad2deg(left) == pytest.approx(9.0, abs=1.0)


def test_a_table_that_wanders_off_its_log_is_followed_though_the_angles_are_stated_too_uncertain():
    told, true, measured, std = table(0.3, 0.1)
    found = with_log(measured, 10 * std, told)
    assert rms_deg(found, true) < 1.02 * rms_deg(measured, true)
