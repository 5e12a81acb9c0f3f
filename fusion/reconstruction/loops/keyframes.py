"""Key frames: the few frames of a recording that stand for all when places are recognised."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.geometry.depth import PointMap
from fusion.geometry.pose import Array, angle, inverse, transform
from fusion.tracking.equations import Points, lay_out
from fusion.tracking.landmarks import Landmarks, landmarks
from fusion.volume.prepared import Prepared

WIDTH = 400  # images wider than this are thinned to every second pixel, as the model is (see `placing`)
SHIFT = 0.08  # of the distance: a key frame after each such shift, or
TURN = np.deg2rad(8)  # turn: neighbours share four fifths of the image (a seventh of 57 degrees)
POINTS = 6000  # of a key frame take part in alignment
SAMPLE = 400  # of them say what two views share
OFTEN = 5  # frames, after which one is a key frame where the surface leaves directions open: a sixth of a second
SIGHTED = 50  # landmarks that an image of a room shows at least; a dark one has fewer (guess)
BESIDE = 3  # key frames to each side, whose surfaces together have a shape: some 50 degrees
THINNED = 5  # of their points, one in so many
NEAR = 4  # key frames that a frame found again is compared with
MOST = 400  # key frames, an even number: 1 GB at 320 x 240


@dataclass(frozen=True)
class Keyframe:
    """A frame that stands for those around it."""

    index: int  # of the frame in the recording
    piece: int  # of the trajectory that it belongs to
    T_world_camera: Array  # (4, 4) as tracked
    surface: PointMap  # what it shows
    grey: NDArray[np.uint8] | None  # (h, w) uint8 in the same pixels, or None without colour
    held: bool = False  # surfaces held the camera in all directions all the way from the key frame before

    @cached_property
    def points(self) -> Points:
        """Laid out for alignment."""
        return lay_out(self.surface, POINTS)

    @cached_property
    def sample(self) -> Array:
        """(m, 3) some of its points [m]."""
        known = self.surface.points[np.isfinite(self.surface.normals[..., 0])]
        return known[:: max(1, len(known) // SAMPLE)].astype(float)

    @cached_property
    def landmarks(self) -> Landmarks | None:
        """Where there is a grey image."""
        return None if self.grey is None else landmarks(self.grey, self.surface)


@dataclass
class Keyframes:
    """Chooses key frames while a recording is tracked."""

    found: list[Keyframe] = field(default_factory=list)  # in their order
    spacing: float = 1.0  # of the distances above; it doubles, and every second one goes, where there are too many
    held: bool = True  # see `Keyframe`, for what comes after the last one

    def lost(self) -> None:
        """The camera went on without being tracked."""
        self.held = False

    def look(self, piece: int, T_world_camera: Array, frame: Prepared, slid: bool = False) -> bool:
        """Keep a placed frame, if the camera has moved enough since the last one of its piece; says whether.

        Args:
            T_world_camera: (4, 4) as tracked.
            slid: its surface left a direction open, so that its pose may miss a motion.
        """
        self.held &= not slid
        last = self.found[-1] if self.found and self.found[-1].piece == piece else None
        if last is not None:
            moved = inverse(last.T_world_camera) @ T_world_camera
            distance = float(np.median(last.sample[:, 2])) if len(last.sample) else 1.0
            near = np.linalg.norm(moved[:3, 3]) < SHIFT * self.spacing * distance
            soon = frame.frame.index - last.index < OFTEN * self.spacing or not slid
            if near and soon and angle(moved) < TURN * self.spacing:
                return False
        self.found.append(replace(keyframe_of(frame, piece, T_world_camera), held=self.held))
        self.held = True
        if len(self.found) > MOST:
            self._thin()
        return True

    def _thin(self) -> None:
        kept, left = self.found[::2], self.found[1::2]
        ways = zip(left, kept[1:], strict=True)
        self.found = [kept[0], *(replace(frame, held=frame.held and by.held) for by, frame in ways)]
        self.spacing *= 2

    def shown(self, piece: int) -> Array:
        """(n, 3) some points of all that a piece has seen [m]."""
        return np.concatenate([transform(f.T_world_camera, f.sample) for f in self.found if f.piece == piece])

    def around(self, here: Keyframe) -> list[Keyframe]:
        """Those of the same piece that look from nearly where a frame does the same way, the nearest first."""
        own = [frame for frame in self.found if frame.piece == here.piece]
        return sorted(own, key=lambda frame: _apart(frame.T_world_camera, here.T_world_camera))[:NEAR]


def _apart(a: Array, b: Array) -> float:
    """Shift [m] and turn [rad] between two poses, as one number: at 1 m they move the image alike."""
    moved = inverse(a) @ b
    return float(np.linalg.norm(moved[:3, 3])) + angle(moved)


def keyframe_of(frame: Prepared, piece: int, T_world_camera: Array) -> Keyframe:
    """A frame as a key frame."""
    surface, color = _thinned(frame.surface), frame.frame.color
    step = round(frame.surface.camera.width / surface.camera.width)
    grey = None
    if color is not None:
        rows, columns = surface.camera.shape
        grey = np.asarray(cv2.cvtColor(color, cv2.COLOR_RGB2GRAY)[::step, ::step][:rows, :columns], np.uint8)
    return Keyframe(frame.frame.index, piece, T_world_camera, surface, grey)


def sighted(frames: Sequence[Keyframe]) -> bool:
    """Colour images show enough landmarks to recognise places by."""
    return bool(np.median([0 if frame.landmarks is None else len(frame.landmarks) for frame in frames]) >= SIGHTED)


def surroundings(frames: Sequence[Keyframe], poses: Array, k: int) -> tuple[Array, Array]:
    """Points (n, 3) [m] and normals (n, 3) of a key frame and those beside it, in its own frame, by poses (k, 4, 4)."""
    points, normals = [], []
    for m in range(max(0, k - BESIDE), min(len(frames), k + BESIDE + 1)):
        if frames[m].piece != frames[k].piece:
            continue
        T, surface = inverse(poses[k]) @ poses[m], frames[m].surface
        known = np.isfinite(surface.normals[..., 0])
        points.append(transform(T, surface.points[known][::THINNED].astype(float)))
        normals.append(surface.normals[known][::THINNED] @ T[:3, :3].T)
    return np.concatenate(points), np.concatenate(normals)


def _thinned(surface: PointMap) -> PointMap:
    """Every second pixel of a wide image; noise stays as it is."""
    camera = surface.camera
    if camera.width <= WIDTH:
        return surface
    rows, columns = camera.height // 2 * 2, camera.width // 2 * 2
    small = replace(
        camera, width=columns // 2, height=rows // 2, fx=camera.fx / 2, fy=camera.fy / 2, cx=camera.cx / 2,
        cy=camera.cy / 2,
    )  # fmt: skip
    some = (slice(0, rows, 2), slice(0, columns, 2))
    images = (np.ascontiguousarray(image[some]) for image in (surface.points, surface.normals, surface.sigma))
    return PointMap(small, *images)
