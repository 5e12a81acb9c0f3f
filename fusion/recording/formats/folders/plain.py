"""Depth images in a folder, of 16 bit (PNG, PGM, TIFF), NPY, or TIFF of metres, and colour images named like them."""

import re
from collections import Counter
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fusion.errors import RecordingError
from fusion.files.inside import all_inside
from fusion.files.limits import check_size
from fusion.files.npy import npy_header, read_npy
from fusion.files.reading import beginning
from fusion.geometry.camera import Camera
from fusion.recording.cameras.presets import say_camera
from fusion.recording.formats.open3d_folder import matching
from fusion.recording.formats.recorded.parts import no_stamps
from fusion.recording.formats.tum import with_color_placed
from fusion.recording.images.frame_files import INVALID_COUNT, FrameFiles
from fusion.recording.images.header import read_header
from fusion.recording.images.load_frame import load_frame
from fusion.recording.images.read import HEAD, check_shape, image_size, read_real
from fusion.recording.recording import Recording
from fusion.recording.streamed import REAL_SCALE, ImageSource

PLACES = ("", "depth", "depths")
ENDINGS = (".png", ".npy", ".pgm", ".tif", ".tiff")
COLOR_ENDINGS = (".png", ".jpg", ".jpeg", ".ppm")
STAMP = re.compile(r"\d{9,11}\.\d+")  # seconds since 1970, as recorders name their images
FARTHEST = 50.0  # [m] in the middle of an image: no depth camera sees as far, and millimetres begin there


def recognises(folder: Path) -> bool:
    """True for a folder with 16-bit or real images, or two-dimensional NPY arrays, in it or in its `depth/`."""
    return any(_depth_names(folder, place) for place in PLACES)


def read(folder: Path, camera: Camera | None) -> Recording:
    """The recording of a folder of depth images; of a camera without a size that of the images is taken.

    Raises:
        RecordingError: no camera is given, an image cannot be read.
    """
    names = all_inside(folder, next(filter(None, (_depth_names(folder, place) for place in PLACES))), RecordingError)
    first = folder / names[0]
    width, height = _size(first)
    if camera is None:
        raise RecordingError(
            "the recording has no camera",
            folder,
            f"{len(names)} depth images of {width} x {height} alone",
            "a camera",
            say_camera("primesense", folder, lambda: (width, height)),
        )
    real = _is_real(first)
    if not camera.width:
        camera = replace(camera, width=width, height=height)
    if real:
        camera = replace(camera, depth_scale=REAL_SCALE)
    stamps, warnings = _stamps(names)
    if real:
        source = ImageSource(folder, camera, stamps, depth=partial(metres, folder, names, camera.shape))
        return source.recording("plain", None, [*warnings, *_too_far(source)])
    unit = f"the images do not say their unit: a count is taken for {1000 / camera.depth_scale:g} mm"
    color, told = matching(names, _color_names(folder, names))
    files, more = with_color_placed(FrameFiles(folder, names, color), camera)
    if first.suffix == ".npy":
        files = replace(files, read_depth=read_npy_counts)
    return Recording(
        path=folder,
        format="plain",
        camera=camera,
        timestamps=stamps,
        load=partial(load_frame, files, camera, stamps),
        warnings=(*warnings, unit, *told, *more),
        files=files,
    )


def read_npy_counts(path: Path, shape: tuple[int, int]) -> NDArray[np.uint16]:
    """(height, width) counts of an array of whole numbers; what does not fit into 16 bits is missing."""
    values = _plane(path, shape)
    return np.where((values > 0) & (values < INVALID_COUNT), values, 0).astype(np.uint16)


def metres(folder: Path, names: list[str], shape: tuple[int, int], index: int) -> NDArray[np.float32]:
    """(height, width) [m] of an array or image of real numbers; what is no length is missing."""
    path = folder / names[index]
    values = _plane(path, shape) if path.suffix == ".npy" else read_real(path, shape)
    return np.where(np.isfinite(values) & (values > 0), values, np.nan).astype(np.float32)


def _plane(path: Path, shape: tuple[int, int]) -> NDArray[np.float64]:
    found = tuple(side for side in npy_header(path, RecordingError, "a depth image")[0] if side != 1)
    if len(found) != 2:
        raise RecordingError("a depth image is no image", path, f"shape {found}", "height and width")
    check_shape((found[0], found[1]), shape, path)
    return read_npy(path, RecordingError, "a depth image").reshape(shape)


def _depth_names(folder: Path, place: str) -> list[str]:
    """The images of the most usual kind of name whose first one holds depth, in the order that a person would count."""
    here = folder / place
    if not here.is_dir():
        return []
    names = sorted((p.name for p in here.iterdir() if p.suffix.lower() in ENDINGS), key=natural)
    kinds = Counter(_kind(name) for name in names)
    for kind, _ in sorted(kinds.items(), key=lambda item: -item[1]):
        alike = [name for name in names if _kind(name) == kind]
        if _is_depth(here / alike[0]):
            return [f"{place}/{name}" if place else name for name in alike]
    return []


def _color_names(folder: Path, depth: list[str]) -> list[str]:
    """The colour images beside depth images, of the kind of name that there are as many of; none where several are."""
    here = (folder / depth[0]).parent
    names = sorted((p.name for p in here.iterdir() if p.suffix.lower() in COLOR_ENDINGS), key=natural)
    names = [name for name in names if "depth" not in name.lower()]  # what is named so shows depth in colours
    kinds = {kind: [name for name in names if _kind(name) == kind] for kind in map(_kind, names)}
    found = [alike for alike in kinds.values() if len(alike) == len(depth) and _is_color(here / alike[0])]
    place = Path(depth[0]).parent
    return (
        all_inside(folder, [(place / name).as_posix() for name in found[0]], RecordingError) if len(found) == 1 else []
    )


def natural(name: str) -> list[tuple[int, str]]:
    """A key by which 9 comes before 10."""
    parts = re.split(r"([0-9]+)", name)  # digits at every second place
    return [(int(part[:18]) if k % 2 else -1, part) for k, part in enumerate(parts)]


def _kind(name: str) -> str:
    return re.sub(r"[0-9]+", "0", name)


def _is_depth(path: Path) -> bool:
    if path.suffix == ".npy":
        try:
            shape, kind = npy_header(path, RecordingError)
        except RecordingError:
            return False
        sides = [side for side in shape if side != 1]
        # 2: what is smaller is a table of something else, such as poses; no depth camera has fewer pixels
        return len(sides) == 2 and min(sides) > 4 and (kind.kind == "f" or (kind.kind in "iu" and kind.itemsize > 1))
    try:
        header = read_header(beginning(path, HEAD))
    except ValueError:
        return False
    return header.channels == 1 and header.depth > 1


def _is_color(path: Path) -> bool:
    try:
        header = read_header(beginning(path, HEAD))
    except ValueError:
        return False
    return header.channels >= 3 and header.depth == 1


def _is_real(path: Path) -> bool:
    """True for metres, and not counts."""
    if path.suffix == ".npy":
        return npy_header(path, RecordingError, "a depth image")[1].kind == "f"
    return read_header(beginning(path, HEAD)).depth == 4


def _size(path: Path) -> tuple[int, int]:
    """(width, height) of an image."""
    if path.suffix != ".npy":
        return image_size(path)
    height, width = (side for side in npy_header(path, RecordingError)[0] if side != 1)
    check_size(64 * width * height, path, RecordingError, f"a frame of {width} x {height} pixels")
    return width, height


def _stamps(names: list[str]) -> tuple[NDArray[np.float64], list[str]]:
    stems = [Path(name).stem for name in names]
    if all(STAMP.fullmatch(stem) for stem in stems):
        return np.array([float(stem) for stem in stems]), []
    return no_stamps(len(names))


def _too_far(source: ImageSource) -> list[str]:
    """What is told where metres cannot be meant."""
    depth = source.depth(0)
    middle = float(np.median(depth[np.isfinite(depth)])) if np.isfinite(depth).any() else 0.0
    if middle <= FARTHEST:
        return []
    return [f"real numbers are taken for metres, and the first image lies at {middle:.0f} m: write metres, or whole mm"]
