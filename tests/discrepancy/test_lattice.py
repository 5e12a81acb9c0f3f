"""Steps in which depths are stored are found from the values that occur, and only where the model lacks them."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from made_up_walls import looks_at, sensor_of

import fusion.discrepancy
from fusion.discrepancy.channels.lattice import lattice_steps
from fusion.discrepancy.explain import explained_looks
from fusion.discrepancy.observe.observations import observe
from fusion.geometry.camera import Camera
from fusion.recording.open import open_recording
from fusion.recording.recording import Frame
from fusion.recording.writing.write import write_recording
from fusion.sensor.effects import EFFECTS
from fusion.sensor.effects.readout.depth_quantization import DepthQuantization

CAMERA = Camera(112, 80, 100.0, 100.0, 56.0, 40.0, depth_scale=1000.0, principle="structured_light")
STEP_PX = 0.05  # 6.7 mm at 1 m with the base of the made-up sensor


def observed(folder, step_px, *known):
    """Five tilted walls, stored in millimetres after their disparity was rounded."""
    blocks = []
    sensor = sensor_of("structured_light")
    rng = np.random.default_rng(0)
    for place, block in enumerate(looks_at(sensor, 1)[:5]):
        fb = CAMERA.fx * sensor.baseline
        rows = np.linspace(0.7 + 0.1 * place, 1.6 + 0.2 * place, CAMERA.height)[:, None]
        depth = np.broadcast_to(rows, CAMERA.shape) + rng.normal(0, 0.003, CAMERA.shape)
        stored = fb / (np.round(fb / depth / step_px) * step_px) if step_px else depth
        write_recording(folder / str(place), CAMERA, iter([Frame(0, 0.0, stored.astype(np.float32))]), None)
        stage = SimpleNamespace(**vars(block.stage), recording=open_recording(folder / str(place)))
        blocks.append(replace(block, stage=stage, view=replace(block.view, camera=CAMERA)))
    better = sensor
    for effect in known:
        better = better.having(effect)
    return observe(better, blocks)


def test_steps_of_disparity_are_found(tmp_path):
    sensor, (step,) = lattice_steps(observed(tmp_path, STEP_PX))
    assert step.established and step.channel == "bias"
    # the file's millimetres round steps of 4 to 30 mm
    assert sensor.effect("depth_quantization").step_px == pytest.approx(STEP_PX, rel=0.05)


def test_levels_of_an_unknown_rounding_are_no_grain_and_no_noise(tmp_path):
    """They are told by the values that occur, before anything else is asked for."""
    sensor, stages = sensor_of("structured_light"), observed(tmp_path, STEP_PX).patches
    blocks = looks_at(sensor_of("structured_light", DepthQuantization(step_px=STEP_PX)), 1)[: len(stages)]
    blocks = [replace(own, stage=patch.block.stage) for own, patch in zip(blocks, stages, strict=True)]
    found = explained_looks(blocks, sensor)
    told = [step.effect.name for step in found.channels.steps if step.established]
    assert (told, found.named.steps, found.unknown) == (["depth_quantization"], (), False)


def test_what_the_model_has_or_nobody_has_is_not_told(tmp_path):
    assert lattice_steps(observed(tmp_path / "known", STEP_PX, DepthQuantization(step_px=STEP_PX)))[1] == ()
    assert lattice_steps(observed(tmp_path / "none", 0.0))[1] == ()


def test_the_engine_names_no_effect_itself():
    """All effects compete by what they declare; only the table that the engine fills itself is its own."""
    names = {f'"{kind.name}"' for kind in EFFECTS if kind.name != "tabulated"}
    for file in Path(fusion.discrepancy.__file__).parent.rglob("*.py"):
        text = file.read_text(encoding="utf-8")
        assert not [name for name in names if name in text], file
        assert "sensor.effects." not in text.replace("sensor.effects.readout.tabulated", ""), file
