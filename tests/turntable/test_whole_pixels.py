"""Rims in the fit against the model: a pixel there needs no normal of its own, and says most of the turn."""

from dataclasses import replace

import numpy as np
import pytest

from fusion.geometry.camera import Principle
from fusion.geometry.depth import point_map
from fusion.turntable.axis import Turns, about_axis
from fusion.turntable.model.rays import bundle, rays_of
from fusion.turntable.model.system import equations, solve
from fusion.turntable.selfcheck import NAMES, SelfCheck
from fusion.turntable.views import Region, usable
from fusion.turntable.whole import whole
from fusion.volume.volume import Volume, VolumeSettings

EVERYWHERE = Region(np.full(3, -9.0), np.full(3, 9.0))
HELD = SelfCheck(np.zeros(len(NAMES)), 0.4, 0.8, prior=np.zeros(len(NAMES)))


def beside(seen):
    """(h, w) pixels of which one of the four neighbours is not seen."""
    around = np.pad(seen, 1)
    return ~(around[:-2, 1:-1] & around[2:, 1:-1] & around[1:-1, :-2] & around[1:-1, 2:])


def test_all_pixels_but_the_outermost_take_part(owl_scene):
    depth = owl_scene.depths[0].astype(np.float32)
    surface = point_map(depth, owl_scene.camera, 0.001)
    seen = whole(depth, surface, EVERYWHERE)
    assert not (seen & beside(np.isfinite(depth))).any()
    assert (seen & ~np.isfinite(surface.normals[..., 0])).any()
    # an owl of 55 x 91 pixels has 3042, of which normals and their border take three along all rims
    assert seen.sum() > 1.3 * usable(surface, EVERYWHERE).sum()


def test_neither_side_of_a_step_takes_part(owl_scene):
    depth = np.full(owl_scene.camera.shape, 0.6, np.float32)
    depth[:, 80:] = 0.9
    seen = whole(depth, point_map(depth, owl_scene.camera, 0.001), EVERYWHERE)
    assert seen[5:-5, [70, 78, 81, 90]].all()
    assert not seen[:, [79, 80]].any()


def test_what_is_masked_takes_no_part(owl_scene):
    depth = np.full(owl_scene.camera.shape, 0.6, np.float32)
    surface = point_map(depth, owl_scene.camera, 0.001)
    depth[:, 80:] = np.nan
    seen = whole(depth, surface, EVERYWHERE)
    assert seen[5:-5, 78].all() and not seen[:, 79:].any()


@pytest.mark.parametrize("principle", [Principle.TIME_OF_FLIGHT, Principle.STRUCTURED_LIGHT])
def test_the_axis_hangs_on_no_window_that_sees_one_side_of_its_pixel(owl_scene, principle):
    """Rims of matched depth read nearer all round: the axis of a statue came 1 mm too near with them."""
    camera = replace(owl_scene.camera, principle=principle)
    depth = owl_scene.depths[0].astype(np.float32)
    surface = point_map(depth, camera, 0.001)
    values = rays_of(surface, whole(depth, surface, EVERYWHERE)).values
    bare = np.isnan(values[:, 3])
    assert bare.any() and np.isfinite(values[~bare, 7]).all()
    assert np.isinf(values[bare, 7]).all() == (principle == Principle.STRUCTURED_LIGHT)


def test_rims_tell_the_angles(owl_scene):
    """More than their number says: there a turn changes the depth most."""
    maps = [point_map(depth.astype(np.float32), owl_scene.camera, 0.001) for depth in owl_scene.depths]
    motion = Turns(owl_scene.axis, owl_scene.angles)
    model = Volume(VolumeSettings(voxel=0.002, truncation=0.010))
    for surface, pose in zip(maps, about_axis(*motion), strict=True):
        model.integrate(surface.points[..., 2], owl_scene.camera, pose)

    def angle_std_of_one(taken):
        rays = [rays_of(surface, pixels) for surface, pixels in zip(maps, taken, strict=True)]
        e = equations(bundle(rays), motion, model, HELD)
        found = solve(e, HELD, 1.0)
        return float(np.median(found.std[e.shared :] / found.scale) * np.sqrt(np.sum(taken)))

    inner = angle_std_of_one([usable(surface, EVERYWHERE) for surface in maps])
    every = angle_std_of_one([whole(surface.points[..., 2], surface, EVERYWHERE) for surface in maps])
    assert every < 0.9 * inner  # 0.84; 1 where all pixels tell the same
