"""What windows and pixels flatten, by a ball whose windows are averaged here by brute force."""

import numpy as np
import pytest

from fusion.geometry import pose
from fusion.geometry.camera import Camera
from fusion.recording.recording import Frame
from fusion.scan.flattened import box, flattening, unflattened
from fusion.sensor.presets import default_sensor
from fusion.sensor.window import widest_window
from fusion.volume.prepared import fuse, prepare
from fusion.volume.volume import Volume, VolumeSettings

RADIUS, FAR = 0.08, 0.8
STEEP = 5.7 / 200.0


def camera(fine: int = 1) -> Camera:
    """96 x 96 px of 4 mm on the ball; `fine` times as many in the same picture."""
    n = 96 * fine
    return Camera(n, n, 200.0 * fine, 200.0 * fine, (n - 1) / 2, (n - 1) / 2, principle="structured_light")


def ball(camera: Camera, radius: float = RADIUS) -> np.ndarray:
    """Depth [m] of a ball straight ahead, NaN beside it."""
    x, y = np.moveaxis(camera.rays().astype(float), -1, 0)[:2]
    a = 1 + x**2 + y**2
    with np.errstate(invalid="ignore"):
        return (FAR - np.sqrt(FAR**2 - a * (FAR**2 - radius**2))) / a


def windowed(side: int, fine: int = 8) -> np.ndarray:
    """The ball through windows of `side` px: the mean of one over the depth of all the fine rays in them."""
    inverse = 1 / ball(camera(fine))
    half = side * fine // 2
    sums = np.pad(np.nan_to_num(inverse, nan=1e6).cumsum(0).cumsum(1), ((1, 0), (1, 0)))
    middle = (np.arange(96) * fine + fine // 2)[:, None]
    low, high = np.clip(middle - half, 0, 96 * fine), np.clip(middle - half + side * fine, 0, 96 * fine)
    total = sums[high, high.T] - sums[low, high.T] - sums[high, low.T] + sums[low, low.T]
    mean = total / ((high - low) * (high - low).T)
    return np.where(mean < 1e3, 1 / mean, np.nan)


@pytest.mark.parametrize("side", [1, 3, 5])
def test_what_a_window_flattens_is_what_the_model_says(side):
    true = ball(camera())
    said = flattening(true, side, STEEP).measured
    lost = true - windowed(side)  # negative: a window reads what bulges towards it too far
    inner = (said != 0) & np.isfinite(lost) & (true < FAR - 0.5 * RADIUS)
    assert inner.sum() > 300
    # by the formula: side^2 / 24 times both curvatures, at the middle
    pixel = (FAR - RADIUS) / 200.0
    assert lost[47, 47] == pytest.approx(-((side * pixel) ** 2) / 12 / RADIUS, rel=0.15)
    # pixels see the ball along slanted rays: half of it is steeper than 60 degrees to its windows' rims
    assert np.median(said[inner] / lost[inner]) == pytest.approx(1, abs=0.05)


def test_planes_and_edges_are_left_alone():
    plane = 1 / (1.2 + 0.1 * camera().rays()[..., 0].astype(float))
    assert np.abs(flattening(plane, 5, STEEP).fused[3:-3, 3:-3]).max() < 1e-7
    step = np.where(np.arange(96) < 40, 0.8, 1.0) * np.ones((96, 1))
    assert np.abs(flattening(step, 5, STEEP).measured).max() < 1e-9
    assert not flattening(np.full((96, 96), np.nan), 5, STEEP).measured.any()


@pytest.mark.parametrize("side", [1.0, 2.0, 3.3, 5.0, 7.0])
def test_the_weights_are_as_wide_as_the_square(side):
    weights = box(side)
    at = np.arange(len(weights)) - len(weights) // 2
    assert weights.sum() == pytest.approx(1)
    assert np.sum(weights * at**2) == pytest.approx(side**2 / 12, rel=1e-9)
    assert (weights > 0).all()


def ring(depth: np.ndarray, count: int = 18) -> tuple[list, np.ndarray]:
    """The same picture of a ball from all around, and its poses about the middle of the ball."""
    sensor = default_sensor(camera())
    frames = [prepare(Frame(0, 0.0, depth.astype(np.float32)), camera(), sensor) for _ in range(count)]
    away = np.eye(4)
    away[2, 3] = -FAR
    turns = [pose.about_axis(np.zeros(3), np.array([0, 1.0, 0]), a) for a in np.linspace(0, 2 * np.pi, count, False)]
    return frames, np.array([T @ away for T in turns])


def size(frames: list, poses: np.ndarray, settings: VolumeSettings) -> float:
    """Median radius [m] of the belt of what is fused."""
    volume = Volume(settings)
    for frame, T in zip(frames, poses, strict=True):
        fuse(volume, frame, T)
    points = volume.surface().vertices
    return float(np.median(np.linalg.norm(points[np.abs(points[:, 1]) < 0.04], axis=1)))


@pytest.mark.parametrize(("side", "least"), [(1, 0.6), (5, 0.7)])
def test_a_ball_seen_through_windows_has_its_size_again(side, least):
    settings = VolumeSettings(voxel=0.002, truncation=0.008)
    frames, poses = ring(windowed(side))
    before = size(frames, poses, settings) - RADIUS
    after = size(unflattened(frames, poses, settings, float(side)), poses, settings) - RADIUS
    assert before < -5e-5  # 0.1 and 0.5 mm: 0.1 to 0.7 % of its size
    assert abs(after) < (1 - least) * abs(before)


def test_frames_without_a_place_stay_as_they_are():
    frames, poses = ring(windowed(3), 4)
    poses[1] = np.nan
    found = unflattened([*frames[:3], None], poses, VolumeSettings(voxel=0.002, truncation=0.008), 3.0)
    assert found[1] is frames[1] and found[3] is None
    assert np.nanmax(np.abs(found[0].depth - frames[0].depth)) > 5e-5


def test_the_widest_window_is_the_sensors():
    from fusion.sensor.effects.triangulation.edge_fattening import EdgeFattening
    from fusion.sensor.sensor import Sensor

    big = Camera(640, 480, 570.0, 570.0, 319.5, 239.5)
    assert widest_window(Sensor("bare"), big) == 1.0
    assert widest_window(Sensor("one", effects=(EdgeFattening(window_px=5.0),)), big) in (1.0, 5.0)
