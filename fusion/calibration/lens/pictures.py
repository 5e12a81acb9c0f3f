"""Where the pictures of a board are: in a recording, or in a plain folder whose file names say what they show."""

import re
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fusion.errors import RecordingError
from fusion.files.inside import all_inside
from fusion.geometry.camera import Camera
from fusion.recording.camera_file import read_camera
from fusion.recording.frame_files import associate
from fusion.recording.images import read_color, read_ir
from fusion.recording.text_files import read_image_list

ENDINGS = {".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".pgm"}
IR_WORDS, COLOR_WORDS = {"ir", "infrared", "nir"}, {"rgb", "color", "colour"}
# tone-mapped copies and other pictures that lie beside the ones that were measured
OTHER_WORDS = {"depth", "mask", "grey", "gray", "registered", "undistorted", "preview"}
IR_FOLDERS, COLOR_FOLDERS = ("ir", "infrared"), ("rgb", "color", "colour")


@dataclass(frozen=True)
class Pictures:
    """The pictures of a folder.

    Attributes:
        folder: where they lie.
        ir: key to file; pictures of both cameras with the same key belong together.
        color: key to file.
        camera: what `camera.json` beside them says, or None.
    """

    folder: Path
    ir: dict[str, Path] = field(default_factory=dict)
    color: dict[str, Path] = field(default_factory=dict)
    camera: Camera | None = None


def find_pictures(folder: Path | str) -> Pictures:
    """The pictures in a recording (`ir.txt`, `rgb.txt`) or a plain folder.

    In a plain folder a name with `ir` or `infrared` between its separators is an IR picture, one with `rgb` or `color`
    a colour picture; folders of these names count alike. Where no name says anything, all are pictures of one camera.

    Raises:
        RecordingError: there are none, or a list cannot be read.
    """
    folder = Path(folder)
    if not folder.is_dir():
        found = "a file" if folder.exists() else "nothing"
        raise RecordingError("there is no folder with pictures", folder, found, "a recording or a folder of pictures")
    camera = read_camera(folder / "camera.json") if (folder / "camera.json").is_file() else None
    if (folder / "ir.txt").is_file() or (folder / "rgb.txt").is_file():
        ir, color = _listed(folder)
    else:
        ir, color = _named(folder)
    if not ir and not color:
        expected = "ir.txt or rgb.txt with their pictures, or a folder of PNG or JPEG files"
        raise RecordingError("there are no pictures of a board", folder, "none", expected)
    return Pictures(folder, ir, color, camera)


def read_picture(path: Path) -> NDArray:
    """(height, width) counts or (height, width, 3) RGB. Raises RecordingError."""
    try:
        return read_ir(path)
    except RecordingError as error:
        if "not grey" not in error.what:
            raise
        return read_color(path)


def thinned(pictures: dict[str, Path], most: int) -> dict[str, Path]:
    """At most `most` of the pictures, evenly over the recording."""
    if len(pictures) <= most:
        return pictures
    keys = list(pictures)
    return {keys[i]: pictures[keys[i]] for i in np.unique(np.linspace(0, len(keys) - 1, most).astype(int))}


def _listed(folder: Path) -> tuple[dict[str, Path], dict[str, Path]]:
    lists = {}
    for name in ("ir", "rgb"):
        path = folder / f"{name}.txt"
        stamps, files = read_image_list(path) if path.is_file() else ([], [])
        lists[name] = (np.array(stamps, float), [folder / file for file in files])
    (ir_stamps, ir_files), (color_stamps, color_files) = lists["ir"], lists["rgb"]
    keys = [f"{stamp:.6f}" for stamp in ir_stamps]
    ir = dict(zip(keys, ir_files, strict=True))
    match = associate(color_stamps, ir_stamps)
    color = {
        keys[m] if m >= 0 else f"{stamp:.6f} (color)": file
        for m, stamp, file in zip(match, color_stamps, color_files, strict=True)
    }
    return ir, color


def _named(folder: Path) -> tuple[dict[str, Path], dict[str, Path]]:
    ir = {p.stem: p for name in IR_FOLDERS for p in _images(folder / name)}
    color = {p.stem: p for name in COLOR_FOLDERS for p in _images(folder / name)}
    if ir or color:
        return ir, color
    plain = {}
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
