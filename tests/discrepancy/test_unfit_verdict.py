"""What a verdict says where poses do not fit, nothing was measured, or the model leaves more than noise."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
from made_up_walls import HEIGHT, WIDTH, looks_at, sensor_of
from msgspec import structs

from fusion.discrepancy.explain import explained_looks
from fusion.discrepancy.inference.tile_covariance import TileCovariance
from fusion.discrepancy.verdict.verdict import verdict_of
from fusion.discrepancy.verdict.words import sentence, what_it_is
from fusion.sensor.effects.readout.depth_offset import DepthOffset

LEAST = {"table": None, "reconstructed": False, "placed_by_images": False, "simulated": None, "twists": None}


def found_in(blocks):
    def staged(block):
        recording = SimpleNamespace(path=Path(f"rec_{block.place}"), camera=SimpleNamespace(depth_scale=1e6))
        more = {"sigma_m": 0.001, "sigma_rad": 0.001, "shape": f"wall {block.place}", "recording": recording}
        return replace(block, stage=SimpleNamespace(**{**vars(block.stage), **LEAST, **more}))

    return explained_looks([staged(block) for block in blocks], sensor_of("itof"))


def told(blocks):
    return verdict_of(found_in(blocks))


def test_recordings_as_stated_lack_nothing_and_have_limits():
    said = told(looks_at(sensor_of("itof"), 1))
    assert said.nothing_missing and said.limits and said.headline.startswith("Nothing is missing")


def test_poses_that_do_not_fit_are_what_is_told_first():
    said = told(looks_at(sensor_of("itof"), 1, off=40.0))
    assert said.headline.startswith("The poses do not fit") and not said.nothing_missing and not said.limits
    worse = structs.replace(said, unexplained=structs.replace(said.unexplained, rms_m=0.03, chi2_per_dof=30.0))
    assert "poses do not fit" not in sentence(worse)  # they do not make it fit: something else is there


def test_poses_ten_times_worse_than_stated_are_told_and_nothing_is_missing():
    said = told(looks_at(sensor_of("itof"), 1, off=10.0))
    assert said.nothing_missing and said.limits and "times worse than stated" in said.headline


def test_an_effect_keeps_its_name_beside_poses_that_do_not_fit():
    walls = [(0.8, 0, 0), (1.1, 35, 0), (1.4, -30, 15), (1.8, 10, -25), (2.3, 40, 5), (2.8, -15, 10)]
    said = told(looks_at(sensor_of("itof", DepthOffset(offset=0.2)), 1, walls, off=6.0))
    assert {claim.effect for claim in said.missing} == {"depth_offset"}


def test_a_recording_in_which_nothing_was_measured_is_told():
    blocks = looks_at(sensor_of("itof"), 1)
    nothing = np.full((HEIGHT, WIDTH), np.nan)
    blocks[3] = replace(blocks[3], mean=nothing, std=nothing, count=np.zeros((HEIGHT, WIDTH), np.int32))
    said = told(blocks)
    assert "nothing was measured in rec_3" in said.headline and not said.nothing_missing
    assert [(one.recording, one.empty) for one in said.outliers] == [("rec_3", True)]


def test_no_limit_is_told_beside_a_model_that_does_not_fit():
    found = found_in(looks_at(sensor_of("itof"), 1))
    known = found.covariance
    half = TileCovariance(known.root / 2, known.free / 4, known.known / 2)
    said = verdict_of(replace(found, covariance=half, white=2 * found.white))
    assert said.unexplained.chi2_per_dof > 2 and not said.nothing_missing
    assert not said.missing and not said.limits and "is not known before" in said.headline


def spotted(rows, columns):
    """Walls with 20 mm too much in a part of the image."""
    blocks = looks_at(sensor_of("itof"), 1)
    for block in blocks:
        block.mean[rows, columns] += 0.02
    return blocks


def test_a_spot_is_told_as_one_place_and_not_as_all_pixels():
    said = told(spotted(slice(40, 46), slice(44, 50)))
    (claim,) = said.missing
    (u, v) = (next(b for b in claim.where.region if b.variable == name) for name in "uv")
    assert u.low <= 44 and u.high >= 49 and u.high - u.low < 32 and v.low <= 40 and v.high >= 45 and v.high - v.low < 32
    assert "in one place of the image" in said.headline and what_it_is(claim).startswith("in one place of the image")


def test_a_pattern_of_the_whole_image_has_no_place():
    own = np.kron(np.random.default_rng(4).normal(0, 0.003, (HEIGHT // 8, WIDTH // 8)), np.ones((8, 8)))
    said = told([replace(block, mean=block.mean + own) for block in looks_at(sensor_of("itof"), 1)])
    assert any(claim.effect == "fixed_pattern" and not claim.where.region for claim in said.missing)
    assert "in one place" not in said.headline
