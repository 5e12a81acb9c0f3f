"""One recording of a wall, reduced frame by frame to means: depth, noise, light, distance."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from fusion.calibration.depth.walls.plane import LEAST_SHARE, WallPlane, find_wall
from fusion.calibration.series import PixelSeries
from fusion.calibration.shared_noise import SharedNoise, centre_of, middle_mean, shared_noise
from fusion.calibration.stretches import Stretch, still_stretches
from fusion.errors import FusionError, RecordingError
from fusion.geometry.camera import Camera
from fusion.progress import each
from fusion.recording.looking.moved import unmoved_parts
from fusion.recording.readable import readable
from fusion.recording.recording import Recording
from fusion.sensor.moment import Moment
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import View, incidence_of

FAR_OFF = 0.15  # share: a wall that is this far from the stated distance is another wall
ASIDE = 0.4  # share by which a tilted wall's depth leaves that distance at the border: 40 degrees at 25 from the axis
PASSES = 0.02  # of the depth: a centre that is off by more in a frame is somebody who walks by
LEAST_STD = 1e-6  # [m] no wall's distance is known better, and weights stay finite


@dataclass(frozen=True)
class Wall:
    """What the frames of one recording say about a wall."""

    name: str  # of the recording's folder
    frames: int  # number of frames
    measured: NDArray[np.floating]  # (h, w) mean depth as recorded [m], NaN where half of the frames or more have none
    depth: NDArray[np.floating]  # (h, w) the same after what is known of the sensor is undone [m]
    std: NDArray[np.floating]  # (h, w) standard deviation of one frame [m]
    mask: NDArray[np.bool_]  # (h, w) pixels of the wall
    plane: WallPlane  # through the wall
    distance: float  # depth at `centre`, as it was measured otherwise [m]; NaN when it was not
    distance_std: float  # of that distance [m]
    ir: NDArray[np.floating] | None = None  # (h, w) mean amplitude [count], or None
    moment: Moment = field(default_factory=Moment)  # when it was recorded
    # x / z and y / z of the ray along which the distance was measured; the optical axis by default
    centre: tuple[float, float] = (0.0, 0.0)
    # (h, w) number of the board's square that a pixel sees, -1 elsewhere; None for a wall
    squares: NDArray[np.intp] | None = None
    # standard deviation of the plane's tilts [1] where a board told them, else inf: the wall tells them
    tilt_std: float = float("inf")
    # (h, w) change of the range [m] per unit of light that a board mirrors, or None; see `gloss.py`
    gloss: NDArray[np.floating] | None = None
    unread: dict[int, str] = field(default_factory=dict)  # index of each frame that could not be read: why
    shared: SharedNoise | None = None  # what the centre's pixels share from frame to frame; None of a single picture
    placed: WallPlane | None = None  # where it stands by a law, if its distance was not measured; see `placed.py`

    @property
    def true_plane(self) -> WallPlane:
        """The fitted tilt at the stated distance, or where none is stated the plane by a law, or the fitted one."""
        if not np.isfinite(self.distance):
            return self.placed or self.plane
        return replace(self.plane, distance=self.distance * self.plane.inverse_at(*self.centre))

    @property
    def depth_there(self) -> float:
        """Its depth [m] at `centre`: the stated one, or that of the fitted plane."""
        if np.isfinite(self.distance):
            return self.distance
        return float(self.plane.distance / self.plane.inverse_at(*self.centre))

    @property
    def moved(self) -> bool:
        """True when it swayed or crept while it was recorded, by more than its distance is known."""
        return self.shared is not None and self.shared.moves(self.distance_std)

    @property
    def by_board(self) -> bool:
        """True when a board in the picture told where it stands."""
        return self.squares is not None or any(self.centre)

    def view(self, camera: Camera, depth: NDArray[np.floating]) -> View:
        """What the pixels look at when the wall is at `depth` (h, w) [m]."""
        plane = self.plane
        normal = -np.array([plane.a, plane.b, 1.0]) / np.sqrt(plane.a**2 + plane.b**2 + 1)
        normals = np.broadcast_to(normal.astype(np.float32), (*camera.shape, 3))
        ir = None if self.ir is None else np.nan_to_num(self.ir)
        return View(camera, depth, incidence_of(normals, camera), normals, ir=ir, moment=self.moment)


@dataclass(frozen=True)
class Means:
    """Means over the frames of a recording; see `Wall`."""

    frames: int
    measured: NDArray[np.floating]
    std: NDArray[np.floating]
    ir: NDArray[np.floating] | None
    unread: dict[int, str] = field(default_factory=dict)
    shared: SharedNoise | None = None


def frame_means(recording: Recording, frames: range) -> Means:
    """Per-pixel means of some frames, one in memory at a time. RecordingError when none can be read."""
    depth, ir = PixelSeries(recording.camera.shape), PixelSeries(recording.camera.shape)
    unread: dict[int, str] = {}
    centre, rows = centre_of(recording.camera.shape), list[tuple[float, float]]()
    first: NDArray[np.floating] | None = None
    for frame in readable(recording, each(frames, recording.path.name), unread):
        depth.add(frame.depth)
        first = frame.depth[centre] if first is None else np.where(np.isfinite(first), first, frame.depth[centre])
        rows.append((frame.timestamp, middle_mean(frame.depth[centre] - first)))
        if frame.ir is not None:
            ir.add(frame.ir.astype(float))
    if not depth.frames:
        if unread:
            recording[min(unread)]  # raises what is wrong with it
        raise RecordingError("the recording has no frames", recording.path, 0, "100 frames of a wall")
    measured = np.where(depth.valid > 0.5, depth.mean, np.nan)
    std = depth.std
    one = float(np.nanmedian(std[centre])) if np.isfinite(std[centre]).any() else float("nan")
    time, means = np.array(rows).T
    if np.isfinite(means).any() and np.isfinite(measured).any():
        means[np.abs(means - np.nanmedian(means)) > PASSES * np.nanmedian(measured)] = np.nan
    shared = shared_noise(time, means, one)
    return Means(depth.frames, measured, std, ir.mean if ir.frames else None, unread, shared)


def check_distances(recordings: Sequence[Recording]) -> None:
    """Refuse recordings that state distances of which not one is possible. Raises FusionError."""
    columns = [c for r in recordings if (c := r.telemetry_at_frames("distance_m")) is not None]
    wrong = [text for r in recordings for text in r.warnings if "values of distance_m" in text]
    if wrong and not any(np.isfinite(column).any() for column in columns):
        what = "no stated distance can be used"
        raise FusionError(what, found=wrong[0], expected="metres", do="correct distance_m, or take the column away")


def read_walls(recording: Recording, camera: Camera, known: Sensor, distance_std: float) -> list[Wall]:
    """Reduce a recording of a wall, or of one wall after the other where the log, the poses or the images say so.

    Args:
        recording: its telemetry's `distance_m`, where there is one, is the distance along the optical axis.
        camera: the calibrated camera.
        known: effects that are undone before anything is fitted.
        distance_std: of `distance_m` [m].
    Raises:
        FusionError: no frames, nothing stands still, no plane, or a plane far from the stated distance.
    """
    column, walls = recording.telemetry_at_frames("distance_m"), []
    if column is None or not np.isfinite(column).any():  # nobody wrote down when the camera was moved
        parts = still_stretches(recording)
    else:
        moved = unmoved_parts(recording)
        parts = [Stretch(recording, (part.start, part.stop), len(moved) == 1) for part in moved]
    for part in parts:
        means, frames = frame_means(recording, range(*part.frames)), slice(*part.frames)
        distance = part.telemetry("distance_m")
        walls.append(wall_of(means, camera, known, (part.name, distance, distance_std), _moment(recording, frames)))
    return walls


def wall_of(
    means: Means,
    camera: Camera,
    known: Sensor,
    stated: tuple[str, float, float],
    moment: Moment | None = None,
    centre: tuple[float, float] = (0.0, 0.0),
) -> Wall:
    """The wall in means of frames; `stated`: name, depth at `centre` [m] (NaN when not known), standard deviation."""
    name, distance, distance_std = stated
    distance_std = max(distance_std, LEAST_STD)
    if np.isfinite(distance) and not distance > 0:
        raise FusionError("the stated distance is not usable", name, f"{distance:g} m", "a distance above 0")
    moment = moment or Moment()
    ir = None if means.ir is None else np.nan_to_num(means.ir)
    depth = known.correct(means.measured, View(camera, means.measured, ir=ir, moment=moment))
    try:
        plane, mask = find_wall(depth, camera)
        if _far_off(plane, distance, centre):  # what most of the image shows is not what was measured
            with np.errstate(invalid="ignore"):
                near = np.where(np.abs(depth / distance - 1) < ASIDE, depth, np.nan)
            if np.isfinite(near).sum() > LEAST_SHARE * np.isfinite(depth).sum():
                plane, mask = find_wall(near, camera)
    except FusionError as error:
        raise FusionError(error.what, name, error.found, error.expected, error.do) from error
    if _far_off(plane, distance, centre):
        seen = plane.distance / plane.inverse_at(*centre)
        raise FusionError(
            "the wall is not where the log says",
            name,
            f"{seen:.3f} m",
            f"{distance:.3f} m (distance_m, or the pose of the board)",
            "check the log, the depth unit and what fills the view",
        )
    return Wall(
        name,
        means.frames,
        means.measured,
        depth,
        means.std,
        mask,
        plane,
        distance,
        distance_std,
        means.ir,
        moment,
        centre,
        unread=means.unread,
        shared=means.shared,
    )


def _far_off(plane: WallPlane, distance: float, centre: tuple[float, float]) -> bool:
    """True of a plane that is not the wall at a stated distance [m]; False where none is stated."""
    return bool(np.isfinite(distance) and abs(plane.distance / plane.inverse_at(*centre) / distance - 1) > FAR_OFF)


def _moment(recording: Recording, frames: slice) -> Moment:
    temperature = recording.telemetry_at_frames("temperature_c")
    return Moment(
        time=float(np.mean(recording.timestamps[frames])),
        temperature=float("nan") if temperature is None else float(np.mean(temperature[frames])),
    )
