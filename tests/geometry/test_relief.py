"""Points and normals of depth images: exact on planes, silent beside steps, the same as in plain numpy."""

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "reference"))

import relief_twin

from fusion.geometry.camera import Camera
from fusion.geometry.depth import point_map

CAMERAS = [
    Camera(96, 64, 90.0, 91.0, 47.5, 31.5),
    Camera(93, 61, 90.0, 91.0, 45.1, 30.3, distortion=(0.06, -0.14, 0.001, -0.002)),  # no multiple of eight
    Camera(3, 2, 90.0, 91.0, 1.0, 0.5),
]


@pytest.fixture(autouse=True, params=["tuned", "plain"])
def kernels(request, monkeypatch):
    """All of it holds for both."""
    monkeypatch.setenv("FUSION_KERNELS", request.param)


def plane(camera, normal, distance=1.2):
    """Depth of the plane n . p = -distance."""
    rays = np.dstack([camera.rays(), np.ones(camera.shape)])
    return (-distance / (rays @ normal)).astype(np.float32)


@pytest.mark.parametrize("camera", CAMERAS[:2])
@pytest.mark.parametrize("slant", [0.0, 0.4, 0.8])
def test_planes_have_their_normal_everywhere(camera, slant):
    normal = np.array([np.sin(slant) * 0.6, np.sin(slant) * 0.8, -np.cos(slant)])
    found = point_map(plane(camera, normal), camera, 0.002).normals[2:-2, 2:-2]
    assert np.isfinite(found).all()
    inner = found[4:-4, 4:-4]  # at the border the averages lean on one side
    # the average of a convex depth profile lies above it, alike on both sides: what remains is below half a degree
    assert np.degrees(np.arccos(np.clip(inner @ normal, -1, 1))).max() < 0.5


@pytest.mark.parametrize("camera", CAMERAS)
def test_it_is_what_numpy_finds(camera):
    rng = np.random.default_rng(0)
    v, u = np.mgrid[: camera.height, : camera.width]
    depth = (1 + 0.1 * np.sin(u / 9) * np.cos(v / 7) + 0.2 * (u > 40)).astype(np.float32)
    depth += rng.normal(0, 0.002, depth.shape).astype(np.float32)
    depth[rng.random(depth.shape) < 0.03] = np.nan
    sigma = np.full(camera.shape, 0.002, np.float32)
    found = point_map(depth, camera, sigma)
    true = relief_twin.relief(depth, camera, sigma, 0.012)
    assert (np.isfinite(found.normals) == np.isfinite(true)).mean() > 0.999  # single precision, at the limits
    both = np.isfinite(found.normals) & np.isfinite(true)
    assert np.abs(found.normals - true)[both].max(initial=0) < 1e-3
    assert np.array_equal(found.points, camera.points(depth), equal_nan=True)
    assert np.array_equal(np.isfinite(found.sigma), np.isfinite(depth))
    assert (sigma == np.float32(0.002)).all()  # what was given stays as it was


@pytest.mark.parametrize("camera", CAMERAS)
def test_incidence_is_the_angle_to_the_line_of_sight(camera):
    for slant in np.linspace(0, 1.2, 13):
        depth = plane(camera, np.array([np.sin(slant) * 0.6, np.sin(slant) * 0.8, -np.cos(slant)]))
        depth[depth <= 0] = np.nan
        depth[0, 0] = np.inf
        found = point_map(depth, camera, 0.002)
        points, normals = found.points.astype(float), found.normals.astype(float)
        with np.errstate(invalid="ignore"):
            cosine = -(points * normals).sum(axis=2) / np.linalg.norm(points, axis=2)
            true = np.arccos(np.clip(cosine, 0, 1))
            # the cosine is rounded to 2e-7, and near 0 the angle is the root of twice what it lacks to 1
            expected = 2e-7 / np.maximum(np.sin(true), np.sqrt(2e-7)) + 2e-7
        assert found.incidence is not None and np.array_equal(np.isfinite(found.incidence), np.isfinite(true))
        assert (np.abs(found.incidence - true) <= expected)[np.isfinite(true)].all()
        assert np.isnan(found.sigma[0, 0]) and np.isfinite(found.sigma[np.isfinite(depth)]).all()


def test_beside_holes_and_steps_there_is_no_normal():
    camera = CAMERAS[0]
    depth = np.ones(camera.shape, np.float32)
    depth[:, 48:] = 1.5
    depth[20, 20] = np.nan
    known = np.isfinite(point_map(depth, camera, 0.002).normals[..., 0])
    assert not known[:, 47:49].any()
    assert not known[19:22, 20].any() and not known[20, 19:22].any()
    assert known[10:50, 44].all() and known[19, 19]


def test_images_do_not_leave_traces_in_the_next():
    camera = CAMERAS[1]
    full, empty = plane(camera, np.array([0, 0, -1.0])), np.full(camera.shape, np.nan, np.float32)
    before = point_map(full, camera).normals
    assert np.isnan(point_map(empty, camera, np.full(camera.shape, np.nan)).normals).all()
    assert np.array_equal(point_map(full, camera).normals, before, equal_nan=True)
