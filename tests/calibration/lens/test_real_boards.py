"""The Kinect v2's own boards, and challenges whose truth is known."""

import pytest


@pytest.fixture(scope="module")
def tool():
    from tools.reproduce.calibration import boards

    return boards


@pytest.mark.real
def test_kinect_v2_boards(tool, shared):
    figures = tool.kinect(shared)
    corners = figures["corners"]
    assert corners["found"] >= 0.95 * corners["pictures"]
    assert corners["rms_px"] < 0.1
    assert figures["own_55"]["rms_px_with_every_corner"] < 0.15
    assert figures["named_are_the_bad_ones"]
    for name in ("102_minus_55_in_combined_sigma", "102_minus_own_55_in_combined_sigma"):
        assert all(abs(sigmas) < 2 for sigmas in figures[name].values())


@pytest.mark.real
@pytest.mark.parametrize("name", ["turntable_v1_statue", "turntable_v2_bricks"])
def test_challenge_cameras_agree_with_their_truth(tool, shared, name):
    figures = tool.challenge(shared, name)
    # nine numbers: 3 standard deviations are not reached by chance
    assert all(abs(z) < 3 for z in figures["z"].values())
    # the maker's nominal values are wrong by 3 to 7 px over the picture
    assert figures["true_error_px_rms"] < 0.15


@pytest.mark.real
def test_charuco_of_an_azure_kinect(tool, shared):
    for figures in tool.azure(shared).values():
        assert figures["corners"] >= 60
        # the published camera is no truth to better than half a pixel of 4096
        assert figures["rms_px"] < 0.6
