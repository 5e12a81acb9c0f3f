"""A lens that is not the device's, of boards placed by its own images: no law, but what is wrong in the file."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from fusion.discrepancy.explain import explained_looks
from fusion.discrepancy.inference.camera_file import FileError, file_error
from fusion.discrepancy.inference.loose import Loose
from fusion.discrepancy.inference.tile_covariance import covariance_of
from fusion.discrepancy.mean import MeanFindings
from fusion.discrepancy.observe.frame_block import FrameBlock, wanted_channels
from fusion.discrepancy.observe.observations import observe
from fusion.discrepancy.setting import without_laws
from fusion.discrepancy.verdict.verdict import verdict_of
from fusion.geometry.camera import Camera
from fusion.geometry.pose import exp, inverse
from fusion.mesh.mesh import Mesh
from fusion.sensor.effects.readout.axial_noise import AxialNoise
from fusion.sensor.sensor import Sensor
from fusion.simulation.rendering.render import RayCaster

DEVICE = Camera(160, 120, 110.0, 110.0, 79.5, 59.5, (0.05, -0.1), principle="itof")
WRONG = FileError(cx=2.0, cy=-4.0, focal=0.02, aspect=0.013, k1=0.02, p1=-0.011, p2=0.003)
NOISE_M, FRAMES = 0.001, 6
HALF = (0.25, 0.2)  # [m] of a board
NONE = FileError()


def stated(wrong):
    """The file that is wrong by so much."""
    k1, k2, p1, p2, *others = DEVICE.distortion
    long, tall = 1 + wrong.focal, (1 + wrong.aspect) ** 0.5
    return replace(
        DEVICE,
        fx=DEVICE.fx * long / tall,
        fy=DEVICE.fy * long * tall,
        cx=DEVICE.cx + wrong.cx,
        cy=DEVICE.cy + wrong.cy,
        distortion=(k1 + wrong.k1, k2, p1 + wrong.p1, p2 + wrong.p2, *others),
    )


def poses(count=14):
    """Where the board stood before the camera, tilted, in all parts of the image."""
    rng = np.random.default_rng(7)
    z = np.linspace(0.75, 1.9, count)
    turned = np.column_stack([rng.uniform(-0.6, 0.6, (count, 2)), rng.uniform(-0.5, 0.5, count)])
    at = z[:, None] * np.column_stack([rng.uniform(-0.45, 0.45, count), rng.uniform(-0.3, 0.3, count), np.ones(count)])
    return [exp([*turn, *shift]) for turn, shift in zip(turned, at, strict=True)]


def board():
    x, y = HALF
    corners = np.array([[-x, -y, 0], [x, -y, 0], [x, y, 0], [-x, y, 0]])
    return RayCaster(Mesh(corners, np.array([[0, 2, 1], [0, 3, 2]], np.int32)))


def placed(T_device_board, camera):
    """What anybody's board detection gives: the corners where the device sees them, through a camera."""
    x, y = np.meshgrid(np.linspace(-HALF[0], HALF[0], 7), np.linspace(-HALF[1], HALF[1], 5))
    points = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    pixels = DEVICE.project(points @ T_device_board[:3, :3].T + T_device_board[:3, 3])
    _, turned, shift = cv2.solvePnP(points, pixels, camera.matrix, np.array(camera.distortion))
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = cv2.Rodrigues(turned)[0], shift.ravel()
    return T


def looks_at_boards(wrong):
    rng, caster, camera, blocks = np.random.default_rng(3), board(), stated(wrong), []
    for place, T in enumerate(poses()):
        truth = caster.view(DEVICE, inverse(T), wanted_channels(None, True)).depth
        frames = truth + rng.normal(0, NOISE_M, (FRAMES, *truth.shape))
        T_stated = inverse(placed(T, camera))
        view = replace(caster.view(camera, T_stated, wanted_channels(None, True)), placed_by_images=True)
        stage = SimpleNamespace(
            place=place, sigma_m=0.0005, sigma_rad=0.002, mesh_sigma_m=0.0003, caster=caster, shape="board", table=None,
            recording=SimpleNamespace(path=Path(f"{place}"), camera=camera), reconstructed=False,
        )  # fmt: skip
        count = np.isfinite(frames).sum(axis=0).astype(np.int32)
        mean, std = frames.mean(axis=0).astype(np.float32), frames.std(axis=0, ddof=1).astype(np.float32)
        blocks.append(FrameBlock(stage, tuple(range(FRAMES)), view, mean, std, count, T_stated))
    return blocks


def sensor():
    return Sensor("made up", "itof", (AxialNoise(c0=NOISE_M),))


def told(wrong):
    observations = observe(sensor(), looks_at_boards(wrong))
    setting = without_laws(observations, covariance_of(observations))
    white = setting.covariance.whiten(setting.observations.residual)
    return file_error(setting.observations, setting.covariance.pulled(white)), float(white @ white) / len(white)


def test_the_file_that_is_stated_is_wrong_by_what_is_planted():
    off, own = stated(WRONG), WRONG.taken_from(stated(WRONG))
    assert [own.fx, own.fy, own.cx, own.cy] == pytest.approx([110.0, 110.0, 79.5, 59.5])
    assert own.distortion == pytest.approx(DEVICE.distortion)
    assert off.fy / off.fx == pytest.approx(1.013)


def test_a_lens_that_is_wrong_is_found():
    found, left = told(WRONG)
    assert left < 1.5
    # the centre and the tangential bend of a narrow lens move images nearly alike: only their sum is told well
    assert found.focal == pytest.approx(WRONG.focal, abs=0.004)
    assert found.aspect == pytest.approx(WRONG.aspect, abs=0.004)
    assert found.p1 == pytest.approx(WRONG.p1, abs=0.005)  # of it and of cy


def test_a_lens_that_is_right_is_left_alone():
    assert told(NONE)[0] == NONE


@pytest.mark.parametrize("camera", [0.0, 2.0])
def test_a_law_without_a_name_may_be_the_rest_of_a_wrong_lens(camera):
    law = SimpleNamespace(replicated=True, footprint=np.full(50, 2.0))
    seen = SimpleNamespace(observations=SimpleNamespace(loose=Loose(camera=camera)), white=np.full(50, 3.0))
    named = SimpleNamespace(white=seen.white, steps=())
    mean = MeanFindings(seen, named, SimpleNamespace(law=law), None, None, None)
    assert mean.foresees == (camera == 0.0)


@pytest.mark.slow
def test_a_wrong_lens_is_no_law():
    found = explained_looks(looks_at_boards(WRONG), sensor())
    told = verdict_of(found)
    assert told.nothing_missing and not told.indicated
    assert "the camera file seems wrong" in told.headline
