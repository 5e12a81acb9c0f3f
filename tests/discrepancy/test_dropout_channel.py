"""Missing values: what takes them is named, a wrong threshold is corrected, and nothing where they are as predicted."""

from dataclasses import replace

import numpy as np
import pytest
from made_up_walls import looks_at, sensor_of

from fusion.discrepancy.channels.dropout import dropout_steps
from fusion.discrepancy.channels.validity import FLOOR, validity_of
from fusion.discrepancy.observe.frame_block import FrameBlock
from fusion.discrepancy.observe.observations import observe
from fusion.discrepancy.unknown.table import joined
from fusion.sensor.effects.light.ambient_light import AmbientLight
from fusion.sensor.effects.readout.amplitude_dropout import AmplitudeDropout
from fusion.sensor.effects.readout.saturation import Saturation
from fusion.sensor.effects.readout.tabulated import Tabulated
from fusion.sensor.sensor import Sensor

BAD = 400.0


def blocks_of(*hidden, seed=1) -> list[FrameBlock]:
    return looks_at(Sensor("made up", "itof", (*sensor_of("itof").effects, *hidden)), seed)


def found_in(given, blocks):
    return dropout_steps(observe(given, blocks))[1]


def test_values_that_are_missing_as_predicted_are_nothing():
    given = Sensor("made up", "itof", (*sensor_of("itof").effects, AmplitudeDropout(ir_threshold=BAD)))
    for seed in range(3):
        assert found_in(given, blocks_of(AmplitudeDropout(ir_threshold=BAD), seed=seed)) == ()


@pytest.mark.parametrize("hidden", [AmplitudeDropout(ir_threshold=BAD), Saturation(ir_threshold=1500.0)])
def test_what_takes_values_is_named(hidden):
    (step,) = found_in(sensor_of("itof"), blocks_of(hidden))
    assert step.effect is not None and step.effect.name == hidden.name and step.channel == "dropout"
    # a twentieth: few pixels have just this amplitude
    assert step.effect.ir_threshold == pytest.approx(hidden.ir_threshold, rel=0.05)


def test_a_wrong_threshold_is_corrected_and_one_that_is_uncertain_is_left():
    given = Sensor("made up", "itof", (*sensor_of("itof").effects, AmplitudeDropout(ir_threshold=250.0)))
    blocks = blocks_of(AmplitudeDropout(ir_threshold=BAD))
    (step,) = found_in(replace(given, std={("amplitude_dropout", "ir_threshold"): 10.0}), blocks)
    assert step.corrected and step.effect.ir_threshold == pytest.approx(BAD, rel=0.05)
    assert found_in(replace(given, std={("amplitude_dropout", "ir_threshold"): 100.0}), blocks) == ()


def test_without_recorded_amplitude_a_threshold_has_its_name_and_no_size():
    blocks = [
        replace(block, view=replace(block.view, ir=None)) for block in blocks_of(AmplitudeDropout(ir_threshold=BAD))
    ]
    for step in found_in(sensor_of("itof"), blocks):
        assert step.effect == AmplitudeDropout() and not step.std


def lost(
    variable: str, nodes: tuple[float, ...], share: tuple[float, ...], principle="structured_light"
) -> list[FrameBlock]:
    """What is seen of walls by a sensor that loses values, and does not tell its light."""
    table = Tabulated((variable,), (nodes,), missing=np.array(share))
    seen = looks_at(Sensor("made up", principle, (*sensor_of(principle).effects, table)), seed=3)
    return [replace(block, view=replace(block.view, ir=None)) for block in seen]


FAR = ("depth", (0.5, 1.5, 3.0), (0.0, 0.08, 0.3))


def test_values_lost_with_distance_have_the_names_that_lose_them_so():
    (step,) = found_in(sensor_of("structured_light"), lost(*FAR))
    assert step.established and step.variables == ("depth",) and step.effect is not None
    assert step.effect.name == "ambient_light" and set(step.alike) <= {"amplitude_dropout"}


def test_the_model_then_loses_as_many():
    given, blocks = sensor_of("structured_light"), lost(*FAR)
    (step,) = found_in(given, blocks)
    seen = validity_of(step.added_to(given), observe(given, blocks).patches)
    # FLOOR is what a model of validity leaves open; the law is straight between five quantiles
    assert seen is not None and np.mean(np.abs(seen.missing - seen.share())) < FLOOR


def test_values_lost_near_the_camera_or_on_one_side_are_an_unknown_law():
    for law in (("depth", (0.5, 1.5, 3.0), (0.4, 0.1, 0.0)), ("u", (0.0, 111.0), (0.0, 0.3))):
        (step,) = found_in(sensor_of("structured_light"), lost(*law))
        assert step.effect is None and step.established and step.variables == (law[0],)


def test_a_model_that_holds_the_cause_is_not_told_that_it_lacks_it():
    given = Sensor("made up", "structured_light", (*sensor_of("structured_light").effects, AmbientLight(ambient=10.0)))
    assert found_in(given, lost(*FAR)) == ()


def test_tables_of_errors_and_of_missing_values_join():
    own = Tabulated(("u",), ((0.0, 111.0),), values_px=np.array([0.0, 0.1]))
    more = Tabulated(("depth",), ((0.5, 3.0),), missing=np.array([0.0, 0.4]))
    both = Sensor("made up", "structured_light", (joined(own, more),))
    view = looks_at(sensor_of("structured_light"), seed=0)[0].view
    assert view.depth is not None
    alone = [Sensor("made up", "structured_light", (table,)) for table in (own, more)]
    np.testing.assert_allclose(both.predict(view.depth, view), alone[0].predict(view.depth, view), atol=1e-6)
    np.testing.assert_allclose(both.dropout(view.depth, view), alone[1].dropout(view.depth, view), atol=1e-6)


def test_holes_in_one_recording_alone_are_no_law():
    first, *others = blocks_of()
    count = first.count.copy()
    count[:40, :60] = 0
    torn = replace(first, count=count, mean=np.where(count > 0, first.mean, np.nan))
    assert found_in(sensor_of("itof"), [torn, *others]) == ()


@pytest.mark.parametrize("variable", ["depth", "range"])
@pytest.mark.parametrize("seed", range(3))
def test_a_working_range_that_ends_is_no_law_of_light(variable, seed):
    """What comes back from far is dim: both are asked, and the likelier of the two is told."""
    table = Tabulated((variable,), ((1.899, 1.901),), missing=np.array([0.0, 1.0]))
    given, blocks = sensor_of("itof"), blocks_of(table, seed=seed)
    assert all(block.view.ir is not None for block in blocks)
    (step,) = found_in(given, blocks)
    assert step.established and step.effect is None and step.variables == (variable,)
    assert float(step.added.grid[0][0]) == pytest.approx(1.9, rel=0.02)
    seen = validity_of(step.added_to(given), observe(given, blocks).patches)
    assert seen is not None and np.mean(np.abs(seen.missing - seen.share())) < FLOOR


def test_what_is_too_near_is_no_saturation():
    table = Tabulated(("depth",), ((0.999, 1.001),), missing=np.array([1.0, 0.0]))
    (step,) = found_in(sensor_of("itof"), blocks_of(table))
    assert step.effect is None and step.variables == ("depth",)
