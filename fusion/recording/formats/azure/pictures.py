"""The images of an Azure Kinect's file: depth and infrared of 16 bits, big end first; colour packed or plain."""

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.errors import RecordingError
from fusion.recording.formats.azure.calibration import Calibration
from fusion.recording.formats.azure.matroska import Track
from fusion.recording.formats.recorded.parts import read_part
from fusion.recording.images.read import color_in

PACKED = "MJPG"
# how OpenCV makes RGB of what is not packed: bytes of a row of pixels over its width, rows over the height
PLAIN = {
    "NV12": (cv2.COLOR_YUV2RGB_NV12, 1, 1.5),
    "YUY2": (cv2.COLOR_YUV2RGB_YUY2, 2, 1.0),
    "BGRA": (cv2.COLOR_BGRA2RGB, 4, 1.0),
}


@dataclass(frozen=True)
class TrackPictures:
    """The images of a track that belong to depth frames: -1 where there is none."""

    path: Path
    track: Track
    at: NDArray[np.intp]

    def bytes(self, index: int, what: str) -> bytes | None:
        """The data of the image that belongs to a frame, or None. Raises RecordingError."""
        place = int(self.at[index])
        return None if place < 0 else read_part(self.path, self.track.parts[place], what)


def counts(path: Path, track: Track, blind: NDArray[np.bool_] | None, index: int) -> NDArray[np.uint16]:
    """(h, w) millimetres, 0 where missing and where the lens is not known. Raises RecordingError."""
    data = read_part(path, track.parts[index], "a depth image")
    image = _big_endian(data, track, f"{path}, frame {index}")
    if blind is not None:
        image[blind] = 0
    return image


def grey_image(pictures: TrackPictures, index: int) -> NDArray[np.uint16] | None:
    """(h, w) counts of infrared, or None. Raises RecordingError."""
    data = pictures.bytes(index, "an infrared image")
    return None if data is None else _big_endian(data, pictures.track, f"{pictures.path}, infrared {index}")


def _big_endian(data: bytes, track: Track, where: str) -> NDArray[np.uint16]:
    expected = 2 * track.width * track.height
    if len(data) != expected:
        raise RecordingError("an image is of another size", where, f"{len(data)} bytes", f"{expected} bytes")
    return np.frombuffer(data, ">u2").reshape(track.height, track.width).astype(np.uint16)


def color_image(pictures: TrackPictures, size: tuple[int, int], index: int) -> NDArray[np.uint8] | None:
    """(h, w, 3) RGB of a size (width, height), or None. Raises RecordingError."""
    data, (width, height) = pictures.bytes(index, "a colour image"), size
    if data is None or pictures.track.codec == PACKED:
        return None if data is None else color_in(data, pictures.path)
    code, across, down = PLAIN[pictures.track.codec]
    rows, channels = int(height * down), (across,) if across > 1 else ()
    expected = rows * width * across
    if len(data) != expected or width % 2 or height % 2:
        where = f"{pictures.path}, colour {index}"
        raise RecordingError("an image is of another size", where, f"{len(data)} bytes", f"{expected} bytes")
    return np.asarray(cv2.cvtColor(np.frombuffer(data, np.uint8).reshape(rows, width, *channels), code), np.uint8)


def blind_pixels(known: Calibration) -> NDArray[np.bool_] | None:
    """(h, w) pixels without a ray: beyond the lens' radius or where its formula turns back; None where all have one."""
    turned, far = known.depth.blind(), ~(np.linalg.norm(known.depth.rays(), axis=-1) <= known.radius)
    blind = far if turned is None else far | turned
    return blind if blind.any() else None
