"""Colour of another camera beside depth is seen and left out; registered colour, and what cannot be told, stays."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from fusion.geometry.camera import Camera
from fusion.recording.checks.color_over_depth import check_color_over_depth, is_elsewhere
from fusion.recording.looking.doctor import fit_to_scan, quick_look
from fusion.recording.looking.sample import draw
from fusion.recording.open import open_recording
from fusion.recording.recording import Frame, Recording

CAMERA = Camera(320, 240, 260.0, 260.0, 159.5, 119.5)
COUNT = 8


def discs(seed):
    """(n, 4) x, y, z and radius [m] of round cards before a wall, far ones first, and their colours (n, 3)."""
    random = np.random.default_rng(seed)
    z = np.sort(random.uniform(0.6, 1.6, 14))[::-1]
    x, y = random.uniform(-0.55, 0.55, 14) * z, random.uniform(-0.4, 0.4, 14) * z
    return np.column_stack([x, y, z, random.uniform(0.04, 0.12, 14)]), random.integers(0, 255, (14, 3))


def seen(camera, seed, baseline=0.0):
    """Depth (h, w) [m] and colour (h, w, 3) of the cards, by a camera that stands `baseline` [m] to the right."""
    random = np.random.default_rng(seed + 100)
    v, u = np.mgrid[: camera.height, : camera.width]
    depth = np.full(camera.shape, 2.0)
    color = np.full((*camera.shape, 3), 120.0)
    for (x, y, z, radius), paint in zip(*discs(seed), strict=True):
        on_it = np.hypot(u - camera.cx - camera.fx * (x - baseline) / z, v - camera.cy - camera.fy * y / z)
        depth[on_it < camera.fx * radius / z] = z
        color[on_it < camera.fx * radius / z] = paint
    depth += random.normal(0, 0.001, depth.shape) * depth**2
    return depth.astype(np.float32), np.clip(color + random.normal(0, 4, color.shape), 0, 255).astype(np.uint8)


def recorded(path, color_camera=CAMERA, baseline=0.0, still=False):
    """A recording whose colour is that of another camera, as if it were that of depth."""

    def load(i):
        seed = 0 if still else i
        return Frame(i, i / 10, seen(CAMERA, seed)[0], seen(color_camera, seed, baseline)[1])

    return Recording(path, "native", CAMERA, np.arange(COUNT) / 10, load)


def told(recording):
    return check_color_over_depth(draw(recording, COUNT, COUNT))


@pytest.mark.parametrize("still", [False, True])
def test_registered_color_stays(tmp_path, still):
    lies = recorded(tmp_path, still=still)
    (finding,) = told(lies)
    assert finding.severity == "ok" and "lies over" in finding.seen
    assert fit_to_scan(lies, quick_look(lies)) is lies


@pytest.mark.parametrize(("focal", "baseline"), [(1.0, 0.08), (1.6, 0.03), (0.88, 0.025)])
def test_color_of_another_camera_is_left_out(tmp_path, focal, baseline):
    beside = Camera(320, 240, 260.0 * focal, 260.0 * focal, 163.0, 118.0)
    recording = recorded(tmp_path, beside, baseline)
    findings = quick_look(recording)
    (finding,) = [f for f in findings if f.check == "color"]
    assert finding.severity == "warning" and "registered" in finding.do
    enlarged = float(finding.seen.split("enlarged by ")[1].split()[0])
    assert abs(np.log(enlarged * focal)) < 0.08
    assert fit_to_scan(recording, findings)[0].color is None
    assert fit_to_scan(recording, findings, force=True) is recording


@pytest.mark.parametrize("color", ["other", "none", "flat"])
def test_what_tells_nothing_is_no_alarm(tmp_path, color):
    def load(i):
        depth, shown = seen(CAMERA, i)
        other = {"other": seen(CAMERA, i + 50)[1], "none": None, "flat": np.full_like(shown, 90)}
        return Frame(i, i / 10, depth, other[color])

    recording = Recording(tmp_path, "native", CAMERA, np.arange(COUNT) / 10, load)
    assert not is_elsewhere(told(recording))
    assert told(recording) == [] if color == "none" else told(recording)[0].severity == "ok"


@pytest.mark.real
@pytest.mark.parametrize("name", ["kleenex_turntable", "custard_box", "robot_arm_boxes", "ycbv_0000"])
def test_real_colors(shared, name):
    real = open_recording(shared / "data" / name)
    assert told(real)[0].seen.startswith("colour lies over depth")

    def moved(index):
        frame = real[index]
        aside = (real.camera.width // 160, real.camera.width // 25)
        return frame if frame.color is None else replace(frame, color=np.roll(frame.color, aside, axis=(0, 1)))

    # ten frames of small things before a wall do not tell
    assert is_elsewhere(told(replace(real, load=moved))) == (name != "ycbv_0000")


def test_a_fit_at_the_rim_of_what_is_asked_is_none(tmp_path):
    """A camera that stands still shows one line of depth in all frames; a line of print farther below is in all too."""

    def load(i):
        random = np.random.default_rng(i)
        depth = np.full(CAMERA.shape, 1.0, np.float32)
        depth[: CAMERA.height // 2] = 2.0  # a table's far end
        shown = np.full((*CAMERA.shape, 3), 120.0)
        shown[CAMERA.height // 2 + 14 : CAMERA.height // 2 + 17] = 20  # 4 % of the width are asked: 13 px
        noisy = np.clip(shown + random.normal(0, 4, shown.shape), 0, 255).astype(np.uint8)
        return Frame(i, i / 10, depth, noisy)

    recording = Recording(tmp_path, "native", CAMERA, np.arange(COUNT) / 10, load)
    (finding,) = told(recording)
    assert finding.severity == "ok" and "do not tell" in finding.seen


@pytest.mark.parametrize("seed", [0, 3, 6])
def test_a_straight_rim_tells_nothing_along_itself(tmp_path, seed):
    """All that ends in depth is a table's far end: colour fits as well elsewhere along it, and lies where it is."""
    print_ = cv2.GaussianBlur(np.random.default_rng(seed).normal(0, 1, CAMERA.shape), (0, 0), 3)
    far = np.mgrid[: CAMERA.height, : CAMERA.width][0] < CAMERA.height // 2 - 30

    def load(i):
        shown = 120 + np.where(far, 12, -12) + 25 * np.sign(print_) + np.random.default_rng(i).normal(0, 4, far.shape)
        color = np.repeat(np.clip(shown, 0, 255).astype(np.uint8)[..., None], 3, axis=-1)
        return Frame(i, i / 10, np.where(far, np.float32(2.4), np.float32(1.0)), color)

    recording = Recording(tmp_path, "native", CAMERA, np.arange(COUNT) / 10, load)
    assert not is_elsewhere(told(recording))
