"""One set of turns is found with which most of what pairs of views say agrees."""

import numpy as np

from fusion.turntable.guess.labels import Said, consistent, unwound


def said(true, wrong=(), random=None, least=0.3):
    """What all pairs nearer than 60 degrees say, and what wrong ones say."""
    pairs, turns, worth = [], [], []
    for i in range(len(true)):
        for j in range(i + 1, len(true)):
            turn = (true[j] - true[i] + np.pi) % (2 * np.pi) - np.pi
            if abs(turn) < np.deg2rad(60):
                pairs.append((i, j))
                turns.append(turn + random.normal(0, np.deg2rad(0.5)))
                worth.append(random.uniform(least, 1.0))
    for i, j, turn, value in wrong:
        pairs.append((i, j))
        turns.append(turn)
        worth.append(value)
    return Said(np.array(pairs), np.array(turns), np.array(worth))


def off(found, true):
    """Largest difference [deg] up to a constant turn."""
    apart = np.exp(1j * (found - true))
    return np.rad2deg(np.abs(np.angle(apart / np.mean(apart) * abs(np.mean(apart)))).max())


def test_uneven_steps_in_both_directions_are_put_together():
    random = np.random.default_rng(3)
    for sign in (-1, 1):
        true = sign * np.cumsum(np.deg2rad(random.uniform(11, 55, 22)))
        assert off(consistent(22, said(true, random=random)), true) < 3.0  # cells of two degrees, and half a degree


def test_wrong_matches_are_outvoted_by_all_others():
    """A box looks alike from both sides: half of all pairs across say no turn where there are 180 degrees."""
    random = np.random.default_rng(4)
    true = np.cumsum(np.deg2rad(random.uniform(12, 25, 20)))
    wrong = [(k, k + 10, 0.1, 0.3) for k in range(10)]
    assert off(consistent(20, said(true, wrong, random)), true) < 3.0


def test_unwound_takes_the_shorter_way():
    turns = np.deg2rad([0.0, 50, 110, 170, 200, 180, 240, 310, 10])
    assert np.allclose(np.rad2deg(unwound(turns)), [0, 50, 110, 170, 200, 180, 240, 310, 370])


def test_a_stretch_that_hangs_on_wrong_matches_is_put_right():
    """Views 7 to 12 agree with each other, and both ends with their neighbours wrongly; all others outvote these."""
    random = np.random.default_rng(6)
    true = np.cumsum(np.deg2rad(random.uniform(15, 25, 20)))
    right = said(true, random=random)
    across = np.sum((right.pairs >= 7) & (right.pairs <= 12), axis=1) == 1
    worth = np.where(across, 0.3, 1.0) * right.worth
    lies = ((right.pairs == (6, 7)) | (right.pairs == (12, 13))).all(axis=1)
    turns = np.where(lies, right.turns - np.deg2rad(75), right.turns)
    turns[lies] *= (1, -1)
    assert off(consistent(20, Said(right.pairs, turns, np.where(lies, 0.6, worth))), true) < 3.0
