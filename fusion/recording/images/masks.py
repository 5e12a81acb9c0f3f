"""Masks of the object: one image for all frames, or one per depth frame; nonzero is the object."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fusion.errors import RecordingError
from fusion.recording.images.frame_files import associate
from fusion.recording.images.read import image_size, read_mask
from fusion.recording.looking.sample import spread
from fusion.recording.recording import Recording

LOOKED_AT = 10  # masks read at the start: are they all empty, or all full?
DO = "name each mask like its depth image or by its time stamp, or pass one PNG for all frames"


@dataclass(frozen=True)
class Masks:
    """Where the mask of each frame lies; `masks[i]` reads it."""

    files: tuple[Path, ...]  # one per frame, or a single one for all

    @property
    def moving(self) -> bool:
        """True when every frame has its own."""
        return len(self.files) > 1

    def __getitem__(self, index: int) -> NDArray[np.bool_]:
        """(height, width) True on the object. Raises RecordingError."""
        return read_mask(self.files[index if self.moving else 0])


def open_masks(path: Path, recording: Recording) -> Masks:
    """Masks for a recording.

    Args:
        path: one PNG for all frames, or a folder with one PNG per depth frame: of the same name, or named by a time
            stamp within 20 ms.

    Raises:
        RecordingError: no such path, frames without a mask, another size than the depth, nothing or everything marked.
    """
    path = Path(path)
    if path.is_file():
        masks = Masks((path,))
    elif path.is_dir():
        masks = Masks(_per_frame(path, recording))
    else:
        raise RecordingError("the mask does not exist", path, "nothing", "a PNG or a folder of PNG", DO)
    camera = recording.camera
    for file in masks.files:
        if image_size(file) != (camera.width, camera.height):
            raise RecordingError(
                "the mask has another size than the depth",
                file,
                "{} x {}".format(*image_size(file)),
                f"{camera.width} x {camera.height} pixels",
            )
    shares = [masks[i].mean() for i in spread(len(masks.files), LOOKED_AT)]
    if max(shares, default=0.0) == 0:
        raise RecordingError("the mask marks nothing", path, "only zeros", "nonzero pixels on the object")
    if min(shares) == 1:
        raise RecordingError("the mask marks everything", path, "no zero", "zero outside the object")
    return masks


def _per_frame(folder: Path, recording: Recording) -> tuple[Path, ...]:
    """The mask of each frame, by name, else by time stamp."""
    found = {file.stem: file for file in sorted(folder.glob("*.[pP][nN][gG]"))}
    if not found:
        raise RecordingError("the folder holds no mask", folder, "no PNG", "one PNG for each depth frame", DO)
    names = [Path(name).stem for name in recording.files.depth] if recording.files is not None else []
    chosen = [found.get(name) for name in names]
    if not chosen or None in chosen:
        stamped = _by_stamp(found, recording)
        chosen = stamped if stamped.count(None) < chosen.count(None) or not chosen else chosen
    missing = [index for index, file in enumerate(chosen) if file is None]
    if missing:
        first = names[missing[0]] if names else f"{recording.timestamps[missing[0]]:.6f}"
        raise RecordingError(
            "masks are missing",
            folder,
            f"none for {len(missing)} of {len(recording)} frames, the first {first}",
            "one PNG for each depth frame",
            DO,
        )
    return tuple(file for file in chosen if file is not None)


def _by_stamp(found: dict[str, Path], recording: Recording) -> list[Path | None]:
    stamps, files = [], []
    for stem, file in found.items():
        try:
            stamps.append(float(stem))
        except ValueError:
            continue
        files.append(file)
    pairs = associate(recording.timestamps, np.array(stamps))
    return [files[k] if k >= 0 else None for k in pairs]
