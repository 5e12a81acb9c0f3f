"""A native recording that grows frame by frame in its place: whatever stops it, what is listed is whole.

An image is written before any list names it, `depth.txt`, which says what frames there are, comes last, and a line is
one write. So a process that is killed leaves at most an image that nobody names. A machine that loses its power may
lose what its disk had not been given yet: that is the system's affair.
"""

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.devices.source import Description, SourceFrame
from fusion.errors import RecordingError
from fusion.recording.images.png import png_bytes
from fusion.recording.native.camera_file import write_camera
from fusion.recording.native.device_file import write_device
from fusion.recording.native.telemetry_file import CLOCKS, RECORDED
from fusion.recording.writing.write import LISTS, depth_counts

Color = Literal["png", "jpeg"]
JPEG = [cv2.IMWRITE_JPEG_QUALITY, 95]


class GrowingFolder:
    """Writes frames into a native folder that may be moved between two of them.

    Args:
        folder: an empty one; `folder` may be set anew when it was moved.
        source: what the frames come from: its camera, and what the device told of itself (`device.json`).
        color: PNG keeps each value; JPEG (quality 95) takes a tenth of the time and of the room.

    Raises:
        RecordingError: (`add`) an image has another size than the camera, or a stamp is not finite.
        OSError: something cannot be written; what was listed before stays whole.
    """

    def __init__(self, folder: Path, source: Description, color: Color = "png") -> None:
        self.folder, self.source, self.color = folder, source, color
        self.count = 0
        self._columns: tuple[str, ...] = ()
        self._lists: set[str] = set()
        write_camera(folder / "camera.json", source.camera)
        told: dict[str, Any] = {
            "source": source.name,
            "serial": source.serial,
            "firmware": source.firmware,
            "raw": source.raw,
        }
        write_device(folder, source.settings, **told, tables=dict(source.tables))

    def add(self, frame: SourceFrame) -> None:
        """Write one frame."""
        if not np.isfinite(frame.timestamp):
            raise RecordingError("a time stamp is not finite", f"frame {frame.index}", frame.timestamp, "seconds")
        color = frame.color if frame.color_apart is None else frame.color_apart
        # depth comes last, in the lists too
        images = {"raw": frame.raw, "ir": frame.ir, "rgb": color, "depth": frame.depth}
        given = {name: image for name, image in images.items() if image is not None}
        for name, image in given.items():
            self._check(name, image, name == "rgb" and frame.color_apart is not None)
        files = {name: f"{name}/{self.count:06d}.{self._ending(name)}" for name in given}
        for name, image in given.items():
            self._write_image(files[name], self._encoded(image))
        self._log(frame)
        for name, file in files.items():
            head = "" if name in self._lists else f"# {LISTS[name]}\n# timestamp filename\n"
            append(self.folder / f"{name}.txt", f"{head}{frame.timestamp:.6f} {file}\n")
            self._lists.add(name)
        self.count += 1

    def _check(self, name: str, image: NDArray, apart: bool) -> None:
        camera = self.source.camera
        seen_by = camera.color if apart and camera.color is not None else camera
        if image.shape[:2] != seen_by.shape:
            found, expected = f"{image.shape[1]} x {image.shape[0]}", f"{seen_by.width} x {seen_by.height}"
            raise RecordingError("an image has another size than the camera", f"{name} images", found, expected)

    def _ending(self, name: str) -> str:
        return "jpg" if name == "rgb" and self.color == "jpeg" else "png"

    def _encoded(self, image: NDArray) -> bytes:
        if image.ndim == 3 and self.color == "jpeg":
            bgr = cv2.cvtColor(np.ascontiguousarray(image), cv2.COLOR_RGB2BGR)
            return cv2.imencode(".jpg", bgr, JPEG)[1].tobytes()
        if image.ndim == 2 and image.dtype != np.uint16:
            image = depth_counts(image, self.source.camera.depth_scale)
        return png_bytes(image)

    def _write_image(self, name: str, data: bytes) -> None:
        path = self.folder / name
        try:
            path.parent.mkdir(exist_ok=True)
            path.write_bytes(data)
        except OSError:
            path.unlink(missing_ok=True)
            raise

    def _log(self, frame: SourceFrame) -> None:
        """A row of `telemetry.csv`: both clocks, and what the device told; the columns are those of the first frame."""
        head = ""
        if not self._columns:
            self._columns = (*RECORDED, *sorted(set(frame.log) - set(RECORDED)))
            head = ",".join(self._columns) + "\n"
        told = {**frame.log, "timestamp": frame.timestamp, "device_s": frame.device_time, "host_s": frame.host_time}
        told["missed"] = frame.missed
        cells = (_cell(name, float(told.get(name, np.nan))) for name in self._columns)
        append(self.folder / "telemetry.csv", head + ",".join(cells) + "\n")


def append(path: Path, text: str, write: Callable[[int, bytes], int] = os.write) -> None:
    """Add lines to a file in one write; where not all of it finds room, none of it stays. Raises OSError."""
    data = text.encode()
    handle = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o666)
    try:
        size = os.fstat(handle).st_size
        try:
            done = write(handle, data)
            if done < len(data):  # a disk that is full to the brim; the next write tells so
                write(handle, data[done:])
        except OSError:
            os.ftruncate(handle, size)
            raise
    finally:
        os.close(handle)


def _cell(name: str, value: float) -> str:
    if not np.isfinite(value):
        return ""
    return f"{value:.6f}" if name in CLOCKS else f"{value:.9g}"
