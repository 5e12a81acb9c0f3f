"""A ball that turns below a lamp: paint, exposure and light are told apart, and left-out views are foretold."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from fusion.texture.lighting.exposure import SampledView, exposed
from fusion.texture.lighting.levels import levels_of
from fusion.texture.lighting.light import TERMS, Facings, Lighting

POINTS, VIEWS = 1500, 24
LAMP = np.array([0.6, -0.5, -0.62])  # from the object to it, in the camera's frame
NEAR = 0.3  # the ball is so wide, its middle 1 m away
EXPOSURE = 0.1


def rendered(source=0, lamp=LAMP, seed=0, ambient=0.4):
    """Views of a painted ball before a still camera: what each shows, and its true exposure (views, 3)."""
    rng = np.random.default_rng(seed)
    normals = np.random.default_rng(99).standard_normal((POINTS, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    paint = np.random.default_rng(98).uniform(60, 200, (POINTS, 3))
    looks, exposures = [], np.exp(EXPOSURE * rng.standard_normal((VIEWS, 3)))
    for k in range(VIEWS):
        n = Rotation.from_euler("xy", [25, 360 * k / VIEWS], degrees=True).apply(normals)
        index = np.flatnonzero(n[:, 2] < -0.25)
        facing = facing_of(n[index])
        low = (paint[index] * shade(facing, lamp, ambient) * exposures[k]).astype(np.float32)
        looks.append(SampledView(source, index, facing, np.ones(len(index), np.float32), low, low[:, 0]))
    return looks, exposures


def facing_of(normals):
    return Facings((normals * NEAR / 2 + [0, 0, 1]).astype(np.float32), normals.astype(np.float32))


def shade(facing, lamp=LAMP, ambient=0.4):
    """(k, 1) of a lamp 1.5 m away, and of light from all around."""
    way = np.array([0, 0, 1]) + 1.5 * lamp / np.linalg.norm(lamp) - facing.points
    distance = np.linalg.norm(way, axis=1, keepdims=True)
    cosine = (way / distance * facing.normals).sum(axis=1, keepdims=True)
    return ambient + np.maximum(cosine, 0) / distance**2


def test_paint_exposure_and_light_are_told_apart():
    looks, exposures = rendered()
    levels = levels_of(looks, POINTS)
    # what is evened agrees between views, where before it differed by a fifth
    before, after = (spread([look.low * factor for look, factor in zip(looks, by, strict=True)], looks) for by in (
        np.ones(VIEWS), [levels.even(k, look.facing) for k, look in enumerate(looks)]))  # fmt: skip
    assert before > 0.15 and after < 0.025
    np.testing.assert_allclose(levels.gain * exposures / (levels.gain * exposures).mean(axis=0), 1, atol=0.03)


def test_a_view_that_was_left_out_is_foretold():
    looks = rendered()[0]
    kept = [look for k, look in enumerate(looks) if k % 4]
    levels = levels_of(kept, POINTS)
    total, count = np.zeros((POINTS, 3)), np.zeros((POINTS, 1))
    for k, look in enumerate(kept):
        total[look.index] += look.low * levels.even(k, look.facing)
        count[look.index] += 1
    albedo = total / np.maximum(count, 1)
    for k in range(0, VIEWS, 4):
        look = looks[k]
        seen = count[look.index, 0] > 2
        told = albedo[look.index] * levels.lights[0].on(look.facing)
        off = np.log(told[seen] / look.low[seen])
        assert (off - off.mean(axis=0)).std() < 0.04  # the left-out exposure is no view's to know
        # an evenly lit ball would be wrong by far more
        flat = np.log(albedo[look.index][seen] / look.low[seen])
        assert (flat - flat.mean(axis=0)).std() > 0.1


def test_light_is_that_of_each_camera():
    """Two recordings of one object, lit from the left and from the right."""
    looks = rendered(0)[0] + rendered(1, lamp=LAMP * [-1, 1, 1], seed=1)[0]
    levels = levels_of(looks, POINTS)
    evened = [look.low * levels.even(k, look.facing) for k, look in enumerate(looks)]
    assert spread(evened, looks) < 0.03
    across = facing_of(np.array([[0.7, 0, -0.7], [-0.7, 0, -0.7]]))
    left, right = (light.on(across)[:, 0] for light in levels.lights)
    assert left[0] > 1.2 * left[1] and right[1] > 1.2 * right[0]


def test_even_light_is_left_alone():
    """Where light stands with the object, as for a camera that is carried around it, nothing is taken out."""
    looks = rendered(lamp=LAMP, ambient=1e6)[0]
    looks = [replace(v, low=v.low / 1e6) for v in looks]
    light = exposed(looks, POINTS).lights[0]
    assert np.abs(np.log(light.on(looks[0].facing))).max() < 0.005


def test_errors_that_are_no_light_are_not_taken_for_it():
    """Print that is off by its place and not by its light: a polynomial would follow the noise that views share."""
    looks, rng = rendered(lamp=LAMP, ambient=1e6)[0], np.random.default_rng(3)
    for v in looks:
        v.low[:] = v.low / 1e6 * np.exp(0.05 * rng.standard_normal(v.low.shape))
    assert (exposed(looks, POINTS).lights[0].numbers == 0).all()


def test_beyond_what_views_show_light_stays_what_it_was_there():
    light = exposed(rendered()[0], POINTS).lights[0]
    far = Facings(np.array([[5, 5, 9]], np.float32), np.array([[0, 0, 1]], np.float32))
    assert (np.log(light.on(far)) >= light.known[0] - 1e-6).all() and (
        np.log(light.on(far)) <= light.known[1] + 1e-6
    ).all()


def test_brighter_light_is_brighter_by_a_factor():
    light = Lighting(np.zeros(3), 1.0, np.zeros((TERMS, 3)), np.array([[-1.0] * 3, [1.0] * 3]))
    some = facing_of(np.array([[0, 0, -1.0]]))
    assert light.brighter(1.5).on(some) == pytest.approx(1.5 * light.on(some))


def spread(values, looks):
    """Relative standard deviation of the values of a point between its views, rms."""
    logs, index = np.log(np.concatenate(values)), np.concatenate([look.index for look in looks])
    count = np.maximum(np.bincount(index, minlength=POINTS), 1)
    out = 0.0
    for c in range(3):
        mean = np.bincount(index, logs[:, c], POINTS) / count
        out += np.mean((logs[:, c] - mean[index]) ** 2) / 3
    return np.sqrt(out)
