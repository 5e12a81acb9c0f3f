"""What pages say to record of each effect, and what the answer to it is worth."""

import pytest

from fusion.sensor.effects import EFFECTS
from fusion.simulation.scenes import built_in
from tools.documentation.effect_pages.recordings import ADVICE, SERIES, advice
from tools.reproduce.named_effects import judged, planted


def claim(name, *alike):
    return {"effect": name, "indistinguishable_from": list(alike)}


def verdict(missing=(), indicated=(), invisible=()):
    return {"missing": list(missing), "indicated": list(indicated), "invisible": list(invisible)}


def test_each_effect_has_its_recordings_and_no_series_is_left():
    assert set(ADVICE) == {kind.name for kind in EFFECTS}
    assert set().union(*ADVICE.values()) == set(SERIES)
    assert all(advice(name)[0].isupper() and advice(name).endswith(".") for name in ADVICE)


def test_each_recording_can_be_made():
    for series in SERIES.values():
        for take in series.takes:
            assert len(built_in(take.scene, take.settings).course) > 0


def test_what_is_planted_is_what_the_page_shows():
    for kind in EFFECTS:
        assert isinstance(planted(kind), kind) and planted(kind) != kind()


@pytest.mark.parametrize(
    ("said", "outcome"),
    [
        (verdict([claim("defocus")]), "named"),
        (verdict([claim("mixed_pixels", "defocus")]), "set"),
        (verdict([claim("mixed_pixels", "a", "b", "defocus")]), "indicated"),
        (verdict([claim("unknown")]), "WRONG"),
        (verdict([claim("defocus"), claim("depth_scale")]), "WRONG"),
        (verdict(indicated=[claim("defocus")]), "indicated"),
        (verdict(invisible=["defocus"]), "invisible"),
        (verdict(), "silent"),
    ],
)
def test_an_answer_is_worth(said, outcome):
    assert judged("defocus", said).outcome == outcome


def test_a_table_of_any_shape_is_rightly_unknown():
    assert judged("tabulated", verdict([claim("unknown")])).outcome == "named"
