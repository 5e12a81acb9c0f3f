"""The frames of a scan: where the object is, every frame cut to it and rated, what the table was told."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fusion.errors import RecordingError
from fusion.geometry.camera import crop
from fusion.progress import each
from fusion.recording.ahead import ahead
from fusion.recording.images.masks import Masks
from fusion.recording.native.telemetry_file import PLAUSIBLE
from fusion.recording.recording import Recording
from fusion.scan.finding.colors import Colors
from fusion.scan.settings import ScanSettings
from fusion.sensor.moments import moments_of
from fusion.sensor.sensor import Sensor
from fusion.sensor.window import of_window
from fusion.turntable.views import Region
from fusion.volume.prepared import Prepared, prepare

Array = NDArray[np.float64]
LARGEST_ANGLE = PLAUSIBLE["turntable_deg"][1]  # a log of no file may still hold it


def load(
    recording: Recording, sensor: Sensor, region: Region, masks: Masks | None = None, color: bool = False
) -> tuple[list[Prepared | None], dict[int, str]]:
    """All frames, cut to the window that shows the object and rated; unreadable ones with the reason.

    Args:
        recording: with corrected depth, and the camera that belongs to it.
        sensor: rates the pixels.
        region: where the object is.
        masks: of the object, or None.
        color: keep what the colour images show in the depth camera's pixels, for tracking.

    Outside a mask a frame keeps its points, which say where the object is not, but no normals and no depth to fuse.
    """
    camera = recording.camera
    window = region.window(camera)
    moments, sensor = moments_of(recording), of_window(sensor, camera.shape, window)
    shown = Colors.of(recording) if color else None
    frames: list[Prepared | None] = []
    broken = {}
    for index, read in enumerate(each(ahead(recording.__getitem__, range(len(recording))), "reading", len(recording))):
        try:
            frame = read()
            mask = None if masks is None else masks[index][window]
        except RecordingError as error:
            frames.append(None)
            broken[index] = str(error)
            continue
        cut = replace(
            frame,
            depth=np.ascontiguousarray(frame.depth[window]),
            color=None,  # the finished mesh is coloured from the recording
            ir=None if frame.ir is None else np.ascontiguousarray(frame.ir[window]),
            noisier=None if frame.noisier is None else np.ascontiguousarray(frame.noisier[window]),
        )
        prepared = prepare(cut, crop(camera, window), sensor, moments[index])
        if shown is not None:
            prepared = replace(prepared, color=shown.seen_at(index, frame, window))
        frames.append(prepared if mask is None else prepared.masked(mask))
    return frames, broken


def seen_again(
    frames: list[Prepared | None], recording: Recording, sensor: Sensor, window: tuple[slice, slice]
) -> list[Prepared | None]:
    """Frames that `load` cut to a window, as the recording's camera sees them now: their images are not read anew.

    Their colour stays, as it is where the colour camera is the depth camera.
    """
    camera, moments = recording.camera, moments_of(recording)
    sensor = of_window(sensor, camera.shape, window)
    return [
        None if f is None else replace(prepare(f.frame, crop(camera, window), sensor, moments[k]), color=f.color)
        for k, f in enumerate(frames)
    ]


def told_angles(recording: Recording, settings: ScanSettings) -> Array | None:
    """Table angles [rad] as told, or None."""
    if settings.step is not None:
        return np.asarray(np.arange(len(recording)) * settings.step, float)
    if not settings.use_log:
        return None
    logged = recording.telemetry_at_frames("turntable_deg")
    if logged is None or np.ptp(logged) < 1.0:
        return None
    absurd = logged[np.abs(logged) > LARGEST_ANGLE]
    if len(absurd):
        do = "mend the log, pass --step, or --ignore-log to do without"
        found, expected = f"turntable_deg {absurd[0]:g}", f"degrees, up to {LARGEST_ANGLE:g}"
        where = recording.path / "telemetry.csv"
        raise RecordingError("the table's log is not possible", where, found, expected, do)
    return np.asarray(np.unwrap(np.deg2rad(logged)), float)
