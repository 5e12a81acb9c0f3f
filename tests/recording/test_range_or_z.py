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


@pytest.mark.parametrize(
    "shape", [cap, lambda i: ball(0.09), lambda i: ball(0.16), lambda i: ball(0.3, 0.6 + 0.02 * i)]
)
@pytest.mark.parametrize("unit", [1.0, LENGTH])
def test_what_is_curved_is_not_judged(shape, unit):
    assert told(lambda i: shape(i) * unit).severity == "ok"
