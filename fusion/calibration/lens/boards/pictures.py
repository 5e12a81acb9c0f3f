"""Pictures of a board: in a recording of any format, or in a plain folder whose names say what they show."""

import re
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fusion.errors import RecordingError
from fusion.files.inside import all_inside
from fusion.geometry.camera import Camera
from fusion.recording.images.frame_files import associate
from fusion.recording.images.read import read_color, read_ir
from fusion.recording.native.camera_file import read_camera
from fusion.recording.native.text_files import read_image_list
from fusion.recording.open import open_recording, recognised
from fusion.recording.recording import Recording

ENDINGS = {".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".pgm"}
IR_WORDS, COLOR_WORDS = {"ir", "infrared", "nir"}, {"rgb", "color", "colour"}
# tone-mapped copies and other pictures that lie beside the ones that were measured
OTHER_WORDS = {"depth", "mask", "grey", "gray", "registered", "undistorted", "preview"}
IR_FOLDERS, COLOR_FOLDERS = ("ir", "infrared"), ("rgb", "color", "colour")


@dataclass(frozen=True)
class FramePicture:
    """A picture that is no file of its own: infrared or colour of a frame."""

    recording: Recording
    index: int
    color: bool

    def __str__(self) -> str:
        return f"{self.recording.path}, frame {self.index}"

    def read(self) -> NDArray:
        """(h, w) counts or (h, w, 3) RGB. Raises RecordingError."""
        if self.color and self.recording.color_is_apart:
            image: NDArray | None = self.recording.color_apart(self.index)
        else:
            frame = self.recording[self.index]
            image = frame.color if self.color else frame.ir
        if image is None:
            raise RecordingError("the picture is not in the pixels of its camera", self, "another size", "one size")
        return image


Picture = Path | FramePicture


@dataclass(frozen=True)
class BoardPictures:
    """The pictures of a folder or recording."""

    path: Path  # where they lie
    # key to picture; pictures of both cameras with the same key belong together
    ir: dict[str, Picture] = field(default_factory=dict)
    color: dict[str, Picture] = field(default_factory=dict)  # key to picture
    camera: Camera | None = None  # what stands beside them, or None


def find_pictures(path: Path | str, topic: str | None = None) -> BoardPictures:
    """The pictures in a recording of any format or in a plain folder.

    In a plain folder a name with `ir` or `infrared` between its separators is an IR picture, one with `rgb` or `color`
    a colour picture; folders of these names count alike. Where no name says anything, all are pictures of one camera.

    Args:
        path: the file or folder.
        topic: which depth stream of a bag that has several.

    Raises:
        RecordingError: there are none, or a list or the recording cannot be read.
    """
    folder = Path(path)
    if folder.is_file() or topic is not None:
        return _of_frames(open_recording(folder, topic=topic))
    if not folder.is_dir():
        raise RecordingError("there are no pictures", folder, "nothing", "a recording or a folder of pictures")
    camera = read_camera(folder / "camera.json") if (folder / "camera.json").is_file() else None
    if (folder / "ir.txt").is_file() or (folder / "rgb.txt").is_file():
        ir, color = _listed(folder)
    else:
        ir, color = _named(folder)
    form = None if ir or color else recognised(folder)
    if form is not None:
        return _of_frames(open_recording(folder))
    if not ir and not color:
        expected = "ir.txt or rgb.txt with their pictures, or a folder of PNG or JPEG files"
        raise RecordingError("there are no pictures of a board", folder, "none", expected)
    return BoardPictures(folder, ir, color, camera)


def read_picture(picture: Picture) -> NDArray:
    """(height, width) counts or (height, width, 3) RGB. Raises RecordingError."""
    if isinstance(picture, FramePicture):
        return picture.read()
    try:
        return read_ir(picture)
    except RecordingError as error:
        if "not grey" not in error.what:
            raise
        return read_color(picture)


def place_of(picture: Picture) -> Path:
    """The folder or recording that a picture is in."""
    return picture.recording.path if isinstance(picture, FramePicture) else picture.parent


def thinned(pictures: dict[str, Picture], most: int) -> dict[str, Picture]:
    """At most `most` of the pictures, evenly over the recording."""
    if len(pictures) <= most:
        return pictures
    keys = list(pictures)
    return {keys[i]: pictures[keys[i]] for i in np.unique(np.linspace(0, len(keys) - 1, most).astype(int))}


def _of_frames(recording: Recording) -> BoardPictures:
    """Infrared and colour of all frames that have them, by their stamps. Raises RecordingError."""
    found: dict[bool, dict[str, Picture]] = {}
    for color, has in ((False, recording.has_ir), (True, recording.has_color)):
        there = np.zeros(0, int) if has is None else np.flatnonzero(has)
        found[color] = {f"{recording.timestamps[i]:.6f}": FramePicture(recording, int(i), color) for i in there}
    if not found[False] and not found[True]:
        expected = "infrared or colour images"
        raise RecordingError("there are no pictures of a board", recording.path, "depth alone", expected)
    return BoardPictures(recording.path, found[False], found[True], recording.camera)


def _listed(folder: Path) -> tuple[dict[str, Picture], dict[str, Picture]]:
    lists = {}
    for name in ("ir", "rgb"):
        path = folder / f"{name}.txt"
        stamps, files = read_image_list(path) if path.is_file() else ([], [])
        lists[name] = (np.array(stamps, float), [folder / file for file in files])
    (ir_stamps, ir_files), (color_stamps, color_files) = lists["ir"], lists["rgb"]
    keys = [f"{stamp:.6f}" for stamp in ir_stamps]
    ir: dict[str, Picture] = dict(zip(keys, ir_files, strict=True))
    match = associate(color_stamps, ir_stamps)
    color: dict[str, Picture] = {
        keys[m] if m >= 0 else f"{stamp:.6f} (color)": file
        for m, stamp, file in zip(match, color_stamps, color_files, strict=True)
    }
    return ir, color


def _named(folder: Path) -> tuple[dict[str, Picture], dict[str, Picture]]:
    ir: dict[str, Picture] = {p.stem: p for name in IR_FOLDERS for p in _images(folder / name)}
    color: dict[str, Picture] = {p.stem: p for name in COLOR_FOLDERS for p in _images(folder / name)}
    if ir or color:
        return ir, color
    plain: dict[str, Picture] = {}
    for path in _images(folder):
        words = [word for word in re.split(r"[_\-. ]+", path.stem.lower()) if word]
        if OTHER_WORDS & set(words):
            continue
        rest = "_".join(word for word in words if word not in IR_WORDS | COLOR_WORDS) or path.stem
        if IR_WORDS & set(words):
            ir[rest] = path
        elif COLOR_WORDS & set(words):
            color[rest] = path
        else:
            plain[path.stem] = path
    return (ir, color) if ir or color else (plain, {})


def _images(folder: Path) -> list[Path]:
    if not folder.is_dir():
        return []
    names = sorted(p.name for p in folder.iterdir() if p.suffix.lower() in ENDINGS and not p.name.startswith("."))
    return [folder / name for name in all_inside(folder, names, RecordingError)]


def usual_size(sizes: dict[str, tuple[int, int]]) -> tuple[int, int]:
    """The size (width, height) that most pictures have."""
    return Counter(sizes.values()).most_common(1)[0][0]
