"""Normals, reflectance and segmentation of an ideal recording, as simulators write them: one image a frame."""

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.errors import RecordingError
from fusion.files.json_file import read_json
from fusion.files.npy import read_npy
from fusion.geometry.camera import Camera
from fusion.recording.formats.folders.plain import natural
from fusion.recording.images.read import decode_image, read_bytes
from fusion.sensor.view import Image
from fusion.simulation.ideal.slopes import facing_of

ENDINGS = (".png", ".npy", ".jpg", ".jpeg")
ALIKE = 0.9  # cosine: below that, half of the given normals are more than 26 deg from those of the depth
OPENGL = np.array([1, -1, -1], np.float32)  # y up, z towards the viewer


@dataclass(frozen=True)
class Channel:
    """Images of one kind: `paths` in the order of the frames."""

    name: str
    paths: tuple[Path, ...]

    def image(self, index: int, shape: tuple[int, int]) -> NDArray:
        """The values (h, w) or (h, w, channels) of a frame. Raises RecordingError."""
        path = self.paths[index]
        if path.suffix == ".npy":
            values = read_npy(path, RecordingError, f"the {self.name}").squeeze()
            if values.shape[:2] != shape or values.ndim > 3:
                raise _size(self.name, path, values.shape[:2], shape)
            return values
        image = decode_image(read_bytes(path), cv2.IMREAD_UNCHANGED, path, shape)
        return image if image.ndim == 2 else image[..., [2, 1, 0]]


def channel(folder: Path, name: str, frames: int) -> Channel:
    """The images in a folder, in the order that a person would count. Raises RecordingError: not one for each frame."""
    if not folder.is_dir():
        raise RecordingError(f"the {name} cannot be read", folder, "no folder", "a folder with an image for each frame")
    found = sorted((p for p in folder.iterdir() if p.suffix.lower() in ENDINGS), key=lambda p: natural(p.name))
    if len(found) != frames:
        expected = f"{frames}, one for each frame"
        raise RecordingError(f"the {name} images do not fit the recording", folder, f"{len(found)} images", expected)
    return Channel(name, tuple(found))


def normals_in(given: Channel, index: int, camera: Camera, depth: Image) -> Image:
    """Normals (h, w, 3) in the camera frame: numbers as they are, images as 2 v / largest - 1.

    Whether y is down and z forward or, as in OpenGL, y is up and z back is told by the depth.

    Raises:
        RecordingError: they fit the depth in neither way.
    """
    path = given.paths[index]
    values = given.image(index, camera.shape)
    if values.ndim != 3 or values.shape[2] != 3:
        raise RecordingError("the normals cannot be used", path, f"shape {values.shape}", "three values for a pixel")
    if values.dtype.kind == "u":
        values = values.astype(np.float32) * (2 / np.iinfo(values.dtype).max) - 1
    values = values.astype(np.float32)
    with np.errstate(all="ignore"):
        values = values / np.linalg.norm(values, axis=-1, keepdims=True)
        computed = facing_of(depth, camera).normals
        assert computed is not None
        alike = {sign: _alike(values * axes, computed) for sign, axes in ((1, np.float32(1)), (-1, OPENGL))}
    sign = max(alike, key=lambda key: alike[key])
    if not alike[sign] > ALIKE:
        found = f"a median cosine of {alike[sign]:.2f} with those of the depth"
        expected = "normals in the camera frame, x right, y down, z forward or y up, z back"
        raise RecordingError("the normals do not fit the depth", path, found, expected)
    return values if sign == 1 else values * OPENGL


def share_in(given: Channel, index: int, shape: tuple[int, int]) -> Image:
    """Reflectance, or what is lit (h, w): numbers as they are, images over their largest; colours as their mean."""
    values = given.image(index, shape)
    largest = np.iinfo(values.dtype).max if values.dtype.kind == "u" else 1
    grey = values if values.ndim == 2 else values.mean(axis=2)
    grey = (grey / largest).astype(np.float32)
    if np.nanmin(grey, initial=0) < 0 or np.nanmax(grey, initial=0) > 1:
        found = f"{np.nanmin(grey):g} to {np.nanmax(grey):g}"
        raise RecordingError(f"the {given.name} cannot be used", given.paths[index], found, "0 to 1")
    return grey


def between_in(given: Channel, index: int, camera: Camera) -> Image:
    """Depth between the pixels, of any size [m]: numbers as they are, images in the counts of the recording."""
    path = given.paths[index]
    if path.suffix == ".npy":
        return read_npy(path, RecordingError, f"the {given.name}").squeeze().astype(np.float32)
    values = decode_image(read_bytes(path), cv2.IMREAD_UNCHANGED, path)
    return values.astype(np.float32) / np.float32(camera.depth_scale)


def segmentation_in(given: Channel, index: int, shape: tuple[int, int]) -> NDArray[np.int64]:
    """Labels (h, w): whole numbers; colours as red + 256 green + 65536 blue."""
    values = given.image(index, shape)
    if values.ndim == 2:
        return np.nan_to_num(values).astype(np.int64)
    return (values[..., :3].astype(np.int64) * [1, 256, 65536]).sum(axis=-1)


def read_table(path: Path) -> dict[int, float]:
    """Reflectance of each label: `{"1": 0.5, "2": 0.1}`. Raises RecordingError."""
    table = {}
    for key, value in read_json(path, RecordingError, "the table of reflectances").items():
        if not key.isdecimal() or isinstance(value, bool) or not isinstance(value, int | float) or not 0 <= value <= 1:
            expected = "labels with 0 to 1 each"
            raise RecordingError("a reflectance cannot be used", path, f"{key[:40]}: {str(value)[:40]}", expected)
        table[int(key)] = float(value)
    return table


def looked_up(table: dict[int, float], labels: NDArray[np.int64]) -> Image:
    """Reflectance (h, w) of labels; NaN where the table has none."""
    known, inverse = np.unique(labels, return_inverse=True)
    return np.array([table.get(int(label), np.nan) for label in known], np.float32)[inverse].reshape(labels.shape)


def _alike(values: Image, computed: Image) -> float:
    """Median cosine of normals, on whichever side they point."""
    return float(np.nanmedian(np.abs((values * computed).sum(axis=-1))))


def _size(name: str, path: Path, found: tuple[int, ...], shape: tuple[int, int]) -> RecordingError:
    shown = " x ".join(map(str, found[::-1]))
    return RecordingError(f"the {name} image has another size", path, shown, f"{shape[1]} x {shape[0]}")
