"""The place of a projector is told from shadows a few pixels wide, within its interval: rows of an edge go together."""

from types import SimpleNamespace

import numpy as np
import pytest
from made_up_walls import FRAMES

from fusion.discrepancy.channels.dropout import dropout_steps
from fusion.discrepancy.observe.frame_block import FrameBlock
from fusion.discrepancy.observe.observations import observe
from fusion.geometry.camera import Camera
from fusion.mesh.mesh import Mesh
from fusion.sensor.effects.readout.axial_noise import AxialNoise
from fusion.sensor.sensor import Sensor
from fusion.simulation.rendering.render import Channels, RayCaster

CAMERA = Camera(96, 72, 130.0, 130.0, 47.5, 35.5, principle="structured_light")
HALF_M, THICK_M, NOISE_PX = 0.15, 0.03, 0.05


def box(low, high):
    corners = np.array(np.meshgrid(*zip(low, high, strict=True), indexing="ij")).reshape(3, 8).T
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return corners, [face for a, b, c, d in sides for face in ((a, b, c), (a, c, d))]


def board_before_wall(gap):
    low, high = (-HALF_M, -1.0, gap - THICK_M), (HALF_M, 1.0, gap)
    (board, faces), (wall, others) = box(low, high), box((-4.0, -4.0, -0.1), (4.0, 4.0, 0.0))
    return Mesh(np.concatenate([board, wall]), np.array(faces + [tuple(np.add(face, 8)) for face in others], np.int32))


def camera_at(rng, gap):
    """A pose that looks at the board, a little turned about all axes."""
    distance, angle = rng.uniform(0.8, 1.6) + gap, np.deg2rad(rng.uniform(-12, 12))
    place = np.array([distance * np.sin(angle), rng.uniform(-0.1, 0.1), distance * np.cos(angle)])
    forward = np.array([0.05 * rng.normal(), 0.0, gap / 2]) - place
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, [0.0, 1.0, 0.0])
    right /= np.linalg.norm(right)
    roll, down = 0.04 * rng.normal(), np.cross(forward, right)
    T = np.eye(4)
    T[:3, 0], T[:3, 1] = np.cos(roll) * right + np.sin(roll) * down, np.cos(roll) * down - np.sin(roll) * right
    T[:3, 2], T[:3, 3] = forward, place
    return T


def look(place, caster, gap, baseline, rng):
    """What is measured a millimetre and a milliradian beside the stated pose; no value where the board is between."""
    stated = camera_at(rng, gap)
    x, y, z = rng.normal(0, 0.001, 3)
    off = np.array([[1, -z, y, 0], [z, 1, -x, 0], [-y, x, 1, 0], [0, 0, 0, 1.0]])
    off[:3, 3] = rng.normal(0, 0.001, 3)
    true = stated @ off
    depth = caster.view(CAMERA, true, Channels(color=False)).depth.astype(float)
    points = depth[..., None] * np.dstack([CAMERA.rays(), np.ones(depth.shape)]) @ true[:3, :3].T + true[:3, 3]
    towards = true[:3, 3] + baseline * true[:3, 0] - points
    with np.errstate(all="ignore"):
        ends = [(limit - points - 1e-3 * towards) / towards for limit in
                ((-HALF_M, -1.0, gap - THICK_M), (HALF_M, 1.0, gap))]  # fmt: skip
    first, last = np.minimum(*ends).max(axis=-1), np.maximum(*ends).min(axis=-1)
    dark = (first < last) & (last > 0) & (first < 1)
    std = NOISE_PX * depth**2 / (CAMERA.fx * 0.075)
    mean = np.where(dark, np.nan, depth + std * rng.standard_normal(depth.shape) / np.sqrt(FRAMES))
    stage = SimpleNamespace(place=place, sigma_m=0.001, sigma_rad=0.001, mesh_sigma_m=0.0, caster=caster)
    view = caster.view(CAMERA, stated, Channels(color=False, edges=True))
    count = np.where(dark, 0, FRAMES).astype(np.int32)
    return FrameBlock(stage, tuple(range(FRAMES)), view, mean, np.where(dark, np.nan, std), count, stated)


@pytest.mark.parametrize("seed", range(6))
def test_a_projector_stands_within_its_interval(seed):
    rng = np.random.default_rng(seed)
    baseline, gap = rng.choice([-1, 1]) * rng.uniform(0.05, 0.11), rng.uniform(0.15, 0.4)
    caster = RayCaster(board_before_wall(gap))
    blocks = [look(place, caster, gap, baseline, rng) for place in range(6)]
    sensor = Sensor("made up", "structured_light", (AxialNoise(sigma_px=NOISE_PX),))
    (step,) = dropout_steps(observe(sensor, blocks))[1]
    assert step.effect.name == "projector_shadow"
    assert step.effect.baseline == pytest.approx(baseline, abs=3 * step.std["baseline"])
    assert step.std["baseline"] < 0.1 * abs(baseline)
