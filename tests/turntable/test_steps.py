"""What the angles say about the table: direction, slips, uneven steps, the closing pair."""

import numpy as np
import pytest

from fusion.scan.judging.missed import closing_pair
from fusion.turntable.steps import judge_steps

N = 40
QUIET = np.full(N, np.deg2rad(0.02))


def turned(sign=1, step=9.0, noise=0.05, seed=0):
    return np.deg2rad(sign * (step * np.arange(N)) + np.random.default_rng(seed).normal(0, noise, N))


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("log", [None, 1, -1])
def test_a_planted_slip_is_found(sign, log):
    angles = turned(sign)
    angles[25:] += np.deg2rad(2.0)
    commanded = None if log is None else np.deg2rad(log * 9.0 * np.arange(N))
    steps = judge_steps(angles, QUIET, commanded)
    assert [s.frame for s in steps.slips] == [25]
    # two angles with 0.05 deg of noise each: 4 sigma
    assert np.rad2deg(steps.slips[0].angle) == pytest.approx(2.0, abs=0.3)
    assert steps.direction == sign
    assert np.rad2deg(steps.mean) == pytest.approx(sign * 9.0, abs=0.02)
    assert any("slip of" in w and "frame 25" in w for w in steps.warnings)
    assert any("sign of its log" in w for w in steps.notes) == (log == -sign)


@pytest.mark.parametrize("commanded", [None, np.deg2rad(9.0 * np.arange(N))])
def test_even_steps_have_no_slip_and_no_warning(commanded):
    steps = judge_steps(turned(), QUIET, commanded)
    assert steps.slips == () and steps.warnings == steps.notes == () and steps.direction == 1
    assert np.rad2deg(steps.std) < 0.15  # sqrt(2) * 0.05 expected


def test_less_than_a_degree_is_no_slip():
    angles = turned(noise=0.0)
    angles[25:] += np.deg2rad(0.8)
    assert judge_steps(angles, QUIET).slips == ()


def test_rejected_frames_are_no_slip_and_a_slip_behind_them_is_placed_after():
    angles = turned()
    angles[[3, 10, 11, 12]] = np.nan
    assert judge_steps(angles, QUIET).slips == ()
    angles[11:] += np.deg2rad(3.0)  # somewhere in frames that nobody saw
    assert [s.frame for s in judge_steps(angles, QUIET).slips] == [13]


def test_uneven_steps_known_to_the_log_are_no_slip():
    commanded = np.deg2rad(np.cumsum(np.resize([5.0, 12.0, 7.0], N)))
    steps = judge_steps(commanded - commanded[0] + 1e-4 * np.resize([1, -1], N), QUIET, commanded)
    assert steps.slips == ()


def test_uneven_steps_and_turning_back_are_told():
    steps = judge_steps(turned(noise=0.7), QUIET)
    assert any("uneven" in w for w in steps.notes)
    angles = turned()
    angles[20:] -= np.deg2rad(15)
    assert any("turns back" in w and "20" in w for w in judge_steps(angles, QUIET).warnings)


@pytest.mark.parametrize("sign", [1, -1])
def test_the_closing_pair_is_a_full_turn_apart(sign):
    angles = sign * np.deg2rad(15.0 * np.arange(30))
    i, j = closing_pair(angles)
    assert abs(angles[j] - angles[i]) == pytest.approx(2 * np.pi)
    angles[i] = np.nan
    again = closing_pair(angles)
    assert again is not None and i not in again


def test_an_open_turn_closes_from_end_to_end():
    assert closing_pair(np.deg2rad(15.5 * np.arange(23))) == (0, 22)  # 341 deg


@pytest.mark.parametrize("angles", [np.deg2rad(np.arange(0, 200, 10)), np.full(5, np.nan), np.zeros(1)])
def test_half_a_turn_has_no_closing_pair(angles):
    assert closing_pair(angles) is None


@pytest.mark.parametrize("frames", [8, 12, 25])
def test_few_noisy_frames_show_no_slip(frames):
    """Angles known to 0.5 deg, as from few pixels: their own noise makes steps of 1.5 deg, and says so."""
    for seed in range(20):
        noise = np.random.default_rng(seed).normal(0, 0.5, frames)
        angles = np.deg2rad(15.0 * np.arange(frames) + noise)
        assert judge_steps(angles, np.full(frames, np.deg2rad(0.5)), np.deg2rad(15.0 * np.arange(frames))).slips == ()


@pytest.mark.parametrize("place", [1, 12, N - 2])
def test_one_wrong_frame_is_no_slip(place):
    """A frame placed 3 deg off makes two opposite steps; the object did not stay turned."""
    angles = turned()
    angles[place] += np.deg2rad(3.0)
    assert judge_steps(angles, QUIET).slips == ()


@pytest.mark.parametrize("place", [1, 2, N - 2, N - 1])
def test_a_slip_near_an_end_is_found(place):
    angles = turned()
    angles[place:] += np.deg2rad(2.0)
    assert [s.frame for s in judge_steps(angles, QUIET).slips] == [place]


def test_a_slip_between_badly_known_frames_is_not_claimed():
    angles, std = turned(), QUIET.copy()
    angles[25:] += np.deg2rad(2.0)
    std[[24, 25]] = np.deg2rad(0.5)  # 2 deg are 2.8 standard deviations of this step
    assert judge_steps(angles, std).slips == ()
    std[[24, 25]] = np.deg2rad(0.2)  # and here 7
    assert [s.frame for s in judge_steps(angles, std).slips] == [25]


def test_a_careful_fit_does_not_hide_a_slip():
    """Standard deviations that count from the first frame are larger than what the steps themselves show."""
    angles = turned(noise=0.1)
    angles[25:] += np.deg2rad(3.0)
    assert [s.frame for s in judge_steps(angles, np.full(N, np.deg2rad(1.0))).slips] == [25]


@pytest.mark.parametrize("times", [2, 3, 5])
@pytest.mark.parametrize("sign", [1, -1])
def test_doubled_frames_are_named_and_are_no_slips(times, sign):
    angles = np.repeat(turned(sign), times) + np.random.default_rng(1).normal(0, 1e-4, N * times)
    steps = judge_steps(angles, np.repeat(QUIET, times))
    assert steps.slips == () and steps.warnings == ()
    assert np.rad2deg(steps.mean) == pytest.approx(sign * 9.0, abs=0.05) and np.rad2deg(steps.std) < 0.15
    assert steps.rests == N * (times - 1)


def test_a_slip_between_doubled_frames_is_found():
    angles = np.repeat(turned(), 2)
    angles[50:] += np.deg2rad(3.0)
    assert [s.frame for s in judge_steps(angles, np.repeat(QUIET, 2)).slips] == [50]


def test_a_hand_that_rests_now_and_then_is_no_doubled_frame():
    steps = np.random.default_rng(3).uniform(5, 40, N)
    steps[[7, 20]] = 0.0
    assert judge_steps(np.deg2rad(np.cumsum(steps)), QUIET).rests == 0


@pytest.mark.parametrize(("back_deg", "told"), [(0.1, False), (0.2, True)])
def test_a_step_back_is_told_beyond_the_noise(back_deg, told):
    """Three deviations of a step of two angles, and a milliradian: 0.14 degrees."""
    steps = np.full(N - 1, np.deg2rad(9.0))
    steps[20] = -np.deg2rad(back_deg)
    found = judge_steps(np.concatenate([[0.0], np.cumsum(steps)]), QUIET)
    assert any("turns back before frames [21]" in warning for warning in found.warnings) == told
