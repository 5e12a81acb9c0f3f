"""A real box on a real turntable, without any reference: what geometry and the stickers in the colour images demand."""

import pytest

pytestmark = [pytest.mark.real, pytest.mark.slow]


@pytest.fixture(scope="module")
def measured(shared):
    """Figures of the tool without any option, and with the camera as stated."""
    from tools.reproduce.scans.kleenex_turntable import measure

    return {refine: measure(shared / "data/kleenex_turntable", refine)[0] for refine in (True, False)}


@pytest.mark.parametrize("refine", [True, False])
def test_all_frames_are_used_and_the_background_is_gone(measured, refine):
    found = measured[refine]
    assert found["frames_used"] == found["frames"] == 23
    assert found["parts"] == 1
    assert max(found["size_mm"]) < 200  # the box of about 12 cm with its tissue; the stated camera shows it 9 % larger


@pytest.mark.parametrize("refine", [True, False])
def test_each_side_is_one_plane(measured, refine):
    found = measured[refine]
    assert max(found["plane_rms_mm"]) < 2.5  # measured 0.3 to 0.5 and 0.5 to 0.7: cardboard and a Kinect at 0.7 m
    assert max(found["area_off_the_plane"]) < 0.01  # no second wall
    assert min(found["plane_area_kept"]) > 0.98


def test_the_sides_stand_at_right_angles(measured):
    found = measured[True]
    assert found["neighbours_deg"] == pytest.approx([90] * 4, abs=1.5)
    assert max(found["opposite_deg"]) < 1.5


@pytest.mark.parametrize("refine", [True, False])
def test_angles_are_near_those_of_the_stickers(measured, refine):
    found = measured[refine]
    # measured 1.10 and 0.73 both times; the stickers' own turn is known to 0.25 to 0.4 deg
    assert found["off_stickers_max_deg"] < 1.3 and found["off_stickers_rms_deg"] < 0.9
    assert found["total_deg"] == pytest.approx(342.8, abs=1.5)  # 1.2 is three standard errors of the stickers' total


@pytest.mark.xfail(reason="measured 1.10 deg in both cases", strict=False)
@pytest.mark.parametrize("refine", [True, False])
def test_angles_within_one_degree_of_the_stickers(measured, refine):
    assert measured[refine]["off_stickers_max_deg"] < 1.0


def test_the_wrong_focal_length_is_told_first(measured):
    """525 px are stated; the stickers alone say some 585 px."""
    assert measured[False]["focal_length_check"] > 0.05
    assert measured[False]["warnings"][0].startswith("Camera: The object keeps its shape only with")
    assert measured[False]["fx_px"] == 525.0


def test_it_is_corrected_by_itself_as_the_camera_is_only_nominal(measured):
    assert measured[True]["warnings"][0].startswith("Camera: The focal length is corrected")
    assert measured[True]["fx_px"] == pytest.approx(572, abs=10)  # 1.7 %: two standard deviations of the scan's own
    # the extents along the object's axes of a box that stands turned on its plate; its sides are 116 to 118 mm apart;
    # they go as one over the focal length, which is asked above
    size = [extent * measured[True]["fx_px"] / 572 for extent in measured[True]["size_mm"][:2]]
    assert size == pytest.approx([133, 134], rel=0.01)
    assert max(measured[True]["plane_rms_mm"]) < 0.6
    assert measured[True]["neighbours_deg"] == pytest.approx([90] * 4, abs=1.0)
