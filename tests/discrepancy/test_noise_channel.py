"""The noise of repeated frames: what adds to it is named, a wrong number corrected, and nothing where it is right."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from made_up_walls import looks_at, sensor_of
from scipy.ndimage import gaussian_filter

from fusion.discrepancy.channels.noise import noise_steps
from fusion.discrepancy.channels.scatter import filtered, scatter_of, stored_step
from fusion.discrepancy.channels.succession import succession_of
from fusion.discrepancy.observe.frames import likeness
from fusion.discrepancy.observe.observations import observe
from fusion.sensor.effects.light.ambient_light import AmbientLight
from fusion.sensor.effects.phase.sensor_interference import SensorInterference
from fusion.sensor.effects.readout.axial_noise import AxialNoise
from fusion.sensor.effects.readout.depth_quantization import DepthQuantization
from fusion.sensor.effects.readout.temporal_filtering import TemporalFiltering
from fusion.sensor.sensor import Sensor


def found_in(given, hidden, seed):
    """Steps for looks of one sensor under the model of another."""
    return noise_steps(observe(given, looks_at(hidden, seed)))


@pytest.mark.parametrize("principle", ["itof", "structured_light"])
def test_noise_as_the_model_says_is_nothing(principle):
    for seed in range(3):
        assert found_in(sensor_of(principle), sensor_of(principle), seed)[1] == ()


def test_a_model_without_noise_lacks_it():
    """Of noise that a model does not have, all is new in every frame."""
    bare = Sensor("bare", "itof", (DepthQuantization(step=0.001),))
    hidden = replace(bare, effects=(AxialNoise(shot=0.003, floor=0.002, ir_reference=1000.0), *bare.effects))
    blocks = [replace(block, succession=np.square(block.std)) for block in looks_at(hidden, 4)]
    observations = observe(bare, blocks)
    for patch in observations.patches:
        np.testing.assert_array_equal(filtered(patch, 0.0)[1], 0.0)
    sensor, (step,) = noise_steps(observations)
    assert step.effect == sensor.effect("axial_noise") and not step.corrected
    assert step.effect.shot == pytest.approx(0.003, rel=0.05) and step.effect.floor == pytest.approx(0.002, rel=0.1)


def test_a_model_without_noise_lacks_what_grows_with_the_distance_alone_too():
    """Amplitudes are recorded, and the noise does not follow them."""
    bare = Sensor("bare", "itof", ())
    hidden = Sensor("noisy", "itof", (AxialNoise(c0=0.002, c1=0.001, c2=0.001),))
    sensor, (step, *more) = found_in(bare, hidden, 5)
    assert step.effect is not None and step.effect.name == "axial_noise" and not step.corrected and not more
    views = [look.view for look in looks_at(hidden, 5)]
    told, true = (np.array([float(np.median(s.repeated(v.depth, v)[1])) for v in views]) for s in (sensor, hidden))
    assert np.abs(told / true - 1.0).max() < 0.25


def test_more_light_is_named_by_its_noise():
    given = replace(sensor_of("itof"), std={("axial_noise", "c0"): 0.0001})
    sensor, (step, *more) = found_in(given, sensor_of("itof", AmbientLight(ambient=4000.0)), 1)
    assert step.effect is not None and "ambient_light" in (step.effect.name, *step.alike) and not more
    # a tenth: its noise joins one that is as large, in some hundred tiles
    assert step.effect.ambient == pytest.approx(4000.0, rel=0.1)
    assert sensor.effect("ambient_light") == step.effect


def test_another_sensor_is_not_taken_for_light():
    # interference brings noise that grows as the light fades
    _, (step, *_) = found_in(sensor_of("itof"), sensor_of("itof", SensorInterference(fraction=0.3)), 2)
    assert step.effect is not None and "sensor_interference" in (step.effect.name, *step.alike)


@pytest.mark.slow
def test_noise_that_grows_with_the_tilt_is_not_taken_for_light():
    given = sensor_of("structured_light")
    blocks = looks_at(given, 5)
    # of a form that no entry has
    steep = [replace(block, std=block.std * (2 / np.cos(block.view.incidence) ** 2 - 1)) for block in blocks]
    sensor, steps = noise_steps(observe(given, steep))
    assert {step.effect.name for step in steps} == {"axial_noise"}
    # a disparity's noise grows with the square of the depth, so its angle term grows with a high power of it too
    assert sensor.effect("axial_noise").angle_exponent > 1


def test_noise_of_a_form_that_its_law_cannot_have_is_still_its_own():
    """Where light is recorded, it alone makes the noise: no number of that law grows with the tilt."""
    light = AxialNoise(shot=0.002, floor=0.001, ir_reference=1000.0)
    given = replace(sensor_of("itof").having(light), std={("axial_noise", n): 1e-4 for n in ("shot", "floor")})
    blocks = looks_at(given, 5)
    assert all(block.view.ir is not None for block in blocks)
    steep = [replace(block, std=block.std * (3 / np.cos(block.view.incidence) ** 2 - 2)) for block in blocks]
    sensor, steps = noise_steps(observe(given, steep))
    assert steps[-1].effect == sensor.effect("axial_noise") and steps[-1].variables == ("incidence",)
    assert steps[-1].established and "incidence" in steps[-1].text


def test_noise_that_depends_on_what_no_law_knows_is_told_and_not_established():
    given = sensor_of("structured_light")
    blocks = looks_at(given, 6)
    across = np.linspace(1.0, 3.0, blocks[0].std.shape[1])
    _, steps = noise_steps(observe(given, [replace(block, std=block.std * across) for block in blocks]))
    assert steps[-1].effect is None and not steps[-1].established and steps[-1].variables == ("u",)


@pytest.mark.slow
@pytest.mark.parametrize("factor", [0.6, 1.5])
def test_a_number_that_is_wrong_is_corrected(factor):
    given = replace(sensor_of("structured_light"), std={("axial_noise", "sigma_px"): 0.003})
    _, steps = found_in(given, replace(given, effects=(AxialNoise(sigma_px=0.03 * factor),)), 3)
    (step,) = steps
    assert step.corrected and step.effect.name == "axial_noise"
    # five standard deviations: this happens once in a million seeds
    assert step.effect.sigma_px == pytest.approx(0.03 * factor, abs=5 * step.std["sigma_px"])
    assert step.std["sigma_px"] < 0.001


def test_a_number_that_is_as_well_known_as_stated_is_left():
    given = replace(sensor_of("structured_light"), std={("axial_noise", "sigma_px"): 0.006})
    assert found_in(given, replace(given, effects=(AxialNoise(sigma_px=0.036),)), 4)[1] == ()


@pytest.mark.slow
def test_frames_that_hold_the_one_before_are_told_from_less_noise():
    rng = np.random.default_rng(5)
    blocks, memory = [], 0.4
    for block in looks_at(sensor_of("itof"), 6):
        frames = block.mean + 0.002 * rng.standard_normal((6, *block.mean.shape))
        for t in range(1, len(frames)):
            frames[t] = (1 - memory) * frames[t] + memory * frames[t - 1]
        changes = 0.5 * (np.diff(frames, axis=0) ** 2).mean(axis=0)
        blocks.append(replace(block, std=frames.std(axis=0, ddof=1), succession=changes))
    _, (step, *more) = noise_steps(observe(sensor_of("itof"), blocks))
    assert isinstance(step.effect, TemporalFiltering) and not more
    # three standard deviations and what the made-up noise leaves open
    assert step.effect.memory == pytest.approx(memory, abs=3 * step.std["memory"] + 0.01)


@pytest.mark.parametrize("smoothed_px", [0.6, 0.7])
def test_frames_smoothed_each_by_itself_hold_nothing_of_the_one_before(smoothed_px):
    """Neighbours share their noise then, so there is less of it; successive frames are as independent as before."""
    rng = np.random.default_rng(8)
    blocks = []
    for block in looks_at(sensor_of("itof"), 6):
        noise = gaussian_filter(0.002 * rng.standard_normal((4, *block.mean.shape)), (0, smoothed_px, smoothed_px))
        changes = np.diff(noise, axis=0)
        alike = np.mean([likeness(change) for change in changes], axis=0)
        new = 0.5 * (changes**2).mean(axis=0)
        std = noise.std(axis=0, ddof=1)
        blocks.append(replace(block, frames=(5, 6, 7, 8), std=std, succession=new, alike=alike))
    # a sensor whose noise is known: no correction of it stands in for what the smoothing took away
    known = replace(sensor_of("itof"), std={("axial_noise", "c0"): 0.0})
    assert noise_steps(observe(known, blocks))[1] == ()


def test_expected_scatter_of_filtered_frames():
    rng = np.random.default_rng(7)
    x = rng.standard_normal((5, 40_000))
    for t in range(1, 5):
        x[t] = 0.5 * x[t] + 0.5 * x[t - 1]
    whole, renewed = succession_of(0.5, 5, started=True)
    variance = x.var(axis=0, ddof=1).mean()
    # a hundredth: 40000 series of five frames
    assert np.log(variance) == pytest.approx(whole, abs=0.02)
    assert np.log(0.5 * (np.diff(x, axis=0) ** 2).mean() / variance) == pytest.approx(renewed, abs=0.02)
    assert succession_of(0.0, 5, started=True) == pytest.approx((0.0, 0.0))


def test_a_constant_that_is_not_there_is_corrected_to_zero_within_what_the_noise_allows():
    """Only its square is seen beside the disparity's, so it has no slope at 0, and seemed to be 0 +- 4 m and more."""
    std = {("axial_noise", "c0"): 0.0003, ("axial_noise", "sigma_px"): 0.003}
    given = replace(sensor_of("structured_light"), effects=(AxialNoise(c0=0.002, sigma_px=0.03),), std=std)
    _, (step,) = found_in(given, replace(given, effects=(AxialNoise(sigma_px=0.05),)), 0)
    assert abs(step.effect.c0) < 2 * step.std["c0"]
    assert 1e-5 < step.std["c0"] < 0.002  # the constant that was stated is seen not to be there


@pytest.mark.parametrize("size", [1.0, 2.8])
def test_no_finding_denies_how_frames_scatter(size):
    """A polynomial whose terms one distance cannot tell apart: its numbers may be open, their sum is not."""
    told = AxialNoise(c0=0.0015 * size, c1=-0.00152 * size, c2=0.0019 * size, angle=0.0001, angle_exponent=-0.5)
    rounding, wall = DepthQuantization(step_px=0.03), (0.8, 20, 0)
    given = Sensor("given", "structured_light", (told, rounding))
    hidden = Sensor("hidden", "structured_light", (AxialNoise(sigma_px=0.0172 * size, correlation_px=8.0), rounding))
    observations = observe(given, looks_at(hidden, 1, [wall]))
    for sensor in (given, noise_steps(observations)[0]):
        scatter = scatter_of(observations.under(sensor).patches)
        assert np.abs(np.median(scatter.excess)) < 0.3  # of the logarithm of a variance: 15 % of the noise


@pytest.mark.parametrize("step_px", [0.03, 0.0625])
def test_noise_that_no_model_holds_is_sized_behind_its_rounding(step_px):
    rounding = DepthQuantization(step_px=step_px)
    given = Sensor("given", "structured_light", (rounding,))
    hidden = replace(given, effects=(AxialNoise(sigma_px=0.03), rounding))
    _, (step, *more) = noise_steps(observe(given, looks_at(hidden, 1)))
    assert isinstance(step.effect, AxialNoise) and not more
    # a fifth: without noise the rounding itself scatters nothing, with it by a step over the root of twelve
    assert step.effect.sigma_px == pytest.approx(0.03, rel=0.2)


def test_what_a_file_rounds_off_is_no_noise_of_the_sensor():
    """Counts of a millimetre make as much noise as a quiet sensor near by; the file says how large they are."""
    quiet = Sensor("quiet", "itof", (AxialNoise(c0=0.0005),))
    file = SimpleNamespace(camera=SimpleNamespace(depth_scale=1000.0))
    blocks = looks_at(quiet, 6)
    stored = [
        replace(
            block,
            std=np.sqrt(block.std**2 + 1e-6 / 12),
            stage=SimpleNamespace(**{**vars(block.stage), "recording": file}),
        )
        for block in blocks
    ]
    assert noise_steps(observe(quiet, blocks))[1] == ()
    assert noise_steps(observe(quiet, stored))[1] == ()


def test_what_a_file_rounds_off_is_new_in_every_frame_behind_a_filter_too():
    """A patch of which a quarter of the variance is the file's: the filter quietens the rest alone."""
    quiet = Sensor("quiet", "itof", (AxialNoise(c0=0.0005),))
    file = SimpleNamespace(camera=SimpleNamespace(depth_scale=1000.0))
    (patch,) = observe(quiet, looks_at(quiet, 6)[2:3]).patches
    stage = SimpleNamespace(**{**vars(patch.block.stage), "recording": file})
    stored = replace(patch, block=replace(patch.block, stage=stage))
    whole, renewed = filtered(stored, 0.5)
    alone = filtered(patch, 0.5)
    counts = np.median(patch.native[patch.tiles.label >= 0]) ** 2 * 1e-6 / 12
    assert np.exp(whole) == pytest.approx(np.exp(alone[0]) + counts, rel=1e-6)
    assert np.exp(whole + renewed) == pytest.approx(np.exp(alone[0] + alone[1]) + counts, rel=1e-6)


def test_a_count_of_the_file_is_told_by_the_pixels_that_are_used():
    """Where nothing stands there is no depth, and no pixel of disparity per metre."""
    quiet = sensor_of("structured_light")
    file = SimpleNamespace(camera=SimpleNamespace(depth_scale=1000.0))
    block = looks_at(quiet, 6)[0]
    depth = block.view.depth.copy()
    depth[:, :20] = np.nan
    stage = SimpleNamespace(**{**vars(block.stage), "recording": file})
    (patch,) = observe(quiet, [replace(block, stage=stage, view=replace(block.view, depth=depth))]).patches
    assert np.isnan(patch.native).any()
    used = patch.native[patch.tiles.label >= 0]
    assert stored_step(patch) == pytest.approx(1e-3 * float(np.median(np.abs(used))))
    assert np.isfinite(scatter_of([patch]).excess).all()
