"""A small picture of a result: its mesh, its depth, the first picture of its page, or the depth that it was made of."""

import base64
import re
from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.errors import FusionError
from fusion.files.output.publish import atomic_file

WIDTH, HEIGHT = 192, 128  # [px]
QUALITY = 80
MANY = 400_000  # triangles: a picture of more takes longer than it is worth
PICTURE = re.compile(rb"data:image/(?:png|jpeg);base64,([A-Za-z0-9+/=]{200,})")


def write_thumbnail(result: Path, path: Path, given: Sequence[Path] = ()) -> None:
    """A JPEG of what a command made, else of a recording that was `given`; none where there is nothing to show."""
    picture = _of_mesh(result)
    for look, place in ((_of_depth, result), (_of_page, result), *((_of_depth, one) for one in given)):
        picture = look(place) if picture is None else picture
    if picture is None:
        return
    scale = min(WIDTH / picture.shape[1], HEIGHT / picture.shape[0])
    size = (max(1, round(picture.shape[1] * scale)), max(1, round(picture.shape[0] * scale)))
    small = cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
    with atomic_file(path) as partial:
        partial.write_bytes(cv2.imencode(".jpg", small, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])[1].tobytes())


def _of_mesh(result: Path) -> NDArray[np.uint8] | None:
    path = result / "mesh.ply" if result.is_dir() else result
    if path.suffix != ".ply" or not path.is_file():
        return None
    from fusion.mesh.drawing.shading import png
    from fusion.mesh.files import read_mesh

    try:
        mesh = read_mesh(path)
        made = png(mesh) if 0 < len(mesh.faces) <= MANY else None
    except FusionError:
        return None
    return None if made is None else _on_white(made)


def _of_depth(result: Path) -> NDArray[np.uint8] | None:
    """The first depth image of a recording: near is bright."""
    if not (result / "depth.txt").is_file():
        return None
    from fusion.recording.open import open_recording

    try:
        depth = open_recording(result)[0].depth
    except FusionError:
        return None
    known = np.isfinite(depth)
    if not known.any():
        return None
    low, high = np.percentile(depth[known], [2, 98])
    share = (high - np.nan_to_num(depth, nan=high)) / max(high - low, 1e-6)
    grey = np.where(known, 40 + 215 * np.clip(share, 0, 1), 0).astype(np.uint8)
    return np.asarray(cv2.applyColorMap(grey, cv2.COLORMAP_BONE), np.uint8)


def _of_page(result: Path) -> NDArray[np.uint8] | None:
    page = result / "report.html"
    if not page.is_file():
        return None
    found = PICTURE.search(page.read_bytes())
    return None if found is None else _on_white(base64.b64decode(found[1] + b"=="))


def _on_white(data: bytes) -> NDArray[np.uint8] | None:
    image = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    if image is None:
        return None
    if image.ndim == 2:
        return np.asarray(np.repeat(image[..., None], 3, axis=2), np.uint8)
    if image.shape[2] == 3:
        return np.asarray(image, np.uint8)
    share = image[..., 3:].astype(np.float32) / 255
    return np.asarray(np.round(image[..., :3] * share + 255 * (1 - share)), np.uint8)
