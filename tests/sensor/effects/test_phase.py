"""Phase: how light becomes a range, against phasors and four phase images summed by hand."""

from dataclasses import replace

import numpy as np
import pytest

from fusion.errors import SensorError
from fusion.geometry.camera import Camera
from fusion.sensor.effects.phase.amplitude_error import AmplitudeError
from fusion.sensor.effects.phase.column_delay import ColumnDelay
from fusion.sensor.effects.phase.cyclic_error import CyclicError
from fusion.sensor.effects.phase.emitter_parallax import EmitterParallax
from fusion.sensor.effects.phase.mixed_pixels import MixedPixels, share_beyond
from fusion.sensor.effects.phase.motion_artifact import MotionArtifact
from fusion.sensor.effects.phase.phase_wrapping import PhaseWrapping
from fusion.sensor.effects.phase.pixel_crosstalk import PixelCrosstalk
from fusion.sensor.effects.phase.sensor_interference import SensorInterference
from fusion.sensor.moment import Moment
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import LIGHT_SPEED, Edges, View

HEIGHT, WIDTH = 32, 40
CAMERA = Camera(WIDTH, HEIGHT, 40.0, 42.0, 20.0, 15.0, principle="itof")
STRETCH = np.sqrt(1 + (CAMERA.rays().astype(float) ** 2).sum(axis=-1))
PER_METRE = 4 * np.pi * View(CAMERA).modulation / LIGHT_SPEED  # [rad/m]
EDGE = 19.7  # [px] a column between two pixels


def full(value: float) -> np.ndarray:
    return np.full(CAMERA.shape, value)


def ramp() -> np.ndarray:
    """Depths (h, w) of 0.5 to 4 m."""
    return np.linspace(0.5, 4, WIDTH * HEIGHT).reshape(CAMERA.shape)


def step(ratio: float = 1.0, near: float = 1.0, jump: float = 0.3) -> View:
    """A thing left of an upright edge, a wall right of it that sends `ratio` of its light."""
    u = np.arange(WIDTH) * np.ones((HEIGHT, 1))
    left = u < EDGE
    edges = Edges(
        np.abs(u - EDGE),
        np.where(left, 0.0, np.pi),
        np.where(left, jump, -jump),
        np.where(left, ratio, 1 / ratio),
    )
    return View(CAMERA, np.where(left, near, near + jump), edges=edges)


class TestEmitterParallax:
    def test_both_ways_by_hand(self):
        b, direction = 0.08, 0.6
        lamp = np.array([b * np.cos(direction), b * np.sin(direction), 0.0])
        points = np.dstack([CAMERA.rays() * ramp()[..., None], ramp()])
        expected = (np.linalg.norm(points - lamp, axis=-1) + np.linalg.norm(points, axis=-1)) / 2
        measured = Sensor(effects=(EmitterParallax(b, direction),)).predict(ramp(), View(CAMERA))
        assert measured * STRETCH == pytest.approx(expected, abs=1e-6)  # rays are single precision

    def test_catalogue_figures(self):
        on_axis = EmitterParallax(0.05, 0.0).bias(full(0.5), View(CAMERA))[15, 20]
        assert on_axis == pytest.approx(0.05**2 / (4 * 0.5), rel=0.01)  # 1.3 mm at 0.5 m
        # far away the tilt term is left: -(b / 2) sin(psi), nearer on the lamp's side
        far = EmitterParallax(0.05, 0.0).bias(full(100.0), View(CAMERA))[15] * STRETCH[15]
        assert far == pytest.approx(-0.025 * (np.arange(WIDTH) - 20) / 40 / STRETCH[15], abs=1e-5)

    def test_turned_lamp_turns_the_error(self):
        right, below = (EmitterParallax(0.05, a).bias(full(1.0), View(CAMERA)) for a in (0.0, np.pi / 2))
        assert right[15, 30] < 0 < right[15, 10] and below[25, 20] < 0 < below[5, 20]


class TestMixedPixels:
    def test_pixels_at_the_edge_hold_the_mean_of_phasors(self):
        view = step(ratio=0.4)
        change = MixedPixels(1.0).bias(view.depth, view)
        # pixel 20 reaches from 19.5 to 20.5 and the edge is at 19.7: a fifth of it lies on the near thing
        own, other = (np.exp(1j * PER_METRE * z * STRETCH[:, 20]) for z in (1.3, 1.0))
        expected = np.angle((0.8 * own + 0.2 * other / 0.4) / own) / PER_METRE / STRETCH[:, 20]
        assert change[:, 20] == pytest.approx(expected, rel=1e-5)
        assert not change[:, :20].any() and not change[:, 21:].any()  # the centre of 19 is 0.7 px away

    def test_smaller_aperture_mixes_fewer_pixels(self):
        view = step()
        assert MixedPixels(0.5).bias(view.depth, view)[0, 20] < 0  # 0.35 px to each side reach the edge, 0.3 px away
        assert not MixedPixels(0.3).bias(view.depth, view).any()

    def test_range_can_lie_outside_of_both(self):
        # 1.1 m is more than half a turn (0.94 m) at 80 MHz
        view = step(near=1.0, jump=1.1)
        assert view.depth[15, 20] + MixedPixels(1.0).bias(view.depth, view)[15, 20] > 2.1

    def test_light_is_shared(self):
        view = step(ratio=0.5, jump=1e-9)
        light = MixedPixels(1.0).light(np.where(view.depth > 1, 50.0, 100.0), view.depth, view)
        assert light[:, 20] == pytest.approx(0.8 * 50 + 0.2 * 100)

    def test_triangulation_does_not_mix(self):
        view = replace(step(), principle="structured_light")
        assert not MixedPixels(1.0).bias(view.depth, view).any()

    def test_share_of_a_square(self):
        rng = np.random.default_rng(0)
        distance, direction = rng.uniform(0, 0.8, 50), rng.uniform(-4, 4, 50)
        x, y = np.meshgrid(*2 * [(np.arange(500) + 0.5) / 500 - 0.5])
        share = [(0.9 * (x * np.cos(a) + y * np.sin(a)) > d).mean() for d, a in zip(distance, direction, strict=True)]
        # counted on 500 x 500 points
        assert share_beyond(distance, direction, np.array(0.9)) == pytest.approx(np.array(share), abs=3e-3)


class TestPixelCrosstalk:
    def test_a_patch_on_a_slope_by_hand(self):
        ir = np.random.default_rng(3).uniform(100, 1000, CAMERA.shape)
        view = View(CAMERA, ramp(), ir=ir)
        light = ir * np.exp(1j * PER_METRE * ramp() * STRETCH)
        v, u = 10, 17
        four = light[v - 1, u] + light[v + 1, u] + light[v, u - 1] + light[v, u + 1]
        expected = np.angle((0.9 * light[v, u] + 0.1 / 4 * four) / light[v, u]) / PER_METRE / STRETCH[v, u]
        assert PixelCrosstalk(0.1).bias(ramp(), view)[v, u] == pytest.approx(expected, abs=1e-6)
        assert PixelCrosstalk(0.1).light(ir, ramp(), view)[v, u] == pytest.approx(
            abs(0.9 * light[v, u] + 0.1 / 4 * four), rel=1e-5
        )

    def test_a_sphere_about_the_camera_stays(self):
        view = View(CAMERA, 1.5 / STRETCH, ir=full(400.0))
        assert PixelCrosstalk(0.1).bias(view.depth, view) == pytest.approx(0, abs=1e-6)
        assert PixelCrosstalk(0.1).light(view.ir, view.depth, view)[1:-1, 1:-1] == pytest.approx(400, rel=1e-5)

    def test_missing_neighbours_count_nothing(self):
        depth = full(1.0)
        depth[:, 20] = np.nan
        change = PixelCrosstalk(0.1).bias(depth, View(CAMERA, depth, ir=full(400.0)))
        assert np.isfinite(change[np.isfinite(depth)]).all()


class TestMotionArtifact:
    def by_hand(self, z: np.ndarray, speed: float, duration: float) -> np.ndarray:
        """Depth along the axis from four phase images of a moving wall."""
        times = (np.arange(4) - 1.5) * duration / 4
        q = [np.cos(PER_METRE * (z + speed * t) - k * np.pi / 2) for k, t in enumerate(times)]
        true = PER_METRE * z
        turned = np.arctan2(q[1] - q[3], q[0] - q[2]) - true
        return np.angle(np.exp(1j * turned)) / PER_METRE

    def test_four_phases_of_an_approaching_wall(self):
        z = np.linspace(0.5, 3, 50)
        velocity = np.broadcast_to([0.0, 0.0, -2.0], (*CAMERA.shape, 3))
        found = [MotionArtifact(0.02).bias(full(d), View(CAMERA, full(d), velocity=velocity))[15, 20] for d in z]
        assert np.array(found) == pytest.approx(self.by_hand(z, -2.0, 0.02), abs=1e-6)
        # v duration / 8 cos(2 phase): 5 mm high, and 0 on the average
        assert np.max(np.abs(found)) == pytest.approx(2.0 * 0.02 / 8, rel=0.02)

    def test_only_the_radial_part_counts(self):
        velocity = np.broadcast_to([1.0, 0.0, 0.0], (*CAMERA.shape, 3))
        change = MotionArtifact(0.02).bias(full(1.1), View(CAMERA, full(1.1), velocity=velocity))
        assert change[15, 20] == pytest.approx(0, abs=1e-6) and abs(change[15, 39]) > 1e-4

    def sideways(self, speed: float) -> np.ndarray:
        view = step()
        velocity = np.zeros((*CAMERA.shape, 3))
        velocity[..., 0] = np.where(np.arange(WIDTH) < EDGE, speed, 0.0)  # the thing moves, the wall stands
        view = replace(view, velocity=velocity)
        still = np.zeros((*CAMERA.shape, 3))
        along = np.where(
            (np.arange(WIDTH) < EDGE)[None], MotionArtifact(0.1).bias(view.depth, replace(view, edges=None)), 0
        )
        assert not MotionArtifact(0.1).bias(view.depth, replace(view, velocity=still)).any()
        return MotionArtifact(0.1).bias(view.depth, view) - along

    def test_an_edge_that_passes_leaves_a_band(self):
        # 1 m/s at 1 m and 40 px m/m: 40 px/s, so in 0.1 s the edge goes from 17.7 to 21.7
        change = self.sideways(1.0)
        touched = np.flatnonzero(np.abs(change[15]) > 1e-5)
        assert touched.tolist() == [18, 19, 20, 21]
        assert np.array_equal(touched, np.flatnonzero(np.abs(self.sideways(-1.0)[15]) > 1e-5))
        # what an edge does to a pixel depends on which exposures it spoils
        assert not np.allclose(change[15], self.sideways(-1.0)[15], atol=1e-3)

    def test_a_pixel_half_of_whose_exposures_see_the_wall(self):
        view = step()
        edges = replace(view.edges, distance=np.where(np.arange(WIDTH) == 19, 1e-3, np.inf) * np.ones((HEIGHT, 1)))
        velocity = np.broadcast_to([-1e-3 * 40, 0.0, 0.0], (*CAMERA.shape, 3))
        change = MotionArtifact(0.1).bias(view.depth, replace(view, edges=edges, velocity=velocity))[15, 19]
        # the near thing at 1 m leaves the pixel in the middle: 0 and 1 see 1 m, 2 and 3 see 1.3 m
        z = np.array([1.0, 1.0, 1.3, 1.3]) * STRETCH[15, 19]
        q = np.cos(PER_METRE * z - np.arange(4) * np.pi / 2)
        expected = np.angle(np.exp(1j * (np.arctan2(q[1] - q[3], q[0] - q[2]) - PER_METRE * z[0])))
        # the edge needs 0.6 ms of the 100 for the thousandth of a pixel
        assert change == pytest.approx(expected / PER_METRE / STRETCH[15, 19], abs=0.005)


class TestSensorInterference:
    def test_a_slow_wave_in_time(self):
        times = np.linspace(0, 20, 200, endpoint=False)
        effect = SensorInterference(0.05, 0.2)
        wave = [effect.bias(full(1.0), View(CAMERA, moment=Moment(time=t)))[15, 20] for t in times]
        expected = np.angle(1 + 0.05 * np.exp(2j * np.pi * 0.2 * times)) / PER_METRE
        assert np.array(wave) == pytest.approx(expected, abs=1e-9)

    def test_noise_is_that_of_the_light(self):
        view = View(CAMERA, full(1.0), ir=np.where(np.arange(WIDTH) < 20, 1000.0, 250.0) * np.ones((HEIGHT, 1)))
        noise = SensorInterference(0.04).noise(view.depth, view) * STRETCH
        assert noise[:, 25] == pytest.approx(2 * noise[0, 0])
        assert SensorInterference(0.16).noise(view.depth, view) * STRETCH == pytest.approx(2 * noise)


class TestCyclicError:
    def test_harmonics_add_up_along_the_ray(self):
        effect = CyclicError([0.004, 0.002], [0.9, 0.45], [0.3, -1.0])
        r = ramp() * STRETCH
        expected = 0.004 * np.sin(2 * np.pi * r / 0.9 + 0.3) + 0.002 * np.sin(2 * np.pi * r / 0.45 - 1.0)
        assert effect.bias(ramp(), View(CAMERA)) * STRETCH == pytest.approx(expected, abs=1e-7)  # single precision rays

    def test_one_phase_serves_all_harmonics(self):
        both = CyclicError([0.004, 0.002], [0.9, 0.45], 0.5).bias(ramp(), View(CAMERA))
        single = [CyclicError(a, p, 0.5).bias(ramp(), View(CAMERA)) for a, p in ((0.004, 0.9), (0.002, 0.45))]
        assert both == pytest.approx(sum(single))

    def test_lists_of_unequal_length_are_refused(self):
        with pytest.raises(SensorError, match="cyclic_error"):
            CyclicError([0.004, 0.002], [0.9, 0.5, 0.3], 0.0)

    def test_left_where_two_ranges_look_alike(self):
        assert not CyclicError([0.01, 0.005], [0.94, 0.47]).why_not_corrected()
        assert CyclicError(0.05, 0.3).why_not_corrected()


class TestAmplitudeError:
    def test_power_of_the_darkness(self):
        ir = np.where(np.arange(WIDTH) < 20, 1000, 250).astype(np.uint16) * np.ones((HEIGHT, 1), np.uint16)
        view = View(CAMERA, full(1.0), ir=ir)
        change = AmplitudeError(0.002, 1.5, 500.0).bias(view.depth, view) * STRETCH
        assert change[:, 0] == pytest.approx(0.002 * 0.5**1.5) and change[:, -1] == pytest.approx(0.002 * 2**1.5)

    def test_no_light_tells_nothing(self):
        ir = np.array([0, np.nan, 100.0])[np.arange(WIDTH) % 3] * np.ones((HEIGHT, 1))
        change = AmplitudeError(0.002).bias(full(1.0), View(CAMERA, ir=ir))
        assert not change[:, 0].any() and not change[:, 1].any() and (change[:, 2] > 0).all()
        assert not np.any(AmplitudeError(0.002).bias(full(1.0), View(CAMERA)))

    def test_undone_with_the_infrared_image(self):
        view = View(CAMERA, full(1.0), ir=np.linspace(50, 2000, WIDTH * HEIGHT).reshape(CAMERA.shape))
        sensor = Sensor(effects=(AmplitudeError(0.004, 0.8),))
        assert sensor.correct(sensor.predict(ramp(), view), view) == pytest.approx(ramp(), abs=1e-6)


def test_wrapped_ranges():
    depth = ramp()
    measured = Sensor(effects=(PhaseWrapping(1.8),)).predict(depth, View(CAMERA)) * STRETCH
    assert (measured <= 1.8 + 1e-6).all()
    turns = (depth * STRETCH - measured) / 1.8
    assert turns == pytest.approx(np.rint(turns), abs=1e-6) and turns.max() > 2


def test_column_delay_is_a_tilt_of_the_range():
    change = ColumnDelay(1e-4, -2e-4).bias(full(1.0), View(CAMERA)) * STRETCH
    assert change[15, 20] == 0
    assert np.diff(change, axis=1) == pytest.approx(1e-4, rel=1e-3)
    assert np.diff(change, axis=0) == pytest.approx(-2e-4, rel=1e-3)


@pytest.mark.parametrize("effect", [MixedPixels(1.0), PixelCrosstalk(0.1), MotionArtifact(0.1), AmplitudeError(0.01)])
def test_what_is_not_known_changes_nothing(effect):
    assert not np.any(effect.bias(full(1.0), View(CAMERA, full(1.0))))
