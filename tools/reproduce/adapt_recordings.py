"""Make recordings of real data sets that keep a layout of their own.

    python -m tools.reproduce.adapt_recordings NAME -o REC [--shared ../shared]

NAME is `kinect_v2_floor` (one recording of 72 frames) or `checkerboard_corner` (a folder with one recording of one
frame per distance, Kinect v1). What the sets do not tell is written below and nowhere else.
"""

import argparse
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fusion.errors import FusionError
from fusion.geometry.camera import Camera, Principle
from fusion.recording.cameras.presets import find_camera
from fusion.recording.images.load_frame import counts_to_metres
from fusion.recording.images.read import read_counts
from fusion.recording.recording import Frame
from fusion.recording.writing.write import write_recording

# inferred by the set's SOURCE.md, never proven: 4500 mm at 65535
FLOOR_COUNTS_PER_METRE = 65535 / 4.5
# main.cpp of the set
CORNER_V1 = Camera(640, 480, 522.96, 523.88, 329.09, 254.71, principle=Principle.STRUCTURED_LIGHT, sensor="Kinect v1")
FRAME_S = 1 / 30  # both sensors' rate; the sets have no time stamps


def floor(data: Path, out: Path) -> list[Path]:
    """The floor under a ceiling-mounted Kinect v2, a person walking through; intrinsics are those of the preset."""
    paths = _found(data / "kinect_v2_floor", "image*.png")
    camera = replace(find_camera("kinect-v2"), depth_scale=FLOOR_COUNTS_PER_METRE)
    write_recording(out, camera, (_frame(i, path, camera) for i, path in enumerate(paths)))
    return [out]


def corner(data: Path, out: Path) -> list[Path]:
    """The checkerboard corner at five distances, one Kinect v1 frame each."""
    made = []
    for path in _found(data / "checkerboard_corner/640x480", "*_d.png"):
        made.append(out / f"corner_{path.stem.removesuffix('_d')}")
        write_recording(made[-1], CORNER_V1, [_frame(0, path, CORNER_V1)])
    return made


SETS: dict[str, Callable[[Path, Path], list[Path]]] = {"kinect_v2_floor": floor, "checkerboard_corner": corner}


def adapt(name: str, shared: Path, out: Path) -> list[Path]:
    """Write the recordings of a set; returns their folders."""
    return SETS[name](shared / "data", out)


def _found(folder: Path, pattern: str) -> list[Path]:
    paths = sorted(folder.glob(pattern))
    if not paths:
        raise FusionError("the data set is not here", folder, "nothing", pattern, "pass --shared")
    return paths


def _frame(index: int, path: Path, camera: Camera) -> Frame:
    depth: NDArray[np.float32] = counts_to_metres(read_counts(path), camera.depth_scale)
    return Frame(index, index * FRAME_S, depth)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("name", choices=SETS)
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--shared", type=Path, default=Path("../shared"))
    options = parser.parse_args()
    try:
        made = adapt(options.name, options.shared, options.output)
    except FusionError as error:
        sys.stderr.write(f"{error}\n")
        return 1
    for path in made:
        print(path)
    return 0


if __name__ == "__main__":
    sys.exit(main())
