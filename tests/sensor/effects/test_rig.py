"""The rig: shifts, shears and shakes, against the exact picture of what has moved."""

from dataclasses import replace

import numpy as np
import pytest
from walls import CAMERA, step, wall

from fusion.geometry.pose import about_axis, exp
from fusion.sensor.effects.rig.motion_blur import MotionBlur
from fusion.sensor.effects.rig.pose_jitter import PoseJitter
from fusion.sensor.effects.rig.rolling_shutter import RollingShutter
from fusion.sensor.effects.rig.table import table_frame
from fusion.sensor.effects.rig.timestamp_offset import TimestampOffset
from fusion.sensor.effects.rig.turntable_eccentricity import TurntableEccentricity
from fusion.sensor.effects.rig.turntable_encoder_error import TurntableEncoderError
from fusion.sensor.effects.rig.turntable_wobble import TurntableWobble
from fusion.sensor.moment import Moment
from fusion.sensor.view import View

POINT, AXIS = np.array([0.05, 0.1, 1.3]), np.array([0.1, -0.8, -0.59])
ANGLES = np.linspace(-7, 7, 9)


def ball(center, radius=0.3) -> View:
    """The front of a ball, NaN beside it and where it is seen at more than 60 deg."""
    rays = np.dstack([CAMERA.rays().astype(float), np.ones(CAMERA.shape)])
    a, b, c = (rays**2).sum(-1), rays @ center, np.dot(center, center) - radius**2
    with np.errstate(invalid="ignore"):
        depth = (b - np.sqrt(b**2 - a * c)) / a
    normals = (rays * depth[..., None] - center) / radius
    slanted = -(normals * rays).sum(-1) / np.sqrt(a) < 0.5
    return View(CAMERA, np.where(slanted, np.nan, depth), normals=normals)


def moment(angle: float) -> Moment:
    return Moment(table_angle=angle, axis_point=POINT, axis_direction=AXIS)


class TestTimestampOffset:
    def test_a_ball_is_seen_where_it_will_be(self):
        center, velocity = np.array([0.02, -0.03, 1.5]), np.array([0.06, -0.03, 0.04])
        view = ball(center)
        view = replace(view, velocity=np.broadcast_to(velocity, view.normals.shape))
        for offset in (0.02, -0.02):
            exact = ball(center + velocity * offset).depth - view.depth
            bias = TimestampOffset(offset).bias(view.depth, view)
            both = np.isfinite(exact)
            assert both.sum() > 100 and np.abs(exact[both]).max() > 1e-3
            # sagitta of 1.6 mm on a ball of 0.3 m, seen at 60 deg: s^2 / (2 r cos^3)
            assert np.abs(bias - exact)[both].max() < 0.0016**2 / (2 * 0.3 * 0.5**3)

    def test_reversing_the_table_flips_the_sign(self):
        view = wall("itof", (0.5, 0.0, -1.0), velocity=np.full((*CAMERA.shape, 3), 0.1))
        back = replace(view, velocity=-view.velocity)
        effect = TimestampOffset(0.03)
        assert np.allclose(effect.bias(view.depth, view), -effect.bias(view.depth, back))

    def test_a_wall_that_recedes_is_farther_later(self):
        view = wall("itof", velocity=np.broadcast_to([0.0, 0.0, 0.5], (*CAMERA.shape, 3)))
        assert np.allclose(TimestampOffset(0.02).bias(view.depth, view), 0.01)


class TestRollingShutter:
    def test_rows_differ_by_line_time(self):
        view = wall("itof", velocity=np.broadcast_to([0.0, 0.0, 0.5], (*CAMERA.shape, 3)))
        bias = RollingShutter(1e-4).bias(view.depth, view)
        assert np.allclose(np.diff(bias, axis=0), 0.5e-4)
        assert np.allclose(bias[24], 0) and np.allclose(bias, -bias[::-1])  # 49 rows: row 24 is the middle

    def test_unknown_velocity_changes_nothing(self):
        view = wall("itof")
        holes = replace(view, velocity=np.full((*CAMERA.shape, 3), np.nan))
        for effect in (RollingShutter(1e-4), TimestampOffset(0.1)):
            assert not np.any(effect.bias(view.depth, view)) and not np.any(effect.bias(view.depth, holes))


class TestTable:
    def test_frame_looks_at_the_camera(self):
        first, second, axis = table_frame(moment(0))
        assert np.allclose(np.cross(first, second), axis) and np.allclose(np.linalg.norm([first, second], axis=1), 1)
        assert first @ -POINT > 0 and abs(second @ POINT) < 1e-12
        assert np.allclose(axis, AXIS / np.linalg.norm(AXIS))

    @pytest.mark.parametrize("direction", [(0, 0, -1), (0, 0, 2)])
    def test_a_camera_above_the_table_has_a_frame_too(self, direction):
        overhead = Moment(axis_point=np.array([0.0, 0.0, 1.0]), axis_direction=np.array(direction))
        frame = table_frame(overhead)
        assert np.allclose(frame @ frame.T, np.eye(3)) and np.allclose(frame[0], [0, 1, 0])

    def test_no_frame_without_a_table(self):
        assert table_frame(Moment()) is None
        assert table_frame(Moment(axis_point=POINT, axis_direction=np.zeros(3))) is None

    @pytest.mark.parametrize("angle", ANGLES)
    def test_eccentricity_is_a_turn_about_another_axis(self, angle):
        effect = TurntableEccentricity(0.01, 0.6)
        first, second, _ = table_frame(moment(0))
        true_point = POINT + 0.01 * (np.cos(0.6) * first + np.sin(0.6) * second)
        moved = exp(effect.motion(moment(angle))) @ about_axis(POINT, AXIS, angle)
        assert np.allclose(moved, about_axis(true_point, AXIS, angle), atol=1e-12)

    def test_eccentricity_as_in_the_catalogue(self):
        first, second, _ = table_frame(moment(0))
        for angle in ANGLES:
            shift = TurntableEccentricity(0.01).motion(moment(angle))[3:]
            assert shift @ first == pytest.approx(0.01 * (1 - np.cos(angle)), abs=1e-12)
            assert shift @ second == pytest.approx(-0.01 * np.sin(angle), abs=1e-12)

    @pytest.mark.parametrize("angle", ANGLES)
    def test_encoder_error_is_a_further_turn(self, angle):
        effect = TurntableEncoderError(np.array([0.01, -0.004]), np.array([0.3, 1.1]))
        true = angle + 0.01 * np.sin(angle + 0.3) - 0.004 * np.sin(2 * angle + 1.1)
        moved = exp(effect.motion(moment(angle))) @ about_axis(POINT, AXIS, angle)
        assert np.allclose(moved, about_axis(POINT, AXIS, true), atol=1e-12)

    def test_one_amplitude_is_the_first_harmonic(self):
        assert TurntableEncoderError(0.01, 0.5).further(1.0) == pytest.approx(0.01 * np.sin(1.5))

    def test_wobble_is_a_lean_of_the_plate_that_turns_with_it(self):
        effect = TurntableWobble(0.02, 0.4)
        axis = AXIS / np.linalg.norm(AXIS)
        leans = []
        for angle in ANGLES:
            T, turn = exp(effect.motion(moment(angle))), about_axis(POINT, AXIS, angle)
            assert np.arccos((T[:3, :3] @ axis) @ axis) == pytest.approx(0.02)
            assert np.allclose(T[:3, :3] @ POINT + T[:3, 3], POINT)
            leans.append(np.linalg.inv(turn) @ T @ turn)
        assert np.allclose(leans, leans[0], atol=1e-12)

    @pytest.mark.parametrize("angle", ANGLES)
    def test_wobble_as_on_a_dial_gauge(self, angle):
        first, _, axis = table_frame(moment(0))
        T = exp(TurntableWobble(0.002, 0.4).motion(moment(angle)))
        rim, top = POINT + 0.1 * first, POINT + 0.3 * axis
        rise = (T[:3, :3] @ rim + T[:3, 3] - rim) @ axis
        # second order: a tilt of 0.002 at 0.1 m
        assert rise == pytest.approx(0.1 * 0.002 * np.sin(angle + 0.4), abs=0.1 * 0.002**2)
        assert np.linalg.norm(T[:3, :3] @ top + T[:3, 3] - top) == pytest.approx(0.3 * 0.002, rel=1e-5)


class TestPoseJitter:
    def test_a_wall_shows_three_of_six_motions(self):
        view = wall("itof", (0.4, -0.3, -1.0))
        effect, rng = PoseJitter(1e-4, 1e-4), np.random.default_rng(0)
        draws = np.array([(effect.sampled(view.depth, view, rng) - view.depth).ravel() for _ in range(30)])
        values = np.linalg.svd(draws, compute_uv=False)
        # a plane does not show a shift or turn within itself: three of the six
        assert values[2] > 0.01 * values[0] and values[3] < 1e-3 * values[0]

    def test_frontal_wall(self):
        view = wall("itof", distance=2.0)
        rho = np.linalg.norm(view.camera.rays(), axis=-1)
        # a turn by w about an axis across tilts the wall by w: at a lateral distance z rho
        expected = np.hypot(0.001, 0.002 * 2.0 * rho)
        assert np.allclose(PoseJitter(0.001, 0.002).noise(view.depth, view), expected, rtol=1e-5, atol=1e-6)

    def test_all_pixels_share_a_shift(self):
        view = wall("structured_light")
        drawn = PoseJitter(0.001, 0.0).sampled(view.depth, view, np.random.default_rng(2)) - view.depth
        assert np.ptp(drawn) < 1e-12 and abs(drawn[0, 0]) > 1e-5


class TestMotionBlur:
    NEAR, FAR, AT, SHUTTER = 1.0, 1.4, 30.3, 0.05

    def view(self, principle, speed_px, **more):
        return step(principle, self.AT, self.NEAR, self.FAR, velocity=(speed_px * self.NEAR / 60.0, 0.3, 0.0), **more)

    def exposed(self, view, smear, light):
        """The measured row when 4001 short exposures follow the edge."""
        places = self.AT + smear * (np.arange(4001) / 4000 - 0.5)
        near = np.arange(CAMERA.width)[:, None] < places
        depth, amplitude = np.where(near, self.NEAR, self.FAR), np.where(near, light, 1.0)
        if not view.time_of_flight:
            return (depth * amplitude).mean(1) / amplitude.mean(1)
        stretch = view.stretch[24][:, None].astype(float)
        phasor = (amplitude * np.exp(2j * np.pi * depth * stretch / view.wavelength)).mean(1)
        turns = np.angle(phasor * np.exp(-2j * np.pi * self.NEAR * stretch[:, 0] / view.wavelength)) / (2 * np.pi)
        return self.NEAR + turns * view.wavelength / stretch[:, 0]

    @pytest.mark.parametrize("principle", ["itof", "structured_light"])
    @pytest.mark.parametrize("light", [1.0, 3.0])
    def test_is_the_mean_over_the_exposure(self, principle, light):
        view = self.view(principle, 100.0, light=light)
        measured = view.depth + MotionBlur(self.SHUTTER).bias(view.depth, view)
        # 100 px/s for 0.05 s; the steps of the numerical exposure are 1/4000 of a jump of 0.4 m, thrice as bright
        assert np.abs(measured[24] - self.exposed(view, 5.0, light)).max() < 0.4 / 1000
        changed = np.nonzero(measured[24] != view.depth[24])[0]
        assert changed.tolist() == [28, 29, 30, 31, 32]  # 30.3 +- 2.5 px

    def test_direction_of_the_motion_does_not_matter(self):
        ahead, back = self.view("itof", 100.0), self.view("itof", -100.0)
        effect = MotionBlur(self.SHUTTER)
        assert np.array_equal(effect.bias(ahead.depth, ahead), effect.bias(back.depth, back))

    def test_an_edge_that_moves_along_itself_or_not_at_all_stays(self):
        for view in (self.view("itof", 0.0), replace(self.view("itof", 100.0), velocity=None)):
            assert not np.any(MotionBlur(self.SHUTTER).bias(view.depth, view))

    def test_a_moving_background_is_no_moving_edge(self):
        view = self.view("itof", 100.0)
        behind = replace(view, velocity=np.where(view.depth[..., None] == self.FAR, (2.0, 0.0, 0.0), 0.0))
        assert not np.any(MotionBlur(self.SHUTTER).bias(view.depth, behind))

    def test_an_edge_that_comes_nearer_spreads_from_the_middle(self):
        view = step("itof", self.AT, self.NEAR, self.FAR, velocity=(0.0, 0.0, -10.0))
        # the edge is 1.7 px left of the axis: d(u)/dt = -(u - cx) velocity_z / z = -17 px/s, 0.85 px in 0.05 s
        bias = MotionBlur(self.SHUTTER).bias(view.depth, view)[24]
        share = 0.5 - np.abs(np.array([30, 31]) - self.AT) / 0.85
        assert np.nonzero(bias)[0].tolist() == [30] and share[0] > 0 > share[1]
