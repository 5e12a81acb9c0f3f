"""Recordings whose images stand in one file: what is read for a frame, and how it becomes one."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fusion.errors import RecordingError
from fusion.geometry.camera import Camera
from fusion.geometry.trajectory import Trajectory
from fusion.recording.cameras.own_cameras import color_in_pixels, depth_in, nearest_in
from fusion.recording.cameras.turned import found_turn, turned
from fusion.recording.images.read import check_shape
from fusion.recording.recording import Frame, FrameStreams, Recording

# counts per metre of depth that is stored in metres, for what is written of it: TUM's, 0.2 mm up to 13 m
REAL_SCALE = 5000.0


@dataclass(frozen=True)
class ImageSource:
    """Where the images of frames come from.

    Attributes:
        path: named in messages.
        camera: of the depth images; its `color` where colour images are in pixels of their own.
        stamps: (n,) [s].
        depth: the depth (h, w) float32 [m] of a frame, NaN where missing; raises RecordingError.
        color: the colour image (h, w, 3) uint8 RGB of a frame, or None; raises RecordingError. None: there are none.
        has_color: (n,) frames that have one; empty where none has.
        own: by frame, the camera that saw it where that is not `camera`.
        counts: as `FrameStreams.counts`.
        ir: the infrared image (h, w) uint16 of a frame in the depth images' pixels, or None; raises RecordingError.
        has_ir: (n,) frames that have one; empty where none has.
        noisier: as of a `Frame`, (h, w) in the depth images' pixels or None; raises RecordingError.
        turn: as of `FrameFiles`.
        stored: (height, width) of the first colour image before its notes (EXIF) turned it; None: they do not.
    """

    path: Path
    camera: Camera
    stamps: NDArray[np.float64]
    depth: Callable[[int], NDArray[np.float32]]
    color: Callable[[int], NDArray[np.uint8] | None] | None = None
    has_color: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, bool))
    own: Mapping[int, Camera] = field(default_factory=dict)
    counts: Callable[[int], NDArray[np.uint16]] | None = None
    ir: Callable[[int], NDArray[np.uint16] | None] | None = None
    has_ir: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, bool))
    noisier: Callable[[int], NDArray[np.float32] | None] | None = None
    turn: int = 0
    stored: tuple[int, int] | None = None

    def picture(self, index: int) -> NDArray[np.uint8] | None:
        """The colour image of a frame as its camera lies, or None. Raises RecordingError."""
        color = None if self.color is None else self.color(index)
        return None if color is None else turned(color, (self.camera.color or self.camera).shape, self.turn)

    @property
    def apart(self) -> bool:
        """Colour images are not in the pixels of the depth images."""
        return self.camera.color is not None and self.color is not None

    def frame(self, index: int) -> Frame:
        """The frame with this index. Raises RecordingError."""
        depth = self.depth(index)
        check_shape((depth.shape[0], depth.shape[1]), self.camera.shape, self.path)
        own = self.own.get(index)
        noisier = None if self.noisier is None else self.noisier(index)
        if own is not None:
            depth = depth_in(depth, own, self.camera)
            noisier = None if noisier is None else nearest_in(noisier, own, self.camera)
        color = None if self.apart else self.picture(index)
        ir = None if self.ir is None else self.ir(index)
        if color is not None and color.shape[:2] != self.camera.shape:
            return Frame(index, float(self.stamps[index]), depth, ir=ir, unfit=("color",), noisier=noisier)
        if color is not None and own is not None:
            color = color_in_pixels(color, own, self.camera)
        return Frame(index, float(self.stamps[index]), depth, color, ir, noisier=noisier)

    def color_apart(self, index: int) -> NDArray[np.uint8] | None:
        """The colour image of a frame in the pixels of `camera.color`. Raises RecordingError."""
        color, seen_by = self.picture(index), self.camera.color
        own = self.own.get(index)
        if color is None or own is None or seen_by is None or color.shape[:2] != seen_by.shape:
            return color
        return color_in_pixels(color, own.resized(seen_by.width, seen_by.height), seen_by)

    def recording(
        self, form: str, poses: Trajectory | None, warnings: list[str], settings: dict[str, str] | None = None
    ) -> Recording:
        """The recording of these frames. Raises RecordingError where there are none."""
        if not len(self.stamps):
            raise RecordingError("the recording is empty", self.path, "no frame with depth", "one or more")
        source, told = self._color_turned()
        return source._recording(form, poses, [*warnings, *told], settings or {})

    def _color_turned(self) -> "tuple[ImageSource, list[str]]":
        """With colour images that fit their camera; without them where it is not clear how they would."""
        if self.color is None or self.turn:
            return self, []
        turn, told = found_turn(self.has_color, self.color, self.depth, self.camera, self.stored)
        if turn is None:
            return replace(self, color=None, has_color=np.zeros(0, bool)), told
        return replace(self, turn=turn), told

    def _recording(
        self, form: str, poses: Trajectory | None, warnings: list[str], settings: dict[str, str]
    ) -> Recording:
        shown = FrameStreams(
            color=self.has_color,
            ir=self.has_ir,
            counts=self.counts,
            color_apart=self.color_apart if self.apart else None,
        )
        return Recording(
            path=self.path,
            format=form,
            camera=self.camera,
            timestamps=self.stamps,
            load=self.frame,
            poses=poses,
            warnings=tuple(warnings),
            streams=shown,
            settings=settings,
        )


def with_color_of(camera: Camera, color: Camera) -> Camera:
    """A depth camera whose images lie in those of a colour camera at the same place; the same where sizes are equal."""
    if color.shape == camera.shape:
        return camera
    return replace(camera, color=color, T_color_depth=np.eye(4))
