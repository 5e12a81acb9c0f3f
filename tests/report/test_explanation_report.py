"""The report of an explanation: its pictures say what the verdict says, and the page reads well in a browser."""

import json
import re
from dataclasses import replace
from html import escape
from pathlib import Path

import cv2
import jsonschema
import msgspec
import numpy as np
import pytest
from browser import BINARY, Browser
from explained import explanation_of

from fusion.commands.camera.explain import verdict_lines
from fusion.discrepancy.compared import cleaned, compared
from fusion.discrepancy.held_out import held_out_of
from fusion.discrepancy.inference.tile_covariance import MeasuredTiles
from fusion.discrepancy.naming.naming import suggested
from fusion.discrepancy.unknown.unknown import unknown_of
from fusion.discrepancy.unknown.unrestricted import explained, groups_of
from fusion.discrepancy.verdict.content import Verdict
from fusion.discrepancy.verdict.verdict import verdict_of
from fusion.discrepancy.verdict.words import chance
from fusion.files.json_values import json_text, json_values
from fusion.files.schema import schema_of
from fusion.report.explanations.claim_sections import with_masks
from fusion.report.explanations.evidence import footprints_of
from fusion.report.explanations.explanation import explanation_report
from fusion.sensor.effects.light.ambient_light import AmbientLight
from fusion.sensor.effects.phase.cyclic_error import CyclicError
from fusion.sensor.effects.readout.axial_noise import AxialNoise
from fusion.sensor.files.sensor_file import read_sensor, write_sensor
from fusion.sensor.parameter import parameters
from fusion.sensor.words.in_words import in_words
from fusion.sensor.words.quantity import is_determined, quantity, shown

HOSTILE = '<script>document.title="taken"</script> onmouseover=x $\\frac{'


@pytest.fixture(scope="module")
def waved():
    return explanation_of("itof", CyclicError(amplitude=[0.004, 0.002], period=[1.9, 0.6], phase=[0.5, 1.0]))


@pytest.fixture(scope="module")
def verdict(waved):
    return verdict_of(waved)


@pytest.fixture(scope="module")
def nothing():
    return explanation_of("structured_light")


def test_a_claim_gets_a_page_and_a_mask_of_the_image_size(waved, verdict, tmp_path):
    verdict = with_masks(tmp_path, waved, verdict)
    before = json_values(verdict)
    explanation_report(tmp_path, waved, verdict)
    assert verdict.missing and json_values(verdict) == before  # what is written is final before the page is
    for entry in verdict.missing:
        mask = cv2.imread(str(tmp_path / entry.where.mask), cv2.IMREAD_UNCHANGED)
        assert mask.dtype == np.uint8 and mask.shape == waved.blocks[0].view.camera.shape
        assert mask.max() == 255
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    titles = re.findall("<h2>(.*?)</h2>", page)
    assert titles[:3] == ["Summary", "Before and after", "Missing: cyclic error"]
    assert escape(verdict.headline) in page and page.index("<b>Verdict</b>") < page.index("<b>Cyclic error</b>")
    assert "What else it could be" in page and "What to record next" in page and "What cannot be seen here" in page


def test_what_is_written_reads_as_the_same_verdict_and_fits_its_schema(verdict):
    """As other programs read it: with the published schema, which is made of the type."""
    written = json.loads(json_text(verdict))
    assert msgspec.convert(written, Verdict) == verdict
    jsonschema.validate(written, schema_of(Verdict))
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate({**written, "missing": [{"effect": "cyclic_error"}]}, schema_of(Verdict))


def test_every_wave_is_told_and_kept_with_its_deviation(waved, verdict, tmp_path):
    (claim,) = verdict.missing
    true = {"amplitude": [0.004, 0.002], "period": [1.9, 0.6], "phase": [0.5, 1.0]}
    write_sensor(tmp_path / "sensor.json", waved.sensor)
    again = read_sensor(tmp_path / "sensor.json")
    assert again.effect("cyclic_error") == waved.sensor.effect("cyclic_error") and again.std == waved.sensor.std
    for name, known in claim.parameters.items():
        std = np.array(known.all_std)
        assert known.value == known.all[0] and known.std == known.all_std[0] and all(known.all_determined)
        # five deviations of what the walls tell, which one number in a million leaves
        assert np.all(np.abs(np.array(known.all) - true[name]) < 5 * std)
        assert again.std["cyclic_error", name] == pytest.approx(std)
    # found together on this unit: the correction undoes them, although a phase may be as uncertain as it is large
    assert again.fitted == {"cyclic_error"} and again.left_out == ()


def test_the_sentence_has_the_size_and_how_sure_and_is_the_same_everywhere(waved, verdict, tmp_path):
    # rms of the two waves, over the ranges of the walls; cos of the pixels' rays makes them a little smaller
    expected = 1e3 * np.hypot(0.004, 0.002) / np.sqrt(2)
    (claim,) = verdict.missing
    assert 1e3 * claim.size.rms_m == pytest.approx(expected, rel=0.3)
    assert claim.size.rms_m < claim.size.peak_m < 0.006
    size = f"typically {1e3 * claim.size.rms_m:.2g} mm"
    headline = verdict.headline
    assert size in headline and "established" in headline and "what is left is noise" in headline
    lines = "\n".join(verdict_lines(verdict, 2000))
    assert lines.startswith(headline) and in_words(CyclicError).happens.rstrip(".") in lines
    assert re.search(r"amplitude +3\.\d+ \+- 0\.\d+ mm; [12]\.\d+ \+- 0\.\d+ mm", lines) and "chi2" not in lines
    explanation_report(tmp_path, waved, verdict)
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    first = page[: page.index("Before and after</h2>")]
    assert escape(headline) in first and "chi2" not in first
    assert page.count("<details>") >= 4  # what could be seen, what could still be there, ...: for those who ask


@pytest.mark.slow
def test_all_that_a_model_does_not_carry_far_enough_is_likely(waved, verdict):
    """Nothing is established, every name is told with all its waves, and what the model with them would leave."""
    kept = suggested(waved.named, waved.before, waved.white)
    said = verdict_of(replace(waved, named=kept))
    named = {claim.effect: claim.parameters for claim in said.indicated}
    assert not said.missing and {claim.effect for claim in verdict.missing} <= named.keys()
    assert all(claim.parameters == named[claim.effect] for claim in verdict.missing)
    # the frames of the fit are all but explained; the held-out ones are told beside it, under the model as given
    assert said.unexplained.suggested_rms_m < 0.2 * said.unexplained.rms_m
    assert "with all that is suggested" in said.headline and verdict.unexplained.suggested_rms_m is None


def test_nothing_missing_says_so_and_shows_noise(nothing, tmp_path):
    verdict = verdict_of(nothing)
    explanation_report(tmp_path, nothing, verdict)
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert verdict.nothing_missing and "Nothing is missing" in page
    assert "times as much as noise alone" in page and "Before and after" not in page
    assert not list(tmp_path.glob("mask_*"))


def test_pose_errors_are_taken_out_and_claims_stay(waved, verdict):
    covariance, n = waved.covariance, len(waved.white)
    own = np.random.default_rng(0).normal(size=n)
    noise = covariance.bare @ own
    # noise that poses cannot make is left nearly as it was: 4 walls x 6 pose directions of some hundred tiles
    assert np.linalg.norm(cleaned(covariance, covariance.whiten(noise)) - noise) < 0.5 * np.linalg.norm(noise)
    seen = compared(waved)
    assert seen.held_out and seen.changed
    assert seen.misfit[1] < 0.1 * seen.misfit[0]
    footprint = footprints_of(waved, verdict)[0]
    # to first order the claim is what the model lacked, so the sum is the residual before
    assert np.linalg.norm(footprint.white + footprint.left - waved.white) < 0.2 * np.linalg.norm(waved.white)


@pytest.mark.slow
def test_unknown_effects_and_noise_have_their_sections(nothing, tmp_path):
    u = np.concatenate([p.tiles.mean(np.broadcast_to(p.view.u, p.depth.shape)) for p in nothing.before.patches])
    # half a tenth of a pixel along the columns: some ten times what a tile may be off
    white = nothing.white + nothing.covariance.whiten(0.05 * np.sin(2 * np.pi * u / 40))
    groups = groups_of(nothing.before, nothing.covariance)
    left = explained(white, groups, np.zeros((len(white), 0)))
    named = replace(nothing.named, white=white, observations=nothing.before)
    beyond = unknown_of(white, MeasuredTiles(nothing.before, nothing.covariance), left, nothing.candidates, groups)
    unknown = replace(nothing, white=white, left=left, named=named, beyond=beyond)
    assert unknown.unknown
    verdict = with_masks(tmp_path / "a", unknown, verdict_of(unknown))
    explanation_report(tmp_path / "a", unknown, verdict)
    assert verdict.missing[0].where.mask == "mask_0.png"
    page = (tmp_path / "a" / "report.html").read_text(encoding="utf-8")
    assert "an unknown effect" in page and "The nearest entry is" in page and "Established" in page
    bright = explanation_of("itof", AmbientLight(ambient=6000.0))
    assert bright.spread
    explanation_report(tmp_path / "b", bright, verdict_of(bright))
    assert "times as large" in (tmp_path / "b" / "report.html").read_text(encoding="utf-8")


def test_frames_that_were_fitted_serve_where_none_were_held_out(waved):
    blocks = tuple(replace(block, held=None) for block in waved.blocks)
    bare = replace(waved, blocks=blocks, held=held_out_of(blocks, waved.before.sensor))
    assert not compared(bare).held_out


def test_numbers_are_said_with_the_digits_that_are_known():
    assert quantity(0.0123456, 0.0004, "m") == ("12.35", "0.40", "mm")
    assert quantity(1.5, None, "1") == ("1.5", "not given", "")
    assert quantity([0.001, 0.002], None, "m")[0] == "1, 2"
    assert "practically never" in chance(0.0)
    assert quantity(-1e-11, 0.0004, "m")[0] == "0.00"


def test_an_interval_without_meaning_is_not_determined():
    about = parameters(AxialNoise)["c0"]  # at most 1 m, usually 2 mm
    assert is_determined(about, 0.0, 0.0004) and is_determined(about, 0.3, 0.1) and is_determined(about, 0.3, None)
    assert not is_determined(about, -1e-11, 560.0) and not is_determined(about, 0.0, 0.1)
    phase = parameters(CyclicError)["phase"]
    assert is_determined(phase, 0.0, 0.5) and not is_determined(phase, 0.0, 1.8)  # of a phase that may be anything
    assert shown(-1e-11, 560.0, "m", determined=False) == "not determined"
    assert "once in 1,000 " in chance(0.001)


@pytest.mark.slow
@pytest.mark.skipif(BINARY is None, reason="no Chromium is installed")
def test_the_page_is_calm_and_fits_narrow_windows(tmp_path: Path):
    hidden = CyclicError(amplitude=[0.004], period=[1.9], phase=[0.5])
    found = explanation_of("itof", hidden, names=[HOSTILE.replace("/", ""), *"bcd"])
    explanation_report(tmp_path, found, verdict_of(found))
    with Browser(1280, 900) as browser:
        browser.open(tmp_path / "report.html")
        assert browser.console == []
        assert all(request.startswith(("file:", "data:")) for request in browser.requests)
        assert browser.evaluate("document.title") == "Simulation against recordings"
        ids = "[...document.querySelectorAll('section, svg.plot [id]')].map(e => e.id)"
        assert browser.evaluate(f"{ids}.length - new Set({ids}).size") == 0
        for width in (1280, 820, 390):
            browser.resize(width, 900)
            assert browser.evaluate("document.documentElement.scrollWidth") <= width
