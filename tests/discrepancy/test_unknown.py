"""What no entry explains gets a form, a frame, a table that corrects and simulates, and a reason for no name."""

from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import ClassVar

import numpy as np
import pytest
from made_up_walls import looks_at, sensor_of

from fusion.discrepancy.explain import explained_looks
from fusion.discrepancy.inference.tile_covariance import MeasuredTiles, covariance_of
from fusion.discrepancy.naming.search.candidates import candidates_of
from fusion.discrepancy.naming.search.score import scored
from fusion.discrepancy.observe.observations import observe
from fusion.discrepancy.observe.tiles import tiling
from fusion.discrepancy.unknown.families import ShapeFunction
from fusion.discrepancy.unknown.in_place import explains_more
from fusion.discrepancy.unknown.law import law_of
from fusion.discrepancy.unknown.search import _plainest
from fusion.discrepancy.unknown.table import joined, span_of
from fusion.discrepancy.unknown.terms import UnknownTerm
from fusion.discrepancy.unknown.unknown import unknown_of
from fusion.discrepancy.unknown.unrestricted import explained, groups_of
from fusion.discrepancy.verdict.unknown_claim import unknown_claim
from fusion.sensor.effect import Effect
from fusion.sensor.effects.readout.tabulated import Tabulated
from fusion.sensor.files.sensor_file import read_sensor, write_sensor
from fusion.sensor.view import Image, View

PERIOD = 37.0
FINE = 24.0


@dataclass(frozen=True)
class RowWave(Effect):
    """A law of no catalogue: a wave from row to row, larger at a distance."""

    name: ClassVar[str] = "row_wave"

    def bias(self, depth: Image, view: View) -> Image:
        return 0.0004 * depth * np.sin(2 * np.pi * view.v / PERIOD) / view.stretch


@pytest.fixture(scope="module")
def found():
    return beyond_of(RowWave())


def beyond_of(effect):
    """What is found where this is at work."""
    sensor = sensor_of("itof")
    blocks = looks_at(sensor, 3)
    for block in blocks:
        block.mean[...] = block.mean + effect.bias(block.view.depth, block.view)
    before = observe(sensor, blocks)
    covariance = covariance_of(before)
    white, groups = covariance.whiten(before.residual), groups_of(before, covariance)
    left = explained(white, groups, np.zeros((len(white), 0)))
    beyond = unknown_of(white, MeasuredTiles(before, covariance), left, candidates_of(before, covariance), groups)
    return SimpleNamespace(
        blocks=blocks, before=before, covariance=covariance, white=white, beyond=beyond, posterior=1.0
    )


def test_one_recording_alone_establishes_no_unknown_law(found):
    # however clear it is there: the target itself may have that shape
    alone = observe(sensor_of("itof"), found.blocks[3:4])
    covariance = covariance_of(alone)
    white = covariance.whiten(alone.residual)
    left = explained(white, groups_of(alone, covariance), np.zeros((len(white), 0)))
    law = law_of(white, alone, covariance, left)
    assert law.gain > 100 and not law.replicated


def test_a_law_of_what_each_recording_has_one_value_of_is_not_established():
    """Eight recordings, one after the other: what goes with their times may go with how each was set up."""
    sensor = sensor_of("itof")
    blocks = looks_at(sensor, 3)
    for block in blocks:
        wave = np.sin(2 * np.pi * block.view.moment.time / 1300.0)
        block.mean[...] = block.mean + 0.01 * wave * ((block.view.v - 40.0) / 40.0) ** 2 / block.view.stretch
    before = observe(sensor, blocks)
    covariance = covariance_of(before)
    white = covariance.whiten(before.residual)
    left = explained(white, groups_of(before, covariance), np.zeros((len(white), 0)))
    law = law_of(white, before, covariance, left)
    assert {"time", "temperature"} & set(law.variables) and law.gain > 100
    assert not law.replicated


def test_the_form_of_a_law_without_a_name_is_found(found):
    law = found.beyond.law
    assert law.simple and law.variables[0] == "v" and set(law.variables) <= {"v", "depth", "range"}
    # eight walls of 80 rows: two periods, known to a tenth
    assert abs(float(law.text.split("sin(2 pi v / ")[1].split()[0]) - PERIOD) < 4
    assert law.replicated and law.probability < 1e-6
    assert found.beyond.frame.name == "sensor"


def test_the_table_corrects_and_survives_its_file(found, tmp_path):
    extended = found.beyond.added_to(found.before.sensor)
    after = found.covariance.whiten(observe(extended, found.blocks).residual)
    assert (after**2).mean() < 1.5 < (found.white**2).mean()  # 1 is noise alone
    write_sensor(tmp_path / "sensor.json", extended)
    again = read_sensor(str(tmp_path / "sensor.json"))
    block = found.blocks[0]
    depth = block.view.depth
    np.testing.assert_allclose(again.predict(depth, block.view), extended.predict(depth, block.view), atol=1e-7)
    # half a millimetre of wave at a metre: undone to a twentieth of it
    true = extended.correct(extended.predict(depth, block.view), block.view)
    np.testing.assert_allclose(true, depth, atol=5e-5)


def test_the_verdict_says_form_frame_and_why_it_has_no_name(found):
    entry = unknown_claim(found, found.beyond, float(found.white @ found.white))
    assert entry.effect == "unknown" and entry.law.added_as == "tabulated"
    assert entry.frame.name == "sensor"
    assert entry.nearest.effect in entry.where.text and "explains" in entry.nearest.reason
    assert 0 < entry.evidence.heldout_gain <= 1 and entry.parameters["rms"].value > 0


def test_an_unknown_law_that_frames_without_a_part_in_it_contradict_is_told_of_and_not_established():
    sensor = sensor_of("itof")
    blocks = [replace(block, held=held) for block, held in zip(looks_at(sensor, 3), looks_at(sensor, 4), strict=True)]
    for block in blocks:
        block.mean[...] = block.mean + RowWave().bias(block.view.depth, block.view)
    explained = explained_looks(blocks, sensor)
    assert explained.beyond is not None and explained.beyond.law.variables[0] == "v"
    assert not explained.unknown and explained.sensor.effect("tabulated") is None


def test_a_look_without_any_tile_bounds_no_table(found):
    first, *others = found.before.patches
    empty = replace(first, tiles=tiling(np.zeros(first.depth.shape, bool)))
    with_it, without = (replace(found.before, patches=tuple(p)) for p in ([empty, *others], others))
    assert span_of("depth", with_it) == span_of("depth", without)


def test_two_tables_act_as_their_sum():
    rng = np.random.default_rng(0)
    one = Tabulated(("depth",), ((0.5, 1.0, 3.0),), values=rng.normal(0, 0.01, 3))
    two = Tabulated(("u", "depth"), ((0.0, 60.0, 111.0), (0.5, 1.5, 3.0)), values=rng.normal(0, 0.01, (3, 3)))
    block = looks_at(sensor_of("itof"), 0)[1]
    both = joined(one, two).bias(block.view.depth, block.view)
    apart = one.bias(block.view.depth, block.view) + two.bias(block.view.depth, block.view)
    # float32
    np.testing.assert_allclose(both, apart, atol=2e-6)


def test_a_further_variable_must_bring_much():
    one, two = (
        UnknownTerm((ShapeFunction("wave", "radius", 30.0),)),
        UnknownTerm((ShapeFunction("wave", "radius", 30.0),), "u", 2),
    )
    assert _plainest([two, one], [100.0, 95.0]) == 1
    assert _plainest([two, one], [100.0, 80.0]) == 0


def test_rings_finer_than_two_tiles_are_found_and_score_more_than_a_map(found):
    """Rings of 26 px cross squares of 16 px at all angles: a formula costs less than a free number per square."""
    blocks = looks_at(sensor_of("itof"), 3)
    for block in blocks:
        view = block.view
        block.mean[...] = block.mean + 0.0008 * np.sin(2 * np.pi * view.radius / 26.0) / view.stretch
    before = observe(found.before.sensor, blocks)
    white = found.covariance.whiten(before.residual)
    left = explained(white, groups_of(before, found.covariance), np.zeros((len(white), 0)))
    law = law_of(white, before, found.covariance, left)
    assert law.variables == ("radius",) and law.simple
    # two weights, a period and the choice: some tens of the gain
    assert law.gain - 60 < law.score < law.gain
    field = next(c for c in candidates_of(before, found.covariance) if c.name == "fixed_pattern")
    assert law.score > scored(field, field.white, white).score


@dataclass(frozen=True)
class FineWave(RowWave):
    """A wave shorter than two tiles of 16 px."""

    def bias(self, depth: Image, view: View) -> Image:
        return 0.001 * depth * np.sin(2 * np.pi * view.v / FINE) / view.stretch


def test_a_wave_shorter_than_two_tiles_is_told_from_the_longer_one_that_looks_alike_in_their_means():
    found = beyond_of(FineWave())
    side = found.before.patches[0].tiles.side
    assert 1.1 * side < FINE < 2 * side  # so the means of tiles show a wave of 1 / (1 / side - 1 / FINE)
    # sin(2 pi v / 24 px) * ...
    assert float(found.beyond.law.text.split(" px")[0].split("/ ")[1]) == pytest.approx(FINE, rel=0.03)


def test_a_formula_takes_the_place_of_names_that_explain_clearly_less():
    def step(
        gain: float, name: str = "one", columns: int = 1, where: tuple[str, ...] = (), kind: str = ""
    ) -> SimpleNamespace:
        form = SimpleNamespace(columns=np.zeros((1, columns)), where=where, form=SimpleNamespace(map=kind))
        return SimpleNamespace(candidate=form, effect=SimpleNamespace(name=name), gain=gain, price=0.0)

    def named(left: float, *steps: SimpleNamespace) -> SimpleNamespace:
        return SimpleNamespace(steps=steps, white=np.array([left]))

    white, law = np.array([10.0]), SimpleNamespace(simple=True, replicated=True, score=99.0)
    # a law that explains 75 of 100 is not the one, one that explains 96 is, a map never where less do; nor many weights
    # of another kind, but for a fiftieth
    assert explains_more(law, named(5.0, step(75.0)), white)
    assert not explains_more(law, named(2.0, step(96.0)), white)
    assert explains_more(law, named(2.0, step(96.0, columns=200, kind="offset")), white)
    assert explains_more(law, named(2.0, step(96.0, columns=10)), white)
    assert not explains_more(law, named(1.0, step(98.0, columns=10)), white)
    # two laws that hold everywhere are two causes; two of which one holds in a part only are patches of one law
    assert not explains_more(law, named(2.0, step(50.0), step(46.0, "other")), white)
    assert explains_more(law, named(2.0, step(50.0), step(46.0, "other", where=("time",))), white)
    assert not explains_more(law, named(2.0, step(96.0, where=("time",))), white)
