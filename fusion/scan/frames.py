"""The frames of a scan: where the object is, every frame corrected and cut to it, what the table was told."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from fusion.errors import RecordingError
from fusion.reconstruct import Prepared, prepare
from fusion.recording.recording import Recording
from fusion.scan.settings import ScanSettings
from fusion.sensor.sensor import Sensor
from fusion.turntable.moving import find_moving
from fusion.turntable.views import Region, crop

Array = NDArray[np.float64]
LOOKED_AT = 30  # frames that show what turns


def find_region(recording: Recording, sensor: Sensor, settings: ScanSettings) -> Region:
    if settings.box is not None:
        low, high = np.sort(np.array(settings.box, float), axis=0)
        return Region(low, high)
    if len(recording) < 3:
        raise RecordingError("too few frames for a turntable", recording.path, len(recording), "3 or more")
    depths = []
    for index in np.unique(np.linspace(0, len(recording) - 1, LOOKED_AT).round().astype(int)):
        try:
            depths.append(recording[int(index)].depth)
        except RecordingError:  # told when all frames are loaded
            continue
    if len(depths) < 3:
        raise RecordingError("too few frames can be read", recording.path, len(depths), "3 or more")
    camera = recording.camera
    moving = find_moving(np.stack(depths), camera, lambda z: np.asarray(sensor.sigma(z, None, camera), np.float32))
    return Region(moving.low, moving.high, moving.still).grown(0.015)


def load(recording: Recording, sensor: Sensor, region: Region) -> tuple[list[Prepared | None], dict[int, str]]:
    """All frames, corrected and cut to the window that shows the object; unreadable ones with the reason."""
    camera = recording.camera
    window = region.window(camera)
    frames: list[Prepared | None] = []
    broken = {}
    for index in tqdm(range(len(recording)), desc="loading", unit="frame", disable=None):
        try:
            frame = recording[index]
        except RecordingError as error:
            frames.append(None)
            broken[index] = str(error)
            continue
        cut = replace(
            frame,
            depth=np.ascontiguousarray(frame.depth[window]),
            color=None if frame.color is None else np.ascontiguousarray(frame.color[window]),
            ir=None if frame.ir is None else np.ascontiguousarray(frame.ir[window]),
        )
        frames.append(prepare(cut, crop(camera, window), sensor))
    return frames, broken


def told_angles(recording: Recording, settings: ScanSettings) -> Array | None:
    """Table angles [rad] as told, or None."""
    if settings.step is not None:
        return np.asarray(np.arange(len(recording)) * settings.step, float)
    if not settings.use_log:
        return None
    logged = recording.telemetry_at_frames("turntable_deg")
    if logged is None or np.ptp(logged) < 1.0:
        return None
    return np.asarray(np.unwrap(np.deg2rad(logged)), float)
