"""How fast bags and Azure's `.mkv` are opened and read: 20 000 frames opened, large ones read in turn, on one core.

python tools/benchmark_bags.py [FOLDER]      some 900 MB in FOLDER for a while, half a minute
"""

import json
import struct
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests" / "recording"))
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests" / "recording" / "bags"))

import box_scene
import matroska
import ros_bags

from fusion.recording.open import open_recording

KINDS = ("ros1", "sqlite3", "mcap", "mcap-packed")
MANY, SOME = 20_000, 200
LARGE, LARGE_LENGTHS = (640, 480), (575.0, 575.0, 319.5, 239.5)
BINNED, UNBINNED = (320, 288), (640, 576)  # modes of Azure Kinect


def written(path: Path, kind: str, count: int, size: tuple[int, int], lengths: tuple) -> Path:
    """A bag of this many frames of the scene with a pose each."""
    rng = np.random.default_rng(1)
    clean = np.rint(box_scene.depth(box_scene.rays(*size, *lengths)) * 1000)
    images = [(clean + rng.normal(0, 2, clean.shape)).astype(np.uint16) for _ in range(8)]
    out = ros_bags.Writer(path, kind)
    for index in range(count):
        seconds = ros_bags.START + index / 30
        out.transform("/tf", "world", "d", (index * 1e-5, 0, 0, 0, 0, 0, 1), seconds)
        if index == 0:
            out.info("/d/camera_info", size, lengths, seconds, "d")
        out.image("/d/image_raw", images[index % 8], "16UC1", seconds, "d")
    out.bag.close()
    return path


def written_mkv(path: Path, count: int, size: tuple[int, int]) -> Path:
    """A Matroska file of this many frames; images behind the first eight are holes of the file, which cost no disk."""
    calibration = json.loads(
        (Path(box_scene.__file__).parent / "samples" / "azure_pixels.json").read_text(encoding="utf-8")
    )["calibration"]
    clean = np.rint(box_scene.depth(box_scene.rays(*size, size[0], size[0], size[0] / 2, size[1] / 2)) * 1000)
    rng = np.random.default_rng(1)
    images = [(clean + rng.normal(0, 2, clean.shape)).astype(">u2").tobytes() for _ in range(8)]
    heads = matroska.heads([(1, "DEPTH", "b16g", *size)], calibration)
    with path.open("wb") as file:
        file.write(matroska.matroska(heads, [], unknown=True))
        for index in range(count):
            file.write(bytes.fromhex("1F43B675") + matroska.size(None))
            file.write(matroska.element("E7", matroska.whole(33_333 * index)))
            file.write(bytes.fromhex("A3") + matroska.size(4 + len(images[0])) + b"\x81" + struct.pack(">hB", 0, 0))
            if index < len(images) or count == SOME:
                file.write(images[index % len(images)])
            else:
                file.seek(len(images[0]), 1)
        file.truncate()
    return path


def opened(path: Path, poses: bool) -> float:
    """[s] that opening takes."""
    begin = time.perf_counter()
    recording = open_recording(path)
    seconds = time.perf_counter() - begin
    assert len(recording) == MANY and (recording.poses is not None) == poses
    return seconds


def rate(path: Path) -> float:
    """Frames that are read in a second."""
    some = open_recording(path)
    begin = time.perf_counter()
    for _ in some:
        pass
    return len(some) / (time.perf_counter() - begin)


def main() -> None:
    """Print one line for each kind of file."""
    with tempfile.TemporaryDirectory(dir=sys.argv[1] if len(sys.argv) > 1 else None) as folder:
        for kind in KINDS:
            many = written(Path(folder) / f"many_{kind}", kind, MANY, (16, 12), (15.0, 15.0, 7.5, 5.5))
            some = written(Path(folder) / f"some_{kind}", kind, SOME, LARGE, LARGE_LENGTHS)
            told(kind, f"{MANY} frames with poses", opened(many, poses=True), LARGE, rate(some))
        many = written_mkv(Path(folder) / "many.mkv", MANY, BINNED)
        some = written_mkv(Path(folder) / "some.mkv", SOME, UNBINNED)
        told("azure-mkv", f"{MANY} frames", opened(many, poses=False), UNBINNED, rate(some))


def told(kind: str, frames: str, seconds: float, size: tuple[int, int], rate: float) -> None:
    """One line."""
    width, height = size
    print(f"{kind:12s} {frames} opened in {seconds:.2f} s; {rate:.0f} frames of {width} x {height} a second")


if __name__ == "__main__":
    main()
