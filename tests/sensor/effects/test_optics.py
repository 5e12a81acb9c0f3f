"""Optics: cameras against projection, a pane against rays traced by Snell's law, blur against a sum of light."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import fsolve
from scipy.special import ndtr
from walls import CAMERA, step, wall

from fusion.sensor.effects.optics.defocus import Defocus
from fusion.sensor.effects.optics.focal_length import FocalLength
from fusion.sensor.effects.optics.lens_distortion import LensDistortion
from fusion.sensor.effects.optics.principal_point import PrincipalPoint
from fusion.sensor.effects.optics.refraction import Refraction

GLASS, INDEX = 0.004, 1.5
TILTED = (0.5, -0.3, -1.0)
PIXELS = [(24, 32), (24, 60), (3, 32), (5, 7), (44, 50)]  # row, column: on the axis, along x, along y, oblique


class TestFocalLength:
    def test_triangulation_keeps_a_frontal_wall(self):
        view = wall("structured_light")
        assert np.abs(FocalLength(0.01).bias(view.depth, view)).max() < 1e-6  # rays are single precision

    def test_time_of_flight_makes_a_bowl(self):
        view = wall("itof")
        rho2 = (view.camera.rays().astype(float) ** 2).sum(-1)
        expected = 1e-3 * rho2 / (1 + rho2) * view.depth
        # second order: twice the square of 1e-3
        assert np.abs(FocalLength(1e-3).bias(view.depth, view) - expected).max() < 1.5 * 2e-6

    def test_things_look_smaller_through_a_stated_focal_length_that_is_too_long(self):
        true = FocalLength(0.01).true_camera(CAMERA)
        u, v = true.project(np.array([[0.3, 0.2, 1.0]]))[0]
        x, y = (u - CAMERA.cx) / CAMERA.fx, (v - CAMERA.cy) / CAMERA.fy
        assert (x, y) == pytest.approx((0.3 / 1.01, 0.2 / 1.01))


class TestPrincipalPoint:
    def test_stated_minus_true(self):
        true = PrincipalPoint(3.0, -2.0).true_camera(CAMERA)
        assert (true.cx, true.cy) == (29.0, 26.0)

    def test_a_wall_that_recedes_to_the_right_is_seen_farther(self):
        # the true ray of a pixel lies cx / fx farther to the right than stated
        view = wall("structured_light", (0.5, 0.0, -1.0))
        bias = PrincipalPoint(cx=3.0).bias(view.depth, view)
        x = CAMERA.rays()[..., 0] + 3.0 / 60.0
        np.testing.assert_allclose(view.depth + bias, 1.5 / (1 - 0.5 * x), atol=2e-6)  # single precision
        below = PrincipalPoint(cy=3.0).bias(view.depth, view)
        assert np.abs(below).max() < 1e-6


class TestLensDistortion:
    def test_true_rays_fall_on_their_pixels(self):
        true = LensDistortion(0.05, -0.03, 0.01, 0.002, -0.001).true_camera(CAMERA)
        rays = true.rays()[::8, ::8].reshape(-1, 2).astype(float)
        x, y = rays.T
        r2 = x**2 + y**2
        radial = 1 + 0.05 * r2 - 0.03 * r2**2 + 0.01 * r2**3
        u = 32 + 60 * (x * radial + 2 * 0.002 * x * y - 0.001 * (r2 + 2 * x**2))
        v = 24 + 60 * (y * radial + 0.002 * (r2 + 2 * y**2) - 2 * 0.001 * x * y)
        rows, columns = np.mgrid[0 : CAMERA.height : 8, 0 : CAMERA.width : 8]
        # 60 px times single precision, and what undistortion leaves
        assert np.abs(u - columns.ravel()).max() < 1e-3 and np.abs(v - rows.ravel()).max() < 1e-3

    def test_adds_to_the_stated_distortion(self):
        stated = replace(CAMERA, distortion=(0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8))
        true = LensDistortion(k1=0.01, k2=0.02, k3=0.03, p1=0.004, p2=0.005).true_camera(stated)
        assert true.distortion == pytest.approx((0.11, 0.22, 0.304, 0.405, 0.53, 0.6, 0.7, 0.8))

    def test_pulls_rays_inwards_where_the_picture_is_stretched(self):
        view = wall("itof")
        assert LensDistortion(k1=0.05).bias(view.depth, view).max() < 1e-6  # a frontal wall becomes a dome
        assert LensDistortion(k1=0.05).bias(view.depth, view)[0, 0] < -1e-3


class Pane:
    """A pane between 0.1 m and 0.1 m + GLASS before the sensor, and a wall: light by Snell's law, step by step."""

    def __init__(self, view):
        self.view = view
        self.normal = view.normals[0, 0]

    def behind(self, start, slope):
        """Where a ray from (start, 0, 0) leaves the pane, its direction there, and the optical length so far [m]."""
        outside = np.array([*slope, 1.0]) / np.linalg.norm([*slope, 1.0])
        entry = np.array([start, 0.0, 0.0]) + outside * 0.1 / outside[2]
        lateral = outside[:2] / INDEX  # Snell: the sine of the angle to the pane's normal
        inside = np.array([*lateral, np.sqrt(1 - lateral @ lateral)])
        return entry + inside * GLASS / inside[2], outside, 0.1 / outside[2] + INDEX * GLASS / inside[2]

    def seen(self, start, slope):
        """The point of the wall at the end of a ray, and the optical length to it [m]."""
        leaving, direction, length = self.behind(start, slope)
        further = (self.normal @ [0.0, 0.0, 1.5] - self.normal @ leaving) / (self.normal @ direction)
        return leaving + further * direction, length + further

    def measured(self, row, column, baseline=1e-3):
        slope = self.view.camera.rays()[row, column].astype(float)
        point, length = self.seen(0.0, slope)
        if self.view.time_of_flight:
            return length / np.sqrt(1 + slope @ slope)

        def miss(slope):
            leaving, direction, _ = self.behind(baseline, slope)
            return (leaving + direction * (point[2] - leaving[2]) / direction[2] - point)[:2]

        other = fsolve(miss, slope - [baseline / point[2], 0.0], xtol=1e-11)
        return baseline / (slope[0] - other[0])


class TestRefraction:
    def test_four_millimetres_of_glass(self):
        for principle, expected in (("structured_light", -0.001333), ("itof", 0.002)):
            view = wall(principle)
            assert Refraction(GLASS, INDEX).bias(view.depth, view)[24, 32] == pytest.approx(expected, abs=1e-6)
            assert np.array_equal(
                Refraction(GLASS).bias(view.depth, view), Refraction(GLASS, INDEX).bias(view.depth, view)
            )
            assert np.abs(Refraction(GLASS, 1.0).bias(view.depth, view)).max() < 1e-9  # air; single precision rays

    @pytest.mark.parametrize("principle", ["itof", "structured_light"])
    @pytest.mark.parametrize("normal", [(0, 0, -1), TILTED], ids=["frontal", "tilted"])
    def test_against_traced_rays(self, principle, normal):
        view = wall(principle, normal)
        bias = Refraction(GLASS, INDEX).bias(view.depth, view)
        for row, column in PIXELS:
            expected = Pane(view).measured(row, column) - view.depth[row, column]
            # triangulation: first order in a baseline of 1 mm at 1.5 m, of an effect of 1 to 3 mm
            assert bias[row, column] == pytest.approx(expected, abs=4e-6)
        assert np.ptp([bias[at] for at in PIXELS]) > 1e-4

    def test_depth_of_a_frontal_wall_does_not_matter(self):
        near, far = wall("itof", distance=0.6), wall("itof", distance=4.0)
        effect = Refraction(GLASS, INDEX)
        assert np.allclose(effect.bias(near.depth, near), effect.bias(far.depth, far), atol=1e-9)


class TestDefocus:
    @pytest.mark.parametrize("principle", ["itof", "structured_light"])
    @pytest.mark.parametrize("light", [1.0, 0.2, 5.0])
    def test_is_the_blurred_light(self, principle, light):
        near, far, at, width = 1.0, 1.3, 30.3, 0.9
        view = step(principle, at, near, far, light=light)
        measured = (view.depth + Defocus(width).bias(view.depth, view))[24]
        share = ndtr((at - np.arange(CAMERA.width)) / width)  # of the near half
        if principle == "itof":
            stretch = view.stretch[24].astype(float)
            near_light, far_light = (np.exp(2j * np.pi * z * stretch / view.wavelength) for z in (near, far))
            both = light * share * near_light + (1 - share) * far_light
            expected = near + np.angle(both / near_light) * view.wavelength / (2 * np.pi * stretch)
            arriving = Defocus(width).light(np.where(view.depth == near, 0.7 * light, 0.7), view.depth, view)
            assert np.abs(arriving[24] - 0.7 * np.abs(both)).max() < 3.2e-5 * (1 + light)  # as below
        else:
            expected = (light * share * near + (1 - share) * far) / (light * share + 1 - share)
        # beyond four widths the other side is left out: 3.2e-5 of a light up to five times the own, of 0.3 m
        assert np.abs(measured - expected).max() < 3.2e-5 * 5 * 0.3 + 1e-6

    def test_far_phasors_cancel_and_leave_both_depths(self):
        # 1.2 m is more than half of the 1.87 m in which the phase turns once: the far light counts as 0.67 m nearer
        view = step("itof", 30.3, 1.0, 2.2)
        measured = view.depth + Defocus(0.9).bias(view.depth, view)
        assert measured.min() < 0.99 or measured.max() > 2.21
        between = Defocus(0.9).bias(view.depth, step("structured_light", 30.3, 1.0, 2.2)) + view.depth
        assert between.min() >= 1.0 and between.max() <= 2.2

    def test_only_near_edges(self):
        view = step("itof", 30.3, 1.0, 1.3)
        bias = Defocus(0.7).bias(view.depth, view)
        assert np.nonzero(bias[24])[0].tolist() == [28, 29, 30, 31, 32, 33]  # 30.3 +- 2.8 px
        assert not np.any(Defocus(0.7).bias(view.depth, replace(view, edges=None)))
