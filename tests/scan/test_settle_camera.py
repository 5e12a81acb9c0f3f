"""A focal length is replaced only where it is nominal, contradicted, and the scan fits better with the other."""

from dataclasses import replace

import numpy as np
import pytest
from made_up_scan import CAMERA, good_scan

from fusion.recording.recording import Recording
from fusion.scan.finding import settled_camera as module
from fusion.scan.finding.attempt import Attempt
from fusion.scan.finding.pair_fit import Asked, PairFit
from fusion.scan.finding.settled_camera import settle_camera
from fusion.scan.settings import ScanSettings
from fusion.sensor.presets import default_sensor
from fusion.turntable.selfcheck import NAMES
from fusion.turntable.views import Region

CALIBRATED = replace(CAMERA, std={"fx": 0.6})
RIGHT = 620.0
BETTER, WORSE = 0.7, 1.3


def found(camera, residual, share=1.0, asked=None) -> Attempt:
    """An attempt that asks for `share` of the way to the right focal length, known to 0.5 %."""
    good = good_scan().motion
    values = np.zeros(len(NAMES))
    values[0] = share * np.log(RIGHT / camera.fx)
    motion = replace(
        good, residual=np.full(36, residual), focal_check=replace(good.focal_check, values=values), focal_std=0.005
    )
    recording = Recording("native", None, camera, np.arange(36) / 10, lambda i: None)
    whole = Asked(recording, default_sensor(camera), ScanSettings(refine_camera=asked))
    fit = PairFit(motion, None, None)
    return Attempt(whole, Region(np.zeros(3), np.ones(3)), [None] * 36, fit, None, {})


def settled(monkeypatch, camera, asked, then, share=1.0):
    """What is settled where the other focal length changes the residual by a factor `then`."""
    monkeypatch.setattr(module, "seen_by", lambda camera, _: found(camera, 0.002 * then, share, asked))
    return settle_camera(found(camera, 0.002, share, asked))


@pytest.mark.parametrize(
    ("camera", "asked", "then", "taken"),
    [
        (CAMERA, None, BETTER, True),
        (CAMERA, None, WORSE, False),
        (CALIBRATED, None, BETTER, False),
        (CAMERA, False, BETTER, False),
        (CALIBRATED, True, WORSE, True),
        (replace(CAMERA, fx=RIGHT * 1.01), None, BETTER, False),
    ],
)
def test_when_it_is_taken(monkeypatch, camera, asked, then, taken):
    final, focal = settled(monkeypatch, camera, asked, then)
    assert (final.camera.fx != camera.fx) == taken
    if taken:
        assert final.camera.fx == pytest.approx(RIGHT, rel=1e-6)
        assert focal.relative == pytest.approx(RIGHT / camera.fx - 1, rel=1e-6)


def test_a_claim_that_helps_nothing_is_withdrawn(monkeypatch):
    _, focal = settled(monkeypatch, CALIBRATED, None, WORSE)
    assert focal.deviations(CALIBRATED) <= 1


def test_a_claim_against_a_calibrated_camera_stands_where_it_fits_better(monkeypatch):
    _, focal = settled(monkeypatch, CALIBRATED, None, BETTER)
    assert focal.deviations(CALIBRATED) > 5


def test_what_a_first_round_leaves_a_second_takes(monkeypatch):
    final, _ = settled(monkeypatch, CAMERA, None, BETTER, share=0.9)
    assert final.camera.fx == pytest.approx(RIGHT, rel=0.001)


def test_what_the_camera_itself_may_be_wrong_by_counts():
    vague = replace(CAMERA, std={"fx": 0.05 * CAMERA.fx})
    claim = module.focal_of(found(CAMERA, 0.002).fit.motion, CAMERA)
    assert claim.deviations(vague) < 2 < 5 < claim.deviations(CALIBRATED)
