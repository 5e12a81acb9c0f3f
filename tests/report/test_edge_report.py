"""A claim at depth edges has its section: the profile across them."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).parents[1] / "discrepancy"))
from made_up_walls import sensor_of
from test_edge_channel import boards

from fusion.discrepancy.explain import explained_looks
from fusion.discrepancy.verdict.verdict import verdict_of
from fusion.report.explanations.claim_figures import LENGTH
from fusion.report.explanations.claim_sections import claim_sections
from fusion.sensor.effects.optics.defocus import Defocus


def test_a_blurred_edge_has_its_section():
    known = sensor_of("itof")
    found = explained_looks(boards(sensor_of("itof", Defocus(width=0.7))), known)
    verdict = verdict_of(found)
    (claim,) = verdict.missing
    assert claim.effect == "defocus" and claim.channel == "bias" and claim.evidence.posterior > 0.95
    assert claim.where.text.startswith("across depth edges") and "defocus" not in verdict.invisible
    (section,) = claim_sections(found, verdict, LENGTH)
    (figure,) = section.figures
    assert "depth edges" in section.title and "Profile across depth edges" in figure.alt + figure.svg
