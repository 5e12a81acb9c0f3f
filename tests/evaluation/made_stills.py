"""Still recordings made up for tests: a wall with noise, in memory or as a folder."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from fusion.geometry.camera import Camera
from fusion.recording.open import open_recording
from fusion.recording.recording import Frame, Recording
from fusion.recording.writing.write import write_recording

CAMERA = Camera(96, 72, 90.0, 90.0, 47.5, 35.5, depth_scale=10000, principle="itof", sensor="made up", serial="7")
NOISE = 0.002  # [m]


def wall(distance: float = 1.2, slope: float = 0.1) -> np.ndarray:
    """(h, w) depth of a plane that meets the optical axis at this distance [m]."""
    rays = CAMERA.rays().astype(float)
    return distance / (1 + slope * rays[..., 0])


def frames(
    count: int,
    distance: float = 1.2,
    change: Callable[[int, np.ndarray], np.ndarray] | None = None,
    seed: int = 0,
    interval: float = 1 / 30,
) -> list[Frame]:
    """Frames of a wall with noise; `change` may alter each depth image."""
    rng = np.random.default_rng(seed)
    out = []
    for i in range(count):
        depth = (wall(distance) + NOISE * rng.standard_normal(CAMERA.shape)).astype(np.float32)
        ir = (3000 / distance**2 + 10 * rng.standard_normal(CAMERA.shape)).clip(1).astype(np.uint16)
        color = np.dstack([np.full(CAMERA.shape, 50 * c, np.uint8) + rng.integers(0, 9, CAMERA.shape, np.uint8)
                           for c in (1, 2, 3)])  # fmt: skip
        out.append(Frame(i, i * interval, depth if change is None else change(i, depth), color, ir))
    return out


def recording(made: list[Frame], **more) -> Recording:
    """A recording that holds its frames in memory."""
    stamps = np.array([frame.timestamp for frame in made])
    return Recording(
        Path(more.pop("name", "wall")), "native", more.pop("camera", CAMERA), stamps, made.__getitem__, **more
    )


def folder(path: Path, made: list[Frame], distance: float | None = None, camera: Camera = CAMERA) -> Recording:
    """A recording on disk."""
    telemetry = None if distance is None else {"timestamp": [0.0, 1.0], "distance_m": [distance, distance]}
    write_recording(path, camera, made, telemetry=telemetry)
    return open_recording(path)


def stated(distance: float) -> dict[str, np.ndarray]:
    """Telemetry of a known distance [m]."""
    return {"timestamp": np.array([0.0, 1e4]), "distance_m": np.array([distance, distance])}
