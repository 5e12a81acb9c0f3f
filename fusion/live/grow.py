"""The model of a live scan: each frame is placed against it, then fused into it."""

from collections import deque
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from fusion.devices.source import SourceFrame
from fusion.errors import FusionError
from fusion.geometry.camera import Camera, crop
from fusion.geometry.depth import PointMap
from fusion.geometry.pose import Array
from fusion.live.looking import SURE, Looking, every
from fusion.live.state import SECTORS, ShownSurface
from fusion.sensor.presets import default_sensor
from fusion.sensor.window import of_window
from fusion.tracking.icp import IcpSettings
from fusion.tracking.tracker import Tracked, Tracker, TrackerSettings
from fusion.turntable.views import Region, usable
from fusion.volume.forecast import choose_truncation, choose_voxel
from fusion.volume.prepared import NOISIEST, Prepared, fuse, prepare
from fusion.volume.volume import Volume, VolumeSettings

COARSER = 1.5  # voxels of the view beside those of the result: it is looked at, not kept (guess)
# [px] of the window where what turns is seen, from which on every second pixel each way places a frame that is not
# fused: some 7000 are left (guess; 160 x 160 px are 25 cm at a metre). Fused so, a turn came out 1.5 % short (measured)
PLENTY = 160 * 160
KEPT, EVERY = 8, 15  # copies of the model to go back to, and frames between them
SHOWN = 30_000  # points handed to a view
# frames lost in a row after which a model of so few frames is given up (guesses: a third of a second, and one)
PATIENCE, BARELY = 10, 30
FUSED = 3  # of so many frames one is fused while the view is late; all are placed (guess)
# of the same table's next frame: what is not found from here is looked for further off, see `Tracker`
NEARBY = IcpSettings(points=(1000, 4000), reaches=(0.10, 0.02), iterations=(8, 5))
WEAK = 0.8  # of the usual share of points that fit, below which tracking is weak (guess)
TELLING = np.deg2rad(3.0)  # a turn from which on its direction tells the axis (guess: ten times what noise turns)


@dataclass(frozen=True)
class Placed:
    """A frame in the model."""

    tracked: Tracked  # where, or why not
    weak: bool  # fewer points fit than usual, or they leave a motion open
    distance: float  # median depth of the object [m]


class Grower:
    """Takes frames, oldest first; one thread at a time."""

    def __init__(self, camera: Camera) -> None:
        self.camera, self.sensor = camera, default_sensor(camera)
        self.looking, self.turned = Looking(camera, self.sensor), Turned()
        self.volume: Volume | None = None
        self.tracker = self._new_tracker()
        self.count = 0
        self._unfused = 0  # frames placed but not fused since the last that was
        self._seen_by = camera
        self._shares: deque[float] = deque(maxlen=100)
        self._copies: deque[tuple[int, Volume, float]] = deque(maxlen=KEPT)

    @property
    def found(self) -> bool:
        """What turns is known."""
        return self.looking.region is not None

    def take(self, frame: SourceFrame, late: bool = False) -> Placed:
        """Place and fuse a frame of which the region is known; where the view is late, not each is fused."""
        sure = self.looking.finds >= SURE  # asked first: a look may end meanwhile, but this frame has the region before
        fused = not (late and self.count and self._unfused < FUSED - 1)
        prepared = self._prepared(frame, fused)
        distance = float(np.nanmedian(prepared.depth)) if np.isfinite(prepared.depth).any() else np.nan
        if self.volume is None and np.isfinite(distance):
            voxel = COARSER * choose_voxel(distance, self.camera)
            sigma = float(np.nanmedian(prepared.surface.sigma))
            self.volume = Volume(VolumeSettings(voxel, choose_truncation(voxel, sigma)))
        camera = prepared.surface.camera
        self._seen_by = camera.halved() if fused and self.camera.width > 400 else camera
        if not self.count and not sure:
            return Placed(self.tracker.skip("too little of what turns is known yet"), False, distance)
        tracked = self.tracker.place(prepared.surface, same=self._unfused > 0)
        if tracked.ok and self.volume is not None:
            self._grown(prepared, tracked, fused, late)
        if not tracked.ok and self.tracker.lost > PATIENCE and self.count < BARELY:
            self._begin_anew()
        usual = float(np.median(self._shares)) if self._shares else 1.0
        weak = bool(tracked.unconstrained) or tracked.inlier_share < WEAK * usual
        return Placed(tracked, weak, distance)

    def undo(self, frames: int) -> float | None:
        """Take the last frames out of the model, a few more where no copy is kept; the stamp after which all went."""
        goal = self.count - frames
        while self._copies and self._copies[-1][0] > goal and len(self._copies) > 1:
            self._copies.pop()
        if not self._copies:
            return None
        count, volume, stamp = self._copies[-1]
        self.volume, self._unfused = _copy(volume), 0
        del self.tracker.past[count:]
        self.count = count
        return stamp

    def surface(self) -> ShownSurface | None:
        """The surface so far, thinned, with how sure each point is."""
        if self.volume is None or not self.count:
            return None
        points = self.volume.surface().vertices
        points = points[:: max(1, len(points) // SHOWN)]
        if not len(points):
            return None
        weight = self.volume.sample(np.asarray(points, float))[2]
        # weights count in pixels of the noise limit, see `fusing_weight`
        limit = NOISIEST * self.volume.settings.truncation
        sigma = limit / np.sqrt(np.maximum(weight, 1e-6))
        seen = sigma < limit  # else a single grazing look: a speck in the air
        return ShownSurface(points[seen].astype(np.float32), sigma[seen].astype(np.float32))

    def _begin_anew(self) -> None:
        """A model of what was known of the object too early shows too little of it to find the rest."""
        self.volume, self.tracker, self.turned = None, self._new_tracker(), Turned()
        self.count = self._unfused = 0
        self._copies.clear()

    def _new_tracker(self) -> Tracker:
        return Tracker(self._model, TrackerSettings(icp=NEARBY))

    def _grown(self, prepared: Prepared, tracked: Tracked, fused: bool, late: bool) -> None:
        assert self.volume is not None
        self._unfused = 0 if fused else self._unfused + 1
        if fused:
            fuse(self.volume, prepared, tracked.T_world_camera)
        self.turned.placed(tracked.T_world_camera)
        self.count += 1
        if np.isfinite(tracked.inlier_share):
            self._shares.append(tracked.inlier_share)
        apart = 4 * EVERY if late else EVERY  # a copy takes as long as three frames
        if fused and (not self._copies or self.count >= self._copies[-1][0] + apart):
            self._copies.append((self.count, _copy(self.volume), prepared.frame.timestamp))

    def _prepared(self, frame: SourceFrame, fused: bool) -> Prepared:
        region = self.looking.region
        if region is None:
            raise FusionError("what turns is not known yet")
        rows, columns = region.window(self.camera)
        plenty = (rows.stop - rows.start) * (columns.stop - columns.start) > PLENTY
        step = 2 if plenty and not fused else 1
        window = slice(rows.start, rows.stop, step), slice(columns.start, columns.stop, step)
        cut = replace(
            frame, depth=np.ascontiguousarray(frame.depth[window]), color=None, ir=None, raw=None, noisier=None
        )
        sensor = of_window(self.sensor, self.camera.shape, window)
        prepared = prepare(cut, every(crop(self.camera, (rows, columns)), step), sensor)
        region = region.cut(window)
        surface, used = prepared.surface, usable(prepared.surface, region)
        return replace(
            prepared,
            depth=_only(prepared.depth, _turning(surface, region)),
            surface=replace(surface, normals=_only(surface.normals, used[..., None])),
        )

    def _model(self, T_world_camera: Array) -> PointMap:
        assert self.volume is not None
        seen = self.volume.raycast(self._seen_by, T_world_camera)
        # the noise of the model is small against that of a frame: many frames made it
        return PointMap(self._seen_by, seen.points, seen.normals, np.zeros_like(seen.depth))


def _turning(surface: PointMap, region: Region) -> NDArray[np.bool_]:
    """(h, w) pixels that show what turns: in its box, before what stands behind, and not always the same."""
    inside = region.holds(surface.points)
    if region.still is not None:
        inside &= ~region.still
    if region.wall is not None:
        inside &= ~(surface.points[..., 2] >= region.wall)
    return inside


def _only(values: NDArray[np.float32], where: NDArray[np.bool_]) -> NDArray[np.float32]:
    return np.where(where, values, np.float32(np.nan))


def _copy(volume: Volume) -> Volume:
    made = Volume(volume.settings)
    made.add(volume)
    return made


class Turned:
    """Adds up turns about one axis.

    Attributes:
        angle: [rad] since the first pose, with a sign.
        seen: (36,) sectors of the turn in which a frame was placed.
    """

    def __init__(self) -> None:
        self.angle = 0.0
        self.seen = np.zeros(SECTORS, bool)
        self._first: Array | None = None
        self._last: Array | None = None
        self._axis: Array | None = None
        self._at: list[float] = []

    def placed(self, T_object_camera: Array) -> None:
        """A frame's pose (4, 4)."""
        R = T_object_camera[:3, :3]
        if self._first is None or self._last is None:
            self._first = self._last = R
        if self._axis is None:
            whole = Rotation.from_matrix(R @ self._first.T).as_rotvec()
            size = float(np.linalg.norm(whole))
            self._axis = whole / size if size > TELLING else None
            self.angle = size
        else:
            self.angle += float(Rotation.from_matrix(R @ self._last.T).as_rotvec() @ self._axis)
        self._last = R
        self.seen[int(np.floor(self.angle / (2 * np.pi) * SECTORS)) % SECTORS] = True
