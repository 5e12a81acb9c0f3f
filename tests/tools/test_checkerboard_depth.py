"""The real checkerboard of a Kinect v2: brightness moves the depth, and a law with it in holds on views left out."""

from pathlib import Path

import numpy as np
import pytest

from tools.reproduce.calibration import checkerboard_depth


@pytest.fixture
def at() -> checkerboard_depth.Squares:
    """Squares of 40 views whose depth has an offset of 30 mm, a scale of -2 % and noise of 5 mm."""
    rng = np.random.default_rng(0)
    depth = rng.uniform(0.5, 1.5, 40 * 24)
    error = 0.03 - 0.02 * depth + rng.normal(0, 0.005, depth.size)
    view, whole = np.repeat(np.arange(40), 24), np.zeros(depth.size)
    return checkerboard_depth.Squares(view, np.zeros((depth.size, 2), np.intp), depth, error, whole, whole > 0)


def test_a_line_is_undone_like_a_law(at: checkerboard_depth.Squares):
    use = np.arange(len(at.view)) % 2 == 0
    left = checkerboard_depth.straight(at, use)
    slope, offset = np.polyfit(at.depth[use], at.error[use], 1)
    corrected = (at.depth + at.error - offset) / (1 + slope)
    np.testing.assert_allclose(left["line_undone"], corrected - at.depth, atol=1e-12)  # rounding
    # a law that is that line is no better and no worse than it, but 2 % worse than what the line leaves unscaled
    assert checkerboard_depth.share_of(at, corrected - at.depth, left["line_undone"])[0] == pytest.approx(1)
    assert checkerboard_depth.share_of(at, corrected - at.depth, left["line"])[0] == pytest.approx(1 / (1 + slope))


def test_a_share_is_known_as_well_as_its_views_are_many(at: checkerboard_depth.Squares):
    rng = np.random.default_rng(1)
    found = []
    for _ in range(200):
        law, line = rng.normal(size=(2, len(at.view)))
        found.append(checkerboard_depth.share_of(at, law, line))
    shares, deviations = np.array(found).T
    # each variance of n numbers is known to sqrt(2 / n), a root to half of that, and the share holds two of them:
    # 1 / sqrt(960) = 0.032; of 200 shares that spread is known to 5 %, four deviations are 20 %
    assert np.std(shares) == pytest.approx(np.sqrt(1 / len(at.view)), rel=0.2)
    assert np.mean(deviations) == pytest.approx(np.std(shares), rel=0.2)


@pytest.mark.real
@pytest.mark.slow
def test_the_brightness_dependence_is_found(shared: Path, tmp_path: Path):
    found = checkerboard_depth.measure(shared, tmp_path, folds=3)
    # dark squares read 6 to 8 mm farther than bright ones beyond 1 m: 7.0 mm by medians of 3 x 3 px
    assert 6.0 < found["dark_less_bright_beyond_1_m_mm"] < 8.0
    # and the law takes more than half of it out (3.1 mm the other way round are left)
    assert abs(found["the_same_after_correction_mm"]) < 4.0
    assert all("brightness" in law or "amplitude" in law for law in found["laws_chosen"])
    # 0.87 to 0.89 of a line with five and eleven folds; 0.85 is asked for and not reached, which the verdict says
    assert found["share_of_line"] < 0.95
    assert ("NOT reached" in found["verdict"]) == (found["share_of_line"] > checkerboard_depth.ASKED)
