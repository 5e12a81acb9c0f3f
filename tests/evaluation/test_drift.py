"""Drift: intervals that hold with slow noise, and a verdict on warmth."""

import numpy as np
import pytest

from fusion.evaluation.still.drift import drift_of

RATE = 2e-5  # [m/s]


def slow_noise(n: int, memory: float, rng: np.random.Generator) -> np.ndarray:
    """(n,) noise of which each value keeps this share of the one before, standard deviation 1."""
    x = rng.standard_normal(n)
    for i in range(1, n):
        x[i] = memory * x[i - 1] + np.sqrt(1 - memory**2) * x[i]
    return x


@pytest.mark.slow
@pytest.mark.parametrize("memory", [0.0, 0.9])
def test_the_interval_of_the_slope_holds_with_slow_noise(memory):
    rng = np.random.default_rng(3)
    t = np.arange(100) / 3
    held = 0
    for _ in range(40):
        low, high = drift_of(t, RATE * t + 1e-4 * slow_noise(len(t), memory, rng)).slope_interval
        held += low <= RATE <= high
    # 36 are expected of 40; 31 or fewer have a chance of 4 %
    assert held >= 32


@pytest.mark.parametrize(
    ("minutes", "size", "verdict"),
    [(10, 0.0, "ready"), (10, 0.01, "not warmed up"), (60, 0.01, "ready"), (0.05, 0.0, "too short to say")],
)
def test_the_verdict(minutes, size, verdict):
    tau = 900.0
    t = np.linspace(0, 60 * minutes, 90)
    z = size * np.exp(-t / tau) + 5e-5 * np.random.default_rng(1).standard_normal(len(t))
    found = drift_of(t, z)
    assert found.verdict == verdict
    if verdict == "not warmed up":
        # until ten minutes change less than a millimetre
        wait = (tau * np.log(size * (1 - np.exp(-600 / tau)) / 1e-3) - t[-1]) / 60
        assert found.wait_min[1] <= wait <= found.wait_min[2]
        # 50 um of noise on 5 mm of curve: some per cent
        assert found.constant == pytest.approx(tau, rel=0.1)
        assert f"wait about {found.wait_min[0]:.0f} min" in found.text


@pytest.mark.parametrize("noise", [2e-5, 1e-4])
@pytest.mark.parametrize("rate", [0.5e-3, -0.2e-3])  # [m/min]
def test_a_line_is_the_limit_of_long_time_constants_and_held(rate, noise):
    """Of one that data cannot tell from a long time constant the interval holds the line: 0 of 20 were held."""
    t, true, held = 2.0 * np.arange(300), 10 * rate, 0
    for seed in range(20):
        found = drift_of(t, rate * t / 60 + noise * np.random.default_rng(seed).standard_normal(len(t)))
        low, high = found.change_interval
        held += low <= true <= high
        assert abs(high - low) < 0.5 * abs(true)  # and tells something
        assert np.isnan(found.constant) and found.verdict == "not warmed up"
        assert found.wait_min[2] == np.inf and "no end of it is seen" in found.text
    # 18 are expected of 20; 14 or fewer have a chance of 1 %
    assert held >= 15


@pytest.mark.parametrize("tau", [900.0, 7200.0])
def test_what_bends_is_told_from_a_line(tau):
    t = np.linspace(0, 3600, 600)
    found = drift_of(t, 0.01 * np.exp(-t / tau) + 2e-5 * np.random.default_rng(5).standard_normal(len(t)))
    assert found.constant == pytest.approx(tau, rel=0.05)
    low, high = found.change_interval
    true = 0.01 * np.exp(-3600 / tau) * (np.exp(-600 / tau) - 1)
    # 20 um of noise on means of ten values, and time constants tried in steps of some per cent
    assert low - 2e-5 <= true <= high + 2e-5 and high - low < 1e-4


@pytest.mark.parametrize("t", [np.zeros(50), np.arange(3.0), np.zeros(0), np.full(20, np.nan)])
def test_without_time_nothing_is_said(t):
    found = drift_of(t, np.ones(len(t)))
    assert found.verdict == "too short to say" and np.isnan(found.slope)


def test_depths_that_never_change_for_a_moment_are_not_called_warm():
    t = np.linspace(0, 3, 90)
    assert drift_of(t, np.zeros(90)).verdict == "too short to say"
    assert drift_of(20 * t, np.zeros(90)).verdict == "ready"
