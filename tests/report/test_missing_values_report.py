"""A claim on missing values has its section with a curve and a mask picture."""

import pytest
from explained import explanation_of

from fusion.discrepancy.verdict.verdict import verdict_of
from fusion.report.explanations.claim_sections import with_masks
from fusion.report.explanations.explanation import explanation_report
from fusion.sensor.effects.readout.amplitude_dropout import AmplitudeDropout


@pytest.mark.slow
def test_missing_values_have_their_section(tmp_path):
    found = explanation_of("itof", AmplitudeDropout(ir_threshold=400.0))
    verdict = with_masks(tmp_path, found, verdict_of(found))
    explanation_report(tmp_path, found, verdict)
    (claim,) = [entry for entry in verdict.missing if entry.channel == "dropout"]
    assert claim.effect == "amplitude_dropout" and (tmp_path / claim.where.mask).is_file()
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "of the values are missing beyond what the model loses" in page and "missing values [%]" in page
