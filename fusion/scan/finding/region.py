"""Where the object is while it turns."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from fusion.errors import RecordingError, TrackingError
from fusion.geometry.camera import Camera
from fusion.progress import each
from fusion.recording.ahead import ahead
from fusion.recording.images.masks import Masks
from fusion.recording.recording import Recording
from fusion.scan.finding.colors import Colors
from fusion.scan.settings import ScanSettings
from fusion.sensor.sensor import Sensor
from fusion.turntable.below.ground import ground_below
from fusion.turntable.below.marks import marked
from fusion.turntable.below.told import told_below
from fusion.turntable.table.foot import foot_of
from fusion.turntable.turning.moving import Moving, find_moving, find_wall
from fusion.turntable.views import Region

Array = NDArray[np.float64]
LOOKED_AT = 30  # frames that show what turns
SOME = 4  # of these that show what the object stands on


def find_region(
    recording: Recording, sensor: Sensor, settings: ScanSettings, masks: Masks | None = None, look_below: bool = False
) -> Region:
    """Where the object is while it turns: the box that was given, what the masks show, or what moves.

    Args:
        recording: with corrected depth, and the camera that belongs to it.
        sensor: says how noisy it is.
        settings: of the scan.
        masks: of the object, or None.
        look_below: for marks on what the object stands on, which tell how that turns.

    Raises:
        RecordingError: too few frames, or too few that can be read.
        TrackingError: nothing moves, or the masks hold no depth.
    """
    if len(recording) < 3:
        raise RecordingError("too few frames for a turntable", recording.path, len(recording), "3 or more")
    frames, depths, colors, lost = [], [], [], ""
    shown = Colors.of(recording) if settings.color and masks is None else None
    everywhere = slice(None), slice(None)
    some = np.unique(np.linspace(0, len(recording) - 1, LOOKED_AT).round().astype(int)).tolist()
    for index, read in zip(some, each(ahead(recording.__getitem__, some), "reading", len(some)), strict=True):
        try:
            frame = read()
            depth = frame.depth if masks is None else np.where(masks[index], frame.depth, np.float32(np.nan))
            depths.append(depth)
            colors.append(None if shown is None else shown.seen_at(index, frame, everywhere))
            frames.append(index)
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

    pictures = None if shown is None else colors
    if settings.box is not None:
        low, high = np.sort(np.array(settings.box, float), axis=0)
        return Region(low, high, wall=find_wall(np.stack(depths), camera, sigma, (low, high), pictures))
    moving = find_moving(np.stack(depths), camera, sigma, pictures)
    region = Region(moving.low, moving.high, moving.still, moving.wall).grown(0.015)
    seen = [k for k, color in enumerate(colors) if color is not None]
    foot = _foot(moving, camera, depths) if look_below and len(seen) >= 3 else None
    if foot is None:
        return region
    both = np.stack([depths[k] for k in seen]), np.stack([color for color in colors if color is not None])
    below = marked(ground_below(foot, moving.points, camera), camera, [frames[k] for k in seen], *both)
    # marks that tell nothing would be looked for again with every camera that is tried
    tell = below is not None and told_below(below, list(below.marks.values())) is not None
    return replace(region, below=below) if tell else region


def _foot(moving: Moving, camera: Camera, depths: list[NDArray[np.float32]]) -> tuple[Array, Array] | None:
    """A point (3,) and the upward normal (3,) of what the object stands on; None where that is not seen."""
    with np.errstate(invalid="ignore"):
        behind = [camera.points(depth)[depth >= moving.wall] for depth in depths[:: max(1, len(depths) // SOME)]]
    return foot_of(np.concatenate(behind).astype(float), moving.points)


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
