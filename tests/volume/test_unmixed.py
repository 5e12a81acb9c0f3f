"""What windows and the volume do to what bulges is taken out, and only where the frames show it."""

from dataclasses import replace

import numpy as np
import pytest

from fusion.geometry.camera import Camera, Principle
from fusion.geometry.pose import about_axis
from fusion.recording.recording import Frame
from fusion.sensor.effects.triangulation.edge_fattening import EdgeFattening
from fusion.sensor.sensor import Sensor
from fusion.volume.prepared import Prepared, fused, prepare
from fusion.volume.unmixed import MatchingWindow, flattened, matching_window, unmixed
from fusion.volume.volume import VolumeSettings

CAMERA = Camera(120, 120, 280.0, 280.0, 59.5, 59.5, principle=Principle.STRUCTURED_LIGHT)
FAR, RADIUS, WIDE = 0.8, 0.05, 5.0
WINDOW = MatchingWindow(WIDE, 1 / (280 * 0.075))
SENSOR = Sensor(effects=(EdgeFattening(WIDE),), std={("edge_fattening", "window_px"): 0.5})


def ball() -> np.ndarray:
    """Exact depth of a ball."""
    stretch = np.sum(CAMERA.rays().astype(float) ** 2, axis=-1) + 1
    root = FAR**2 - stretch * (FAR**2 - RADIUS**2)
    return np.where(root > 0, (FAR - np.sqrt(np.maximum(root, 0))) / stretch, np.nan)


def averaged(depth: np.ndarray) -> np.ndarray:
    """The mean disparity of the window, as a camera gives it."""
    inverse = 1 / depth
    padded = np.pad(inverse, 2, constant_values=np.nan)
    seen = np.stack([padded[a : a + 120, b : b + 120] for a in range(5) for b in range(5)])
    near = np.abs(seen - inverse) < WINDOW.one_px
    total = np.where(near, seen, 0).sum(axis=0)
    return np.where(near.any(axis=0), near.sum(axis=0) / np.where(near.any(axis=0), total, 1), np.nan)


def scanned(depth: np.ndarray) -> tuple[list[Prepared], np.ndarray]:
    """Frames all round, which are the same of a ball, and their poses."""
    frame = prepare(Frame(0, 0.0, depth.astype(np.float32)), CAMERA, SENSOR)
    middle = np.array([0, 0, FAR])
    return [frame] * 12, np.array([about_axis(middle, [0, 1, 0], k * np.pi / 6) for k in range(12)])


def test_a_plane_has_no_bend_and_a_parabola_half_of_its_variance() -> None:
    v, u = np.mgrid[:30, :40].astype(float)
    apart = np.full(u.shape, 0.1)
    plane, inner = 1 + 0.001 * u - 0.002 * v, np.s_[3:-3, 3:-3]
    assert np.abs(flattened(plane, WIDE, apart)[inner]).max() < 1e-12
    bend = flattened(1 - 1e-5 * (u - 20) ** 2, WIDE, apart)[inner]
    assert bend == pytest.approx(-1e-5 * WINDOW.variance, rel=1e-9)
    step = np.where(u < 20, 1.0, 2.0)  # another surface takes no part
    assert np.abs(flattened(step, WIDE, apart)).max() < 1e-12


@pytest.mark.parametrize("averages", [True, False])
def test_a_ball_keeps_its_size(averages: bool) -> None:
    true = ball()
    frames, poses = scanned(averaged(true) if averages else true)
    settings = VolumeSettings(0.002, 0.012)
    off = []
    for _ in range(2):
        mesh = fused(settings, frames, poses).surface()
        size = np.linalg.norm(mesh.vertices - [0, 0, FAR], axis=1)[np.abs(mesh.vertices[:, 1]) < 0.6 * RADIUS]
        off.append(float(np.median(size)) - RADIUS)
        frames = unmixed(frames, fused(settings, frames, poses), poses, WINDOW)
    assert off[0] < (-2.5e-4 if averages else 0)
    assert abs(off[1]) < 1.2e-4


def test_a_guessed_window_is_asked_of_the_frames_too() -> None:
    assert matching_window(SENSOR, 280.0) == MatchingWindow(WIDE, pytest.approx(WINDOW.one_px))
    assert matching_window(replace(SENSOR, std={}), 280.0) == matching_window(SENSOR, 280.0)
    assert matching_window(Sensor(), 280.0).one_px is None
