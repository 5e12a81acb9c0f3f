"""The frames of a scan: where the object is, every frame cut to it and rated, what the table was told."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from fusion.errors import RecordingError, TrackingError
from fusion.geometry.camera import Camera
from fusion.progress import each
from fusion.recording.images.masks import Masks
from fusion.recording.native.telemetry_file import PLAUSIBLE
from fusion.recording.recording import Recording
from fusion.scan.finding.colors import Colors
from fusion.scan.settings import ScanSettings
from fusion.sensor.moments import moments_of
from fusion.sensor.sensor import Sensor
from fusion.sensor.window import of_window
from fusion.turntable.motion import Motion
from fusion.turntable.turning.moving import EDGE, find_moving, find_wall
from fusion.turntable.turning.still_background import standing
from fusion.turntable.views import Region, crop
from fusion.volume.prepared import Prepared, prepare

Array = NDArray[np.float64]
LARGEST_ANGLE = PLAUSIBLE["turntable_deg"][1]  # a log of no file may still hold it
LOOKED_AT = 30  # frames that show what turns


def find_region(recording: Recording, sensor: Sensor, settings: ScanSettings, masks: Masks | None = None) -> Region:
    """Where the object is while it turns: the box that was given, what the masks show, or what moves.

    Raises:
        RecordingError: too few frames, or too few that can be read.
        TrackingError: nothing moves, or the masks hold no depth.
    """
    if len(recording) < 3:
        raise RecordingError("too few frames for a turntable", recording.path, len(recording), "3 or more")
    depths, colors, lost = [], [], ""
    shown = Colors.of(recording) if settings.color and masks is None else None
    everywhere = slice(None), slice(None)
    for index in each(np.unique(np.linspace(0, len(recording) - 1, LOOKED_AT).round().astype(int)), "reading"):
        try:
            frame = recording[int(index)]
            depth = frame.depth if masks is None else np.where(masks[int(index)], frame.depth, np.float32(np.nan))
            depths.append(depth)
            colors.append(None if shown is None else shown.seen_at(int(index), frame, everywhere))
        except RecordingError as error:  # told when all frames are loaded
            lost = lost or f"frame {index}: {error}"
            continue
    if len(depths) < 3:
        raise RecordingError("too few frames can be read", recording.path, len(depths), "3 or more", lost)
    camera = recording.camera
    if masks is not None and masks.moving:  # they follow the object: what they show is all that turns
        return _shown(np.stack(depths), camera, settings).grown(0.015)

    def sigma(z: NDArray[np.float32]) -> NDArray[np.float32]:
        return np.asarray(sensor.sigma(z, None, camera), np.float32)

    if settings.box is not None:
        low, high = np.sort(np.array(settings.box, float), axis=0)
        return Region(low, high, wall=find_wall(np.stack(depths), camera, sigma, (low, high), colors))
    moving = find_moving(np.stack(depths), camera, sigma, colors)
    return Region(moving.low, moving.high, moving.still, moving.wall).grown(0.015)


def _shown(depths: NDArray[np.float32], camera: Camera, settings: ScanSettings) -> Region:
    """The box around all points of depth images (k, h, w) in which only the object is left."""
    rays = camera.rays()
    points = []
    for depth in depths:
        # two pixels at a mask's border may show what is behind
        inside = ndimage.binary_erosion(np.isfinite(depth), np.ones((3, 3)), iterations=2)
        points.append(np.column_stack([rays[inside] * depth[inside][:, None], depth[inside]]))
    cloud = np.concatenate(points)
    if len(cloud) < 200:
        found = f"{len(cloud)} pixels in {len(depths)} frames"
        raise TrackingError("the masks hold no depth", settings.mask, found, "an object that the camera measures")
    low, high = np.percentile(cloud, [0.5, 99.5], axis=0)
    return Region(low, high)


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
    for index in each(range(len(recording)), "reading"):
        try:
            frame = recording[index]
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
        frames.append(prepared if mask is None else masked(prepared, mask))
    return frames, broken


def masked(frame: Prepared, mask: NDArray[np.bool_]) -> Prepared:
    """The frame with depth and normals within a mask (h, w) alone; its points, which say what is not there, stay."""
    normals = np.where(mask[..., None], frame.surface.normals, np.float32(np.nan))
    depth = np.where(mask, frame.depth, np.float32(np.nan))
    return replace(frame, depth=depth, surface=replace(frame.surface, normals=normals))


def object_alone(frames: list[Prepared | None], region: Region, motion: Motion) -> list[Prepared | None]:
    """The frames without what stands behind the object and does not turn with it: that is neither tracked nor fused.

    Args:
        frames: cut to the window of the region.
        region: its images cut to the same window.
        motion: of what turns.
    """
    shown = next((f for f in frames if f is not None), None)
    if shown is None or region.wall is None:
        return frames
    away = standing(region.wall, shown.surface.camera, motion.axis, motion.radius + EDGE)
    if not away.any():
        return frames
    wall = np.where(away, region.wall, np.float32(np.inf))
    return [None if f is None else masked(f, ~(f.surface.points[..., 2] >= wall)) for f in frames]


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
