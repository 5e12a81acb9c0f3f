"""How fast bags, Azure's `.mkv` and Record3D's `.r3d` are opened and read: 20 000 frames opened, large ones read in
turn; by processor time, so that others on the machine change little.

python -m tools.benchmarks.bags [FOLDER]    some 900 MB in FOLDER for a while, a minute
"""

import json
import struct
import sys
import tempfile
import time
import zipfile
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests" / "recording"))
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests" / "recording" / "bags"))

import box_scene
import cv2
import lzfse
import matroska
import ros_bags
from test_rvl import packed

from fusion.recording.open import open_recording

KINDS = ("ros1", "sqlite3", "mcap", "mcap-packed")
CODECS = ("png", "rvl")
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


def written_packed(path: Path, codec: str) -> Path:
    """A bag of large frames, each packed by itself, with a fiftieth of the pixels missing."""
    clean = np.rint(box_scene.depth(box_scene.rays(*LARGE, *LARGE_LENGTHS)) * 1000)
    images: list[bytes] = []
    for image in noisy(clean, 4, np.uint16):
        if codec == "png":
            images.append(bytes(12) + cv2.imencode(".png", image)[1].tobytes())
        else:
            images.append(struct.pack("<iffII", 0, 0.0, 0.0, *LARGE) + packed(image))
    out = ros_bags.Writer(path, "mcap")
    for index in range(SOME):
        seconds = ros_bags.START + index / 30
        out.info("/d/camera_info", LARGE, LARGE_LENGTHS, seconds, "d")
        form = f"16UC1; compressedDepth {codec}"
        out.packed("/d/image_raw/compressedDepth", images[index % 4], form, seconds, "d")
    out.bag.close()
    return path


def noisy(clean: np.ndarray, count: int, kind: type) -> list[np.ndarray]:
    """Images with noise of 2 counts, a fiftieth of the pixels missing."""
    rng = np.random.default_rng(1)
    images: list[np.ndarray] = [(clean + rng.normal(0, 2, clean.shape)).astype(kind) for _ in range(count)]
    return [np.where(rng.random(clean.shape) < 0.02, 0, image).astype(kind) for image in images]


def written_r3d(path: Path, count: int, size: tuple[int, int]) -> Path:
    """An archive of this many frames, depth and confidence packed by LZFSE; images behind the first four are theirs."""
    clean = box_scene.depth(box_scene.rays(*size, size[0], size[0], size[0] / 2, size[1] / 2))
    images = [lzfse.compress((image / 1000).astype("<f4").tobytes()) for image in noisy(1000 * clean, 4, np.float32)]
    sure = lzfse.compress(np.full(size[::-1], 2, np.uint8).tobytes())
    fx = float(size[0])
    told = {"w": size[0], "h": size[1], "dw": size[0], "dh": size[1], "fps": 30, "frameTimestamps": [],
            "K": [fx, 0, 0, 0, fx, 0, size[0] / 2, size[1] / 2, 1],
            "poses": [[0, 0, 0, 1, 1e-4 * n, 0, 0] for n in range(count)]}  # fmt: skip
    told["frameTimestamps"] = [n / 30 for n in range(count)]
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("metadata", json.dumps(told))
        for n in range(count):
            archive.writestr(f"rgbd/{n}.depth", images[n % 4])
            archive.writestr(f"rgbd/{n}.conf", sure)
    return path


def written_mkv(path: Path, count: int, size: tuple[int, int]) -> Path:
    """A Matroska file of this many frames; images behind the first eight are holes of the file, which cost no disk."""
    calibration = json.loads(
        (Path(box_scene.__file__).parents[1] / "samples" / "azure_pixels.json").read_text(encoding="utf-8")
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
    begin = time.process_time()
    recording = open_recording(path)
    seconds = time.process_time() - begin
    assert len(recording) == MANY and (recording.poses is not None) == poses
    return seconds


def rate(path: Path) -> float:
    """Frames that are read in a second."""
    some = open_recording(path)
    some[0]  # what comes once, such as a kernel that is loaded
    begin = time.process_time()
    for _ in some:
        pass
    return len(some) / (time.process_time() - begin)


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
        many = written_r3d(Path(folder) / "many.r3d", MANY, (16, 12))
        some = written_r3d(Path(folder) / "some.r3d", SOME, LARGE)
        told("record3d", f"{MANY} frames with poses", opened(many, poses=True), LARGE, rate(some))
        for codec in CODECS:
            told(f"mcap, {codec}", "", 0.0, LARGE, rate(written_packed(Path(folder) / codec, codec)))


def told(kind: str, frames: str, seconds: float, size: tuple[int, int], rate: float) -> None:
    """One line."""
    width, height = size
    begin = f"{frames} opened in {seconds:.2f} s; " if frames else ""
    print(f"{kind:12s} {begin}{rate:.0f} frames of {width} x {height} a second")


if __name__ == "__main__":
    main()
