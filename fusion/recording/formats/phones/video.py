"""Colour images of a video beside the depth, by their number; only where the library for videos is installed."""

import importlib.util
from collections.abc import Iterator
from pathlib import Path
from threading import Lock
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.errors import RecordingError
from fusion.files.inside import inside
from fusion.files.limits import check_size
from fusion.files.reading import open_regular

AHEAD = 30  # images that are decoded to come to one ahead; further on the video is searched for a key frame
NOWHERE = -10 * AHEAD  # what comes next has to be searched for
MISSING = 'colour is left out: its video needs the Python package av; pip install "fusion-scan[iphone]"'


class Video:
    """The images of a video file; what comes next is at hand, other images are searched for.

    Attributes:
        width, height: [px].
        frames: how many there are, as the file says.
    """

    def __init__(self, path: Path) -> None:
        import av

        self._path, self._lock = path, Lock()
        open_regular(path, RecordingError, "the video", takes=0).close()
        try:
            # this demuxer alone: others, of play lists, open what the file names
            self._container: Any = av.open(str(path), format="mov")
            self._stream = self._container.streams.video[0]
        except (av.FFmpegError, IndexError) as problem:
            raise RecordingError("the video cannot be read", path, _said(problem), "a whole MP4 file") from problem
        self.width, self.height = int(self._stream.codec_context.width), int(self._stream.codec_context.height)
        check_size(8 * 3 * self.width * self.height, path, RecordingError, "an image of the video")
        self._times = self._every_time(av)
        self.frames = len(self._times)
        self._images: Iterator[Any] = iter(())
        self._next = NOWHERE
        self._last: tuple[int, NDArray[np.uint8]] | None = None

    def image(self, index: int) -> NDArray[np.uint8] | None:
        """The image (height, width, 3) RGB with this number, None behind the last. Raises RecordingError."""
        import av

        if not 0 <= index < self.frames:
            return None
        with self._lock:
            if self._last is None or self._last[0] != index:
                try:
                    self._last = index, self._decoded(index)
                except (av.FFmpegError, StopIteration) as problem:
                    self._next = NOWHERE
                    raise RecordingError(
                        "an image of the video is damaged", f"{self._path}, image {index}"
                    ) from problem
            return self._last[1].copy()

    def _decoded(self, index: int) -> NDArray[np.uint8]:
        if not 0 <= index - self._next <= AHEAD:
            self._container.seek(self._times[index], stream=self._stream)
            self._images = self._container.decode(self._stream)
        while True:
            image = next(self._images)
            if image.pts is not None and image.pts >= self._times[index]:
                self._next = index + 1
                return np.asarray(image.to_ndarray(format="rgb24"), np.uint8)

    def _every_time(self, av: Any) -> list[int]:
        """When each image is shown, in the order of showing; nothing is decoded."""
        try:
            packets = self._container.demux(self._stream)
            return sorted(packet.pts for packet in packets if packet.pts is not None and packet.size)
        except av.FFmpegError as problem:
            raise RecordingError(
                "the video cannot be read", self._path, _said(problem), "a whole MP4 file"
            ) from problem


def open_video(folder: Path, name: str) -> tuple[Video | None, list[str]]:
    """The video of this name, or None with what is told about it."""
    if not (folder / name).is_file():
        return None, [f"there is no {name}: no colour"]
    path = inside(folder, name, RecordingError)
    if importlib.util.find_spec("av") is None:
        return None, [MISSING]
    try:
        return Video(path), []
    except RecordingError as problem:
        return None, [f"colour is left out: {problem}"]


def _said(problem: Exception) -> str:
    """What the library says, without the number of its error."""
    return str(getattr(problem, "strerror", None) or "no images")[:80]
