"""A rig that sways or creeps is no noise of the camera: it is told, and left out of the laws."""

from pathlib import Path

import numpy as np
import pytest
from made_up_targets import target_image

from fusion.calibration.noise.calibration import calibrate_noise
from fusion.calibration.noise.target_noise import measure_target
from fusion.geometry.camera import Camera
from fusion.recording.recording import Frame, Recording

CAMERA = Camera(160, 120, 365.0, 365.0, 79.5, 59.5, principle="itof", sensor="made up")
SIGMA, FRAMES = 0.002, 40  # [m]
MOTION = {
    "sways": 0.006 * np.sin(0.7 * np.arange(FRAMES)),
    "creeps": 0.0005 * np.arange(FRAMES),
    "stands": np.zeros(FRAMES),
}


def frames(z: float, motion: np.ndarray, seed: int = 0) -> list[np.ndarray]:
    """A target at z [m] before a wall, the camera moved [m] in each frame."""
    rng, still = np.random.default_rng(seed), target_image(CAMERA, z, 10, np.zeros((CAMERA.height, 1)))
    return [still + by + SIGMA * rng.standard_normal(still.shape) for by in motion]


def recordings(how: str) -> list[Recording]:
    """Ten distances."""
    made = []
    for k, z in enumerate(np.linspace(0.8, 2.0, 10)):
        images = frames(float(z), MOTION[how], k)
        kept = [Frame(i, i / 30, depth) for i, depth in enumerate(images)]
        stamps = np.arange(FRAMES) / 30
        made.append(Recording(Path(f"t{k}"), "native", CAMERA, stamps, kept.__getitem__))
    return made


@pytest.mark.parametrize("how", MOTION)
def test_the_laws_are_without_the_motion_of_the_rig(how):
    found = calibrate_noise(recordings(how))
    axial = np.array([pose.axial for pose in found.poses])
    # 40 frames of 240 pixels know a spread to a hundredth
    assert np.abs(axial / SIGMA - 1).max() < 0.04
    told = [text for _, text in found.notes if "shared by all pixels of the target" in text]
    assert [text.split(":")[0] for text in told] == ([] if how == "stands" else [f"t{k}" for k in range(10)])
    assert all(("drifts" in text) == (how == "creeps") for text in told)


def test_an_edge_that_sways_with_the_rig_does_not_jitter():
    rng = np.random.default_rng(3)
    jitter = [0.7 * rng.standard_normal((CAMERA.height, 1)) for _ in range(FRAMES)]
    spreads = []
    for aside in (np.zeros(FRAMES), 2.0 * np.sin(0.7 * np.arange(FRAMES))):
        images = [target_image(CAMERA, 1.6, 0, j + by) for j, by in zip(jitter, aside, strict=True)]
        by = MOTION["sways" if aside.any() else "stands"]
        series = [image + b + SIGMA * rng.standard_normal(image.shape) for image, b in zip(images, by, strict=True)]
        spreads.append(measure_target(series, CAMERA).lateral)
    assert np.allclose(spreads[0], spreads[1], rtol=0.1)


def test_single_outliers_are_no_motion():
    rng = np.random.default_rng(5)
    images = frames(1.0, MOTION["stands"])
    for image in images:
        image[rng.random(image.shape) < 0.02 * rng.random()] += 0.4
    assert not measure_target(images, CAMERA).shared.told
