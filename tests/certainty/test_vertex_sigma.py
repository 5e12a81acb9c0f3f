"""What views differ by becomes the standard deviation of their mean; what they share does not average out."""

import numpy as np
import pytest
import trimesh
from scipy.optimize import nnls

from fusion.certainty.bend import bend, moved_by_blur
from fusion.certainty.common import Common, common_errors
from fusion.certainty.looks import Looks
from fusion.certainty.shared import NOTHING, Shared, _positive, shared_errors
from fusion.certainty.sigma import Causes, _grown, put_together
from fusion.certainty.vertex_sigma import vertex_sigma
from fusion.files.json_values import json_values
from fusion.geometry import pose
from fusion.geometry.camera import Camera
from fusion.mesh.mesh import Mesh
from fusion.recording.recording import Frame
from fusion.sensor.effects.readout.axial_noise import AxialNoise
from fusion.sensor.sensor import Sensor
from fusion.volume.prepared import prepare

VIEWS, VERTICES, SPREAD = 24, 3000, 1e-3
APART = np.abs(np.subtract.outer(np.arange(VIEWS), np.arange(VIEWS))) * np.deg2rad(5)
KNOWN = Common(None, None, 0.8, "nothing")
NO_BLUR = Causes(VIEWS, 0.0, 0.0, KNOWN)


def looks_of(off, apart=APART):
    """Views that count alike."""
    m, k = off.shape
    poses = np.tile(np.eye(4), (k, 1, 1))
    return Looks(off, np.full((m, k), SPREAD), np.ones((m, k)), apart, poses, np.full(m, 1e-3))


def drawn(share, reach, rng):
    """Errors (vertices, views) of which neighbouring views share a part."""
    alike = share * np.exp(-APART / reach) + (1 - share) * np.eye(VIEWS)
    return SPREAD * rng.standard_normal((VERTICES, VIEWS)) @ np.linalg.cholesky(alike).T


def flat(count):
    """Vertices far apart in a plane."""
    places = np.column_stack([np.arange(count) * 1e-3, np.zeros(count), np.zeros(count)])
    return Mesh(places, normals=np.tile(np.float32([0, 0, 1]), (count, 1)))


@pytest.mark.parametrize("share", [0.0, 0.5, 0.9])
def test_what_neighbours_share_is_found(share):
    found = shared_errors(looks_of(drawn(share, np.deg2rad(12), np.random.default_rng(1))))
    # 3000 vertices, whose errors are drawn, tell a share to some percent
    assert found.share == pytest.approx(share, abs=0.06)
    assert found.spread == pytest.approx(SPREAD, rel=0.05)


@pytest.mark.parametrize("share", [0.0, 0.5, 0.9])
def test_sigma_is_the_spread_of_the_mean(share):
    """The mean over the views, drawn 3000 times, spreads as the vertices say; the spread itself is not told."""
    reach = np.deg2rad(12)
    off = drawn(share, reach, np.random.default_rng(2))
    sure = put_together(flat(VERTICES), np.arange(VERTICES), looks_of(off), Shared(share, reach, SPREAD), NO_BLUR)
    # what 24 views that share much hide of their variance is a fifth of it
    assert sure.parts["noise"] == pytest.approx(np.std(off.mean(axis=1)), rel=0.15)


@pytest.mark.parametrize("seed", range(30))
def test_two_parts_that_are_none_below_zero_are_those_of_least_squares(seed):
    rng = np.random.default_rng(seed)
    grown = np.column_stack([np.ones(9), 1 - np.exp(-np.sort(rng.uniform(0, 2, 9)))])
    half = rng.normal(size=9)
    assert _positive(grown, half) == pytest.approx(tuple(nnls(grown, half)[0]), abs=1e-12)


def test_a_sample_stands_for_all_frames():
    off = drawn(0.0, 0.1, np.random.default_rng(3))
    few = put_together(flat(VERTICES), np.arange(VERTICES), looks_of(off), NOTHING, NO_BLUR)
    all_ = Causes(4 * VIEWS, 0.0, 0.0, KNOWN)
    many = put_together(flat(VERTICES), np.arange(VERTICES), looks_of(off), NOTHING, all_)
    assert many.parts["noise"] == pytest.approx(few.parts["noise"] / 2, rel=1e-6)


def test_of_one_view_the_model_is_all_that_is_known():
    one = looks_of(np.zeros((VERTICES, 1)), np.zeros((1, 1)))  # a surface lies where its only view has it
    sure = put_together(flat(VERTICES), np.arange(VERTICES), one, NOTHING, Causes(1, 0.0, 0.0, KNOWN))
    assert sure.parts["noise"] == pytest.approx(SPREAD, rel=1e-6)


def test_a_surface_beside_its_views_is_less_sure():
    off = drawn(0.0, 0.1, np.random.default_rng(4)) + 2e-3
    sure = put_together(flat(VERTICES), np.arange(VERTICES), looks_of(off), NOTHING, NO_BLUR)
    assert sure.parts["model"] == pytest.approx(2e-3, rel=0.02)
    assert np.median(sure.sigma) >= 1.9e-3


@pytest.mark.parametrize("radius", [0.02, 0.1])
def test_bend_of_a_ball_and_of_a_plane(radius):
    ball = trimesh.creation.icosphere(3, radius)
    mesh = Mesh(np.array(ball.vertices), np.array(ball.faces), np.array(ball.vertices / radius, np.float32))
    assert bend(mesh) == pytest.approx(2 / radius, rel=0.01)
    assert moved_by_blur(2 / radius, 1e-3) == pytest.approx(1e-6 / radius)
    grid = trimesh.creation.box((1, 1, 1)).subdivide()
    assert not bend(Mesh(np.array(grid.vertices), np.array(grid.faces), np.tile([0, 0, 1.0], (26, 1)))).any()


def test_calibration_acts_on_the_size():
    camera = Camera(640, 480, 500.0, 500.0, 319.5, 239.5, std={"fx": 1.0})
    common = common_errors(camera, None, 0.8)
    assert (common.told_by, common.scale) == ("calibration", 0.002)
    at = np.array([[0.1, 0, 0], [-0.1, 0, 0]])
    assert common.along(at, np.array([[1, 0, 0], [0, 0, 1]])) == pytest.approx([2e-4, 0])
    unknown = Camera(640, 480, 500.0, 500.0, 319.5, 239.5)
    nothing = common_errors(unknown, None, 0.8)
    assert nothing.unknown == ("focal length", "depth")
    assert nothing.values()["scale_relative"] is None
    assert common.unknown == ("depth",)
    assert common_errors(unknown, None, 0.8, (0.003, 0.03)).scale == pytest.approx(0.003, rel=0.01)


def wall(noise, rng, count=12):
    """A wall at 1 m seen by a camera that moves along it; mesh of it, frames, poses."""
    camera = Camera(80, 60, 70.0, 70.0, 39.5, 29.5)
    sensor = Sensor(effects=(AxialNoise(c0=noise),))
    y, x = np.mgrid[-0.2:0.2:40j, -0.2:0.2:40j]
    points = np.column_stack([x.ravel(), y.ravel(), np.ones(x.size)])
    at = np.arange(x.size).reshape(x.shape)
    a, b, c, d = (part.ravel() for part in (at[:-1, :-1], at[:-1, 1:], at[1:, :-1], at[1:, 1:]))
    faces = np.concatenate([np.column_stack([a, c, b]), np.column_stack([b, c, d])])
    mesh = Mesh(points, faces, np.tile(np.float32([0, 0, -1]), (len(points), 1)))
    poses = np.array([pose.pose(np.eye(3), [0.02 * (k - count / 2), 0, 0]) for k in range(count)])
    depths = [(1 + noise * rng.standard_normal(camera.shape)).astype(np.float32) for _ in poses]
    return mesh, [prepare(Frame(k, 0.1 * k, depth), camera, sensor) for k, depth in enumerate(depths)], poses


@pytest.mark.parametrize("noise", [0.001, 0.003])
def test_sigma_of_a_wall_follows_its_noise(noise):
    mesh, frames, poses = wall(noise, np.random.default_rng(5))
    sure = vertex_sigma(mesh, frames, poses, Causes(0, 0.0, 0.001, KNOWN), 0.02)
    # a pixel and its four neighbours, and between pixels: a variance of 0.31 to 0.16 of a pixel's; 12 views
    assert sure.parts["noise"] == pytest.approx(noise * np.sqrt(0.2 / 12), rel=0.25)
    assert np.median(sure.sigma) < noise / np.sqrt(12)
    assert sure.unseen == 0
    assert np.isfinite(sure.sigma).all()


def test_where_nobody_looked_nothing_is_claimed():
    mesh, frames, poses = wall(0.001, np.random.default_rng(6))
    sure = vertex_sigma(mesh, [None] * len(frames), poses, Causes(0, 0.0, 0.001, KNOWN), 0.02)
    assert np.isnan(sure.sigma).all()
    assert sure.unseen == 1
    assert json_values(sure.values())["sigma_median_m"] is None


def test_what_nobody_knows_is_said_and_is_no_zero():
    mesh, frames, poses = wall(0.001, np.random.default_rng(7))
    sure = vertex_sigma(mesh, frames, poses, Causes(0, 0.0, 0.001, KNOWN), 0.02)
    assert sure.unknown == ("focal length", "depth", "poses")
    assert (sure.parts["calibration"], sure.parts["poses"]) == (None, None)
    (said,) = sure.onto(mesh).notes
    assert said == "sigma: without what focal length, depth and poses may be wrong by, which nothing tells"
    known = Causes(0, 0.0, 0.001, Common(0.002, 0.001, 0.8, "calibration"), lambda points, *_: np.zeros(len(points)))
    told = vertex_sigma(mesh, frames, poses, known, 0.02)
    assert told.unknown == told.onto(mesh).notes == ()
    assert told.parts["calibration"] == pytest.approx(0, abs=1e-12)  # a wall through its middle turns no larger


def test_what_blur_flattens_is_told_as_size_beside_any_motion():
    """A ball whose surface comes out a hundredth too far out, and one that was only moved."""
    normals = np.random.default_rng(1).normal(size=(500, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    points, moved = 0.1 * normals + [0.0, 0.2, 0.9], normals @ [0.001, -0.002, 0.003]
    assert _grown(points, normals, moved + 0.001) == pytest.approx(0.01, rel=1e-6)
    assert _grown(points, normals, moved) == pytest.approx(0.0, abs=1e-9)
    common = Common(None, None, 0.9, "nothing", size=0.003, blur=0.004)
    assert common.whole == pytest.approx(0.005) and common.scale == pytest.approx(0.003)
