"""A volume as a .npz file."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fusion.errors import VolumeError
from fusion.files.npy import read_npz
from fusion.files.output.publish import atomic_file
from fusion.volume.blocks import Blocks, by_row, by_voxel
from fusion.volume.settings import LATTICE, VOXELS, VolumeSettings

FORMAT = "fusion-volume/1"


def save(blocks: Blocks, path: Path) -> None:
    """Write blocks and settings; the file appears whole or not at all."""
    settings, n = blocks.settings, blocks.count
    with atomic_file(path) as partial, partial.open("wb") as file:
        np.savez(
            file,
            format=FORMAT,
            voxel=settings.voxel,
            truncation=settings.truncation,
            color=settings.color,
            bounds=np.zeros((0, 3)) if settings.bounds is None else np.array(settings.bounds),
            max_bytes=settings.max_bytes,
            coordinates=blocks.coordinates[:n],
            voxels=by_voxel(blocks.voxels[:n]),
            colors=blocks.colors[: n if settings.color else 0],
        )


def load(path: Path) -> Blocks:
    """Read what `save` wrote; raises VolumeError when the file is missing or no volume."""
    data = read_npz(path, VolumeError, "the volume")
    if str(data.get("format")) != FORMAT:
        raise VolumeError("not a saved volume", path, f"format {data.get('format')}"[:60], f"format {FORMAT}")
    try:
        settings = _settings(data)
        coordinates, voxels, colors = data["coordinates"], data["voxels"], data["colors"]
    except (KeyError, ValueError, TypeError, IndexError, OverflowError) as error:
        raise VolumeError("a damaged volume", path, repr(error)[:80], "what fusion saved") from error
    n = len(coordinates) if coordinates.ndim else -1
    shapes = [array.shape for array in (coordinates, voxels, colors)]
    kinds = "".join(array.dtype.kind for array in (coordinates, voxels, colors))
    colored = (n, VOXELS, 4) if settings.color else (0, *colors.shape[1:])
    if shapes != [(n, 3), (n, VOXELS, 2), colored] or kinds != "iff":
        raise VolumeError("a damaged volume", path, f"arrays {shapes} of types {kinds}", "what fusion saved")
    if n and (np.abs(coordinates).max() >= LATTICE or len(np.unique(coordinates, axis=0)) < n):
        raise VolumeError("a damaged volume", path, "blocks in one place, or beyond all bounds", "what fusion saved")
    blocks = Blocks(settings)
    blocks.insert(coordinates.astype(np.int32))
    blocks.voxels[:n] = by_row(voxels)
    blocks.mark(slice(n))
    if settings.color:
        blocks.colors[:n] = colors
    return blocks


def _settings(data: dict[str, NDArray]) -> VolumeSettings:
    box = data["bounds"]
    bounds = (tuple(box[0]), tuple(box[1])) if len(box) else None
    return VolumeSettings(
        float(data["voxel"]), float(data["truncation"]), bool(data["color"]), bounds, int(data["max_bytes"])
    )
