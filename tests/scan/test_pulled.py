"""What poses bend of a surface is told by pairs of views: noise alone bends next to nothing."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from made_up_scan import good_scan
from test_print_agreement import EVERYWHERE, RADIUS, T_WORLD_CAMERA, TURNS, ball, patches

from fusion.geometry import pose
from fusion.mesh.mesh import Mesh
from fusion.scan.judging.pulled import pulled
from fusion.turntable.axis import Axis, about_axis

T = pose.inverse(T_WORLD_CAMERA)
AXIS = Axis(T[:3, 3], T[:3, 2])
SPHERE = trimesh.creation.icosphere(subdivisions=4, radius=RADIUS)
MESH = Mesh(SPHERE.vertices + np.array([0, 0, 0.06]), SPHERE.faces.astype(np.int32), normals=SPHERE.vertex_normals)


def asked(angles, shifts, taken=None):
    """What is said of a motion that holds the axis still, where the ball was moved by shifts (n, 2) [m]."""
    random = np.random.default_rng(0)
    frames = [ball(turn, patches, random, shift) for turn, shift in zip(TURNS, shifts, strict=True)]
    motion = replace(good_scan().motion, axis=AXIS, angles=angles, plate=None, shifts=taken)
    return pulled(MESH, frames, about_axis(AXIS, angles, taken), motion, EVERYWHERE, 0.01)


def drift(size):
    """Round and back once and a half in a turn."""
    return size * np.column_stack([np.sin(1.5 * TURNS), np.cos(1.5 * TURNS) - 1])


def test_noise_bends_next_to_nothing():
    found = asked(TURNS, drift(0.0))
    assert found.surface < 3e-5, "of noise of 0.6 mm"
    assert found.unfit == 0


def bent(shifts):
    """What shifts of single views do to the ball that is the mean of all: first principles, views weighted by slant."""
    weight, along = np.zeros((2, len(MESH.vertices), len(TURNS)))
    for k, (turn, shift) in enumerate(zip(TURNS, shifts, strict=True)):
        back = pose.about_axis([0, 0, 0], [0, 0, 1], -turn)[:3, :3]
        towards = back @ T_WORLD_CAMERA[:3, 3] - MESH.vertices
        weight[:, k] = np.sum(towards * MESH.normals, axis=1) / np.linalg.norm(towards, axis=1)
        along[:, k] = MESH.normals @ back @ [*(shift - shifts.mean(axis=0)), 0]
    weight *= weight > 0.26  # flatter ones take no part
    seen = weight.sum(axis=1) > 0
    moved = (np.sum(weight * along, axis=1) / np.maximum(weight.sum(axis=1), 1e-9))[seen]
    lever = np.hstack([np.cross(MESH.vertices, MESH.normals), MESH.normals])[seen]
    return np.sqrt(np.mean((moved - lever @ np.linalg.lstsq(lever, moved, rcond=None)[0]) ** 2))


@pytest.mark.parametrize("size", [0.001, 0.003])
def test_a_drift_that_the_motion_does_not_know_bends_the_surface(size):
    found = asked(TURNS, drift(size))
    assert found.surface == pytest.approx(bent(drift(size)), rel=0.3)  # one step of the fit


def test_a_slip_of_a_ball_is_told_by_its_print_and_bends_nothing():
    """It moves the surface along itself."""
    found = asked(TURNS + np.deg2rad(2.0) * np.sin(2 * TURNS), drift(0.0))
    assert found.surface < 1e-4


def test_nothing_is_asked_where_no_view_has_a_place():
    assert asked(np.full_like(TURNS, np.nan), drift(0.0)) is None
