"""Light that glossy targets mirror: in pieces of some size, in some recordings more than in others, and no law."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from made_up_walls import looks_at, loose_in, sensor_of

from fusion.discrepancy.explain import explained_looks
from fusion.sensor.effects.readout.depth_scale import DepthScale

HIGH, WIDE = 0.02, 14.0  # [m], [px] of a patch of mirrored light: as a glossy board shows it, two tiles across
ROUGH = 0.001  # [m] from tile to tile
FAR_OFF = 5.0  # times the usual scatter


def mirrored(sensor, seed: int, high: float = HIGH, rough: float = ROUGH, shape_m: float = 0.0, far_off: int = -1):
    """Blocks of which one in three has two patches of mirrored light, and whose tiles scatter."""
    rng = np.random.default_rng([seed, 77])
    out = []
    for k, block in enumerate(looks_at(sensor, seed)):
        h, w = block.mean.shape
        v, u = np.mgrid[0:h, 0:w]
        off = rng.normal(0, rough * (FAR_OFF if k == far_off else 1.0), (-(-h // 16), -(-w // 16)))
        off = np.kron(off, np.ones((16, 16)))[:h, :w]
        for _ in range(2 if k % 3 == 0 else 0):
            away = (u - rng.uniform(0, w)) ** 2 + (v - rng.uniform(0, h)) ** 2
            off += high * rng.uniform(0.5, 1.5) * np.exp(-away / (2 * WIDE**2))
        stage = SimpleNamespace(**{**vars(block.stage), "mesh_sigma_m": shape_m, "shape": "wall"})
        out.append(replace(block, mean=block.mean + off, stage=stage))
    return out


def test_scatter_is_what_it_is_where_the_shape_of_the_target_is_hardly_known():
    found = loose_in(mirrored(sensor_of("itof"), 1, high=0.0, rough=0.004, shape_m=0.003))
    # a few hundred tiles less those that laws could follow tell a standard deviation to 10 %
    assert found.scatter == pytest.approx(0.004, rel=0.3)
    assert found.drift == 0.0


def test_a_recording_that_is_far_off_has_a_spread_of_its_own():
    found = loose_in(mirrored(sensor_of("itof"), 1, high=0.0, rough=0.002, far_off=5))
    usual = np.delete(found.uneven, 5)
    assert found.scatter * np.sqrt(np.median(usual)) == pytest.approx(0.002, rel=0.3)
    # thirty tiles tell a variance to a quarter, the prior of the t distribution pulls it by a tenth more
    assert found.uneven[5] / np.median(usual) == pytest.approx(FAR_OFF**2, rel=0.6)


@pytest.mark.slow
def test_mirrored_light_is_no_law_and_hides_none():
    nothing = explained_looks(mirrored(sensor_of("itof"), 1), sensor_of("itof"))
    pairs = zip(mirrored(sensor_of("itof"), 1, rough=0.0), looks_at(sensor_of("itof"), 1), strict=True)
    light = float(np.sqrt(np.mean([np.nanmean((with_it.mean - block.mean) ** 2) for with_it, block in pairs])))
    assert light / 3 < nothing.before.loose.drift < 3 * light  # to a factor, as its lengths are a guess
    assert not nothing.named.steps
    assert not nothing.unknown
    scale = explained_looks(mirrored(sensor_of("itof", DepthScale(scale=0.02)), 1), sensor_of("itof"))
    assert [step.effect.name for step in scale.named.steps] == ["depth_scale"]
    # twenty millimetres of mirrored light in patches leave the scale known to better than a tenth
    assert scale.named.steps[0].effect.scale == pytest.approx(0.02, rel=0.2)
