"""Planes tell planar z from range; what is curved itself tells nothing, and is not taken for a plane."""

from types import SimpleNamespace

import numpy as np
import pytest

from fusion.geometry.camera import Camera
from fusion.recording.checks.range_or_z import check_range_or_z

CAMERA = Camera(320, 240, 290.0, 290.0, 159.5, 119.5)
LENGTH = np.sqrt(1 + (CAMERA.rays() ** 2).sum(axis=-1))


def planes(index):
    """A wall askew, [m]."""
    rays = CAMERA.rays()
    return 1.2 / (1 + 0.1 * index * rays[..., 0] - 0.2 * rays[..., 1])


def ball(radius, distance=0.7):
    """(240, 320) [m] a ball that fills much of the image, nothing around it."""
    rays = np.dstack([CAMERA.rays(), np.ones(CAMERA.shape)]).astype(float)
    square, along = (rays**2).sum(axis=-1), rays[..., 2] * (distance + radius)
    under = along**2 - square * ((distance + radius) ** 2 - radius**2)
    with np.errstate(invalid="ignore"):
        return np.where(under > 0, (along - np.sqrt(under)) / square, np.nan)


def cap(index):
    """A shield and a round top, as of a cap, turned a little from image to image."""
    low = ball(0.16, 0.75)
    return np.fmin(ball(0.09), low + 0.02 * np.cos(index) * CAMERA.rays()[..., 0])


def told(depth_of, count=6):
    random = np.random.default_rng(0)
    depths = {i: (depth_of(i) + 0.0008 * random.standard_normal(CAMERA.shape)).astype(np.float32) for i in range(count)}
    (finding,) = check_range_or_z(SimpleNamespace(depths=depths, rays=CAMERA.rays()))
    return finding


def test_planes_are_told_from_ranges():
    assert told(planes).severity == "ok" and "0.0" in told(planes).seen
    found = told(lambda i: planes(i) * LENGTH)
    assert found.severity == "error" and "along the ray" in found.do


def figure(index, seed=0):
    """A body as of a statue that turns, nothing around it: its nearest side bends by centimetres over its width."""
    rng = np.random.default_rng(seed)
    rays = np.dstack([CAMERA.rays(), np.ones(CAMERA.shape)]).astype(float)
    best = np.full(CAMERA.shape, np.nan)
    angle = 0.5 * index
    turn = np.array([[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]])
    for _ in range(5):  # ellipsoids, flat ones among them
        middle, half = rng.uniform(-0.05, 0.05, 3) * [1, 3, 1], rng.uniform([0.03, 0.08, 0.02], [0.12, 0.18, 0.1])
        to_unit = np.diag(1 / half) @ turn
        o, v = to_unit @ -(np.array([0, 0, 0.9]) + turn.T @ middle), rays @ to_unit.T
        a, b, c = (v * v).sum(-1), v @ o, o @ o - 1
        under = b * b - a * c
        with np.errstate(invalid="ignore"):
            best = np.fmin(best, np.where(under > 0, (-b - np.sqrt(under)) / a, np.nan))
    return best


@pytest.mark.parametrize("seed", range(6))
def test_what_is_nearly_flat_somewhere_is_not_judged(seed):
    for ranges in (1.0, LENGTH):
        assert told(lambda i, unit=ranges: figure(i, seed) * unit, 12).severity == "ok"


@pytest.mark.parametrize(
    "shape", [cap, lambda i: ball(0.09), lambda i: ball(0.16), lambda i: ball(0.3, 0.6 + 0.02 * i)]
)
@pytest.mark.parametrize("unit", [1.0, LENGTH])
def test_what_is_curved_is_not_judged(shape, unit):
    assert told(lambda i: shape(i) * unit).severity == "ok"
