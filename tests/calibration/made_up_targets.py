"""Poses of a target without images: what a measurement of a known noise would say, and images of a target."""

from dataclasses import replace

import numpy as np

from fusion.calibration.noise.poses import Pose
from fusion.calibration.noise.target_noise import TargetNoise
from fusion.geometry.camera import Camera
from fusion.sensor.effects.readout.axial_noise import AxialNoise
from fusion.sensor.view import View

TOF = Camera(512, 424, 365.0, 365.0, 255.5, 211.5, principle="itof", sensor="Kinect v2", serial="1")
SL = replace(TOF, fx=585.0, fy=585.0, principle="structured_light", sensor="K1")
DISTANCES = tuple(np.arange(0.7, 3.2, 0.3))  # [m] with tilts of 0 to 75 deg, Fankhauser's grid
TILTS = (0, 15, 30, 45, 60, 75)  # deg
ERROR = 0.01  # share: what 20 pixels of 100 frames make of a spread


def law_at(effect: AxialNoise, z: float, tilt: float) -> float:
    """The effect's noise [m] of a pixel on the axis; tilt [rad]."""
    camera = Camera(1, 1, 365.0, 365.0, 0.0, 0.0)
    depth = np.full((1, 1), z)
    return float(effect.noise(depth, View(camera, depth, np.full((1, 1), tilt)))[0, 0])


def pose_at(z: float, tilt_deg: float, sigma: float, **more) -> Pose:
    """A pose whose noise was measured as `sigma` [m]; more: fields of TargetNoise."""
    usual = {"lateral": (float("nan"),) * 2, "valid": 1.0, "no_data": 0.0, "outliers": 0.0}
    scores = np.random.default_rng(0).standard_normal(500).astype(np.float32)
    seen = TargetNoise(
        (212, 256), z, np.deg2rad(tilt_deg), 100, sigma, ERROR * sigma, z_scores=scores, **(usual | more)
    )
    return Pose(f"{z:.1f} m {tilt_deg:.0f} deg", seen, z, np.deg2rad(tilt_deg), sigma, ERROR * sigma)


def grid(effect: AxialNoise, rng: np.random.Generator, distances=DISTANCES, tilts=TILTS) -> list[Pose]:
    """Poses of a grid with measurement errors."""
    return [
        pose_at(float(z), float(t), law_at(effect, z, np.deg2rad(t)) * (1 + ERROR * rng.standard_normal()))
        for z in distances
        for t in tilts
    ]


def target_image(camera: Camera, z: float, tilt_deg: float, jitter: np.ndarray) -> np.ndarray:
    """(h, w) depth [m] of a target turned about the vertical, 0.5 m wide, a wall 1 m behind; jitter (h, 1) px."""
    t = np.deg2rad(tilt_deg)
    n = np.array([np.sin(t), 0.0, -np.cos(t)])
    plane = n[2] * z / (np.dstack([camera.rays(), np.ones(camera.shape)]) @ n)
    v, u = np.mgrid[0 : camera.height, 0 : camera.width]
    lean = 0.05 * (v - camera.cy)
    half = np.array([-0.25, 0.25]) * np.cos(t)
    left, right = camera.cx + camera.fx * half / (z + np.tan(t) * half)
    on = (u > left + lean + jitter) & (u < right + lean + jitter) & (np.abs(v - camera.cy) < 0.4 * camera.height)
    return np.where(on, plane, z + 1.0)
