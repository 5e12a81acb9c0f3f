"""Missing values: what takes them is named, a wrong threshold is corrected, and nothing where they are as predicted."""

from dataclasses import replace

import numpy as np
import pytest
from made_up_walls import looks_at, sensor_of

from fusion.discrepancy.channels.dropout import dropout_steps
from fusion.discrepancy.look import Look
from fusion.discrepancy.observations import observe
from fusion.sensor.effects.readout.amplitude_dropout import AmplitudeDropout
from fusion.sensor.effects.readout.saturation import Saturation
from fusion.sensor.sensor import Sensor

BAD = 400.0


def looks_of(*hidden, seed=1) -> list[Look]:
    return looks_at(Sensor("made up", "itof", (*sensor_of("itof").effects, *hidden)), seed)


def found_in(given, looks):
    return dropout_steps(observe(given, looks))[1]


def test_values_that_are_missing_as_predicted_are_nothing():
    given = Sensor("made up", "itof", (*sensor_of("itof").effects, AmplitudeDropout(ir_threshold=BAD)))
    for seed in range(3):
        assert found_in(given, looks_of(AmplitudeDropout(ir_threshold=BAD), seed=seed)) == ()


@pytest.mark.parametrize("hidden", [AmplitudeDropout(ir_threshold=BAD), Saturation(ir_threshold=1500.0)])
def test_what_takes_values_is_named(hidden):
    (step,) = found_in(sensor_of("itof"), looks_of(hidden))
    assert step.effect is not None and step.effect.name == hidden.name and step.channel == "dropout"
    # a twentieth: few pixels have just this amplitude
    assert step.effect.ir_threshold == pytest.approx(hidden.ir_threshold, rel=0.05)


def test_a_wrong_threshold_is_corrected_and_one_that_is_uncertain_is_left():
    given = Sensor("made up", "itof", (*sensor_of("itof").effects, AmplitudeDropout(ir_threshold=250.0)))
    looks = looks_of(AmplitudeDropout(ir_threshold=BAD))
    (step,) = found_in(replace(given, std={("amplitude_dropout", "ir_threshold"): 10.0}), looks)
    assert step.corrected and step.effect.ir_threshold == pytest.approx(BAD, rel=0.05)
    assert found_in(replace(given, std={("amplitude_dropout", "ir_threshold"): 100.0}), looks) == ()


def test_without_recorded_amplitude_nothing_is_claimed():
    looks = [replace(look, view=replace(look.view, ir=None)) for look in looks_of(AmplitudeDropout(ir_threshold=BAD))]
    assert not any(step.established for step in found_in(sensor_of("itof"), looks))


def test_holes_in_one_recording_alone_are_no_law():
    first, *others = looks_of()
    count = first.count.copy()
    count[:40, :60] = 0
    torn = replace(first, count=count, mean=np.where(count > 0, first.mean, np.nan))
    assert found_in(sensor_of("itof"), [torn, *others]) == ()
