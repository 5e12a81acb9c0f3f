"""A volume as a .npz file."""

import zipfile
from pathlib import Path

import numpy as np

from fusion.errors import VolumeError
from fusion.output import atomic_file
from fusion.volume.blocks import Blocks, by_row, by_voxel
from fusion.volume.settings import VOXELS, VolumeSettings

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
    try:
        with np.load(path, allow_pickle=False) as data:
            if str(data["format"]) != FORMAT:
                raise ValueError(f"format {data['format']}")
            box = data["bounds"]
            bounds = (tuple(box[0]), tuple(box[1])) if len(box) else None
            settings = VolumeSettings(
                float(data["voxel"]), float(data["truncation"]), bool(data["color"]), bounds, int(data["max_bytes"])
            )
            coordinates, voxels, colors = data["coordinates"], data["voxels"], data["colors"]
    except (OSError, KeyError, ValueError, IndexError, zipfile.BadZipFile) as error:
        raise VolumeError("not a saved volume", path, error, f"a .npz file of format {FORMAT}") from error
    n = len(coordinates)
    if coordinates.shape != (n, 3) or voxels.shape != (n, VOXELS, 2) or len(colors) != n * settings.color:
        raise VolumeError("a damaged volume", path, f"{coordinates.shape} blocks, {voxels.shape} voxels")
    blocks = Blocks(settings)
    blocks.insert(coordinates)
    blocks.voxels[:n] = by_row(voxels)
    blocks.mark(slice(n))
    if settings.color:
        blocks.colors[:n] = colors
    return blocks
