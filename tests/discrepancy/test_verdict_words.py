"""Sentences of a verdict say nothing that its numbers deny."""

import numpy as np
import pytest

from fusion.commands.camera.explain import _row
from fusion.discrepancy.inference.camera_file import FileError
from fusion.discrepancy.observe.single_pixels import SinglePixel
from fusion.discrepancy.verdict.claim import Claim, ClaimedNumber, ClaimEvidence, Size, Where
from fusion.discrepancy.verdict.content import Nuisances
from fusion.discrepancy.verdict.setting_words import setting_words
from fusion.discrepancy.verdict.sizes import _of
from fusion.discrepancy.verdict.words import AT_EDGES, _alone, size_of


@pytest.mark.parametrize("few", [0, 1, 4, 10, 40])
def test_typical_is_never_more_than_the_most(few):
    """However few of the tiles hold all of an effect."""
    size = _of(np.concatenate([np.full(100, 0.001), np.full(few, 0.8)]))
    assert size.rms_m <= size.peak_m * (1 + 1e-9)
    assert size.peak_m == pytest.approx(0.8 if few else 0.001)


def settings(**off: float) -> str:
    wrong = FileError(**off)
    return setting_words(
        Nuisances(pose_factor=1.0, shape_rms_m=0.0, mesh_scale=0.0, mesh_off_m=0.0, drift_rms_m=0.0, camera_file=wrong)
    )


def test_a_camera_file_is_told_to_be_wrong_by_what_can_be_read():
    assert settings() == settings(cx=-0.04, cy=0.01, focal=-0.0004) == ""
    told = settings(cx=-0.04, cy=0.12, focal=-0.002)
    assert told == ", the camera file seems wrong: cy by +0.1 px, focal length by -0.2 %"


def test_single_pixels_are_counted_and_some_are_named():
    assert _alone([]) == ""
    assert _alone([SinglePixel(3, 4)]) == ", left out is a single pixel that is off in most recordings: (3, 4)"
    assert _alone([SinglePixel(k, 4) for k in range(5)]).endswith(": (0, 4), (1, 4), (2, 4) and 2 more")


@pytest.mark.parametrize("label", ["rms", "ir_threshold", "ir_reference", "a_long_long_name"])
def test_a_name_and_its_number_stand_apart(label):
    assert f"{label} " in _row(label, "641.8 count", 80)[0]


@pytest.mark.parametrize(
    ("effect", "label", "number", "told"),
    [
        (
            "lateral_noise",
            "sigma_px",
            ClaimedNumber(value=0.7, std=0.05, unit="px"),
            "sigma 0.700 +- 0.050 px at depth edges",
        ),
        ("mixed_pixels", "fill", ClaimedNumber(value=0.8, std=0.1, unit="1"), "fill 0.80 +- 0.10 at depth edges"),
    ],
)
def test_what_edges_show_is_told_by_its_own_size_and_not_by_the_step_behind_them(effect, label, number, told):
    claim = Claim(
        effect=effect, parameters={label: number}, channel="bias", size=Size(rms_m=0.054, peak_m=0.108),
        where=Where(variables=("edge",), text=f"{AT_EDGES}: jitter"), indistinguishable_from=(), record_next="",
        evidence=ClaimEvidence(heldout_gain=0.2, false_alarm_probability=1e-7, visible_share=1.0),
    )  # fmt: skip
    assert told in size_of(claim) and "mm" not in size_of(claim)
