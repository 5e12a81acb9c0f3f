"""Look-alikes: what recordings do not tell apart, or what would have to be larger than it can be, and nothing else."""

from dataclasses import replace

import numpy as np
from made_up_walls import HEIGHT, WALLS, WIDTH, looks_at, sensor_of
from scipy.ndimage import gaussian_filter

from fusion.discrepancy.inference.tile_covariance import covariance_of
from fusion.discrepancy.mean import MeasuredForms, explained_mean
from fusion.discrepancy.naming.naming import Named, name_effects
from fusion.discrepancy.naming.search.candidates import candidates_of
from fusion.discrepancy.observe.observations import observe
from fusion.sensor.effect import Effect
from fusion.sensor.effects.optics.refraction import Refraction
from fusion.sensor.effects.phase.cyclic_error import CyclicError
from fusion.sensor.effects.phase.emitter_parallax import EmitterParallax
from fusion.sensor.effects.readout.depth_offset import DepthOffset
from fusion.sensor.effects.readout.temperature_drift import TemperatureDrift
from fusion.sensor.effects.triangulation.disparity_distortion import DisparityDistortion

FRONTAL = [(distance, 0, 0) for distance in (0.6, 0.8, 1.1, 1.4, 1.8, 2.3, 2.8, 3.4)]


def named(principle: str, hidden: Effect, walls=WALLS, off=0.3) -> Named:
    blocks = looks_at(sensor_of(principle, hidden), 3, walls, off)
    observations = observe(sensor_of(principle), blocks)
    covariance = covariance_of(observations)
    return name_effects(blocks, observations, covariance, candidates_of(observations, covariance))


def test_an_offset_is_no_pane_and_no_other_sensor_where_these_would_be_too_large():
    """A pane would be 0.1 m thick, another sensor's light more than the own."""
    step = named("itof", DepthOffset(offset=0.05)).steps[0]
    assert step.effect.name == "depth_offset"
    assert step.alike == (
        "subsurface_scattering",
    )  # the same law; a sensor that warms up, from wall to wall, has another


def test_a_pane_with_the_bowl_of_an_offset_is_told_from_it_by_where_the_camera_stood():
    """20 mm of glass bend frontal walls as 17 mm more range do, and set them 7 mm nearer: a small share of
    the chi2, and more than poses known to 3 mm allow eight times."""
    step = named("itof", DepthOffset(offset=0.017), FRONTAL, 3.0).steps[0]
    assert step.effect.name == "depth_offset" and "refraction" not in step.alike


def test_what_a_clear_pane_does_to_slanted_rays_tells_it_from_an_offset_and_a_faint_one_not():
    clear, faint = (named("itof", Refraction(thickness=size)) for size in (0.02, 0.001))
    assert clear.steps[0].effect.name == "refraction" and clear.steps[0].alike == ()
    sets = [{step.effect.name, *step.alike} for step in faint.steps] or [set()]
    assert "refraction" in sets[0] and "depth_offset" in sets[0]


def test_a_lamp_beside_the_lens_is_not_followed_by_a_map_because_its_law_bends():
    """To first order it is a slope over the image; its second order, of 1 / r, a map could only follow on average."""
    steps = named("itof", EmitterParallax(baseline=0.2, direction=0.5)).steps
    assert [step.effect.name for step in steps] == ["emitter_parallax"]


def test_a_warp_of_the_pattern_that_no_polynomial_follows_is_one():
    rng = np.random.default_rng(4)
    warp = gaussian_filter(rng.normal(size=(HEIGHT, WIDTH)), 12)
    steps = named("structured_light", DisparityDistortion(map=0.3 * warp / warp.std())).steps
    assert [step.effect.name for step in steps] == ["disparity_distortion"]


def test_a_claim_of_too_many_names_or_of_no_sure_size_is_likely_and_keeps_its_place_in_the_model_beside_others():
    hidden = CyclicError(amplitude=(0.02,), period=(0.6,))
    blocks = looks_at(sensor_of("itof", DepthOffset(offset=0.05), hidden), 3)
    observations = observe(sensor_of("itof"), blocks)
    mean = explained_mean(MeasuredForms.of(blocks, observations, covariance_of(observations)), sensor_of("itof"))
    assert {step.effect.name for step in mean.named.steps} == {"depth_offset", "cyclic_error"}

    def told(*wide, **changed):
        changed = changed or {"alike": ("a", "b", "c")}
        steps = [replace(s, **changed) if s.effect.name in wide else s for s in mean.named.steps]
        named = replace(mean, named=replace(mean.named, steps=tuple(steps))).telling.named
        return {s.effect.name for s in named.steps}, {s.effect.name for s in named.likely}, named.sensor

    assert mean.telling is mean
    steps, likely, sensor = told("depth_offset")
    assert steps == {"cyclic_error"} and "depth_offset" in likely and sensor is mean.named.sensor
    # 2.1 +- 1.5 mm were established: the model without it is as likely
    steps, likely, _ = told("cyclic_error", std=0.7)
    assert steps == {"depth_offset"} and "cyclic_error" in likely
    assert told("cyclic_error", std=0.3)[0] == {"depth_offset", "cyclic_error"}
    steps, likely, sensor = told("depth_offset", "cyclic_error")
    assert not steps and likely == {"cyclic_error", "depth_offset"} and not sensor.effect("depth_offset")


def test_where_no_thermometer_tells_how_warm_a_camera_was_at_first_an_offset_may_be_its_drift():
    """A drift that begins before the clock is one that begins with it, and an offset."""
    hidden = TemperatureDrift(amplitude=0.03, time_constant=900.0), DepthOffset(offset=0.02)
    blocks = looks_at(sensor_of("itof", *hidden), 3)
    unknown = [replace(b, view=replace(b.view, moment=replace(b.view.moment, temperature=np.nan))) for b in blocks]
    told = []
    for seen in (unknown, blocks):
        observations = observe(sensor_of("itof"), seen)
        covariance = covariance_of(observations)
        candidates = candidates_of(observations, covariance)
        told.append({s.effect.name: s.alike for s in name_effects(seen, observations, covariance, candidates).steps})
    assert set(told[0]) == {"temperature_drift", "depth_offset"} and "temperature_drift" in told[0]["depth_offset"]
    assert all("temperature_drift" not in alike for alike in told[1].values())
