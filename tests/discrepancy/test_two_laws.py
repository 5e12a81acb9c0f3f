"""A wave of which only a part is seen may be an offset with a slope; of which much is seen, not."""

import numpy as np
from made_up_walls import looks_at, sensor_of

from fusion.discrepancy.gauge import gauge_of
from fusion.discrepancy.naming.beside import beside
from fusion.discrepancy.naming.candidates import candidate_of, candidates_of
from fusion.discrepancy.naming.part import Part
from fusion.discrepancy.naming.refit import refitted
from fusion.discrepancy.naming.two import like_two
from fusion.discrepancy.observations import observe
from fusion.sensor.effects.phase.cyclic_error import CyclicError
from fusion.sensor.forms import forms_of


def rivals(period: float, amplitude: float) -> tuple[str, ...]:
    """Of a wave that is there and named."""
    hidden = CyclicError(amplitude=amplitude, period=period, phase=0.5)
    observations = observe(sensor_of("itof"), looks_at(sensor_of("itof", hidden), 2))
    gauge = gauge_of(observations)
    form = next(f for f in forms_of(CyclicError, (80, 112)))
    wave = candidate_of(observations, gauge, type(form)(form.kind, {"period": period}, form.atoms, join=form.join))
    fit = refitted([Part(wave, np.ones(2))], observations, gauge)
    space, _ = beside(fit, 0)
    others = [c for c in candidates_of(observations, gauge) if c.name != "cyclic_error"]
    return like_two(fit, fit.parts[0], others, space)


def test_half_a_wave_may_be_two_plain_laws_and_two_waves_not():
    assert len(rivals(8.0, 0.02)) == 2
    assert rivals(0.8, 0.004) == ()
