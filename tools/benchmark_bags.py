"""How fast bags are opened and read: 20 000 small frames opened, 640 x 480 read one after the other, on one core.

python tools/benchmark_bags.py [FOLDER]      some 600 MB in FOLDER for a while, half a minute
"""

import sys
import tempfile
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests" / "recording" / "bags"))

import box_scene
import ros_bags

from fusion.recording.open import open_recording

KINDS = ("ros1", "sqlite3", "mcap", "mcap-packed")
MANY, SOME = 20_000, 200
LARGE, LARGE_LENGTHS = (640, 480), (575.0, 575.0, 319.5, 239.5)


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


def main() -> None:
    with tempfile.TemporaryDirectory(dir=sys.argv[1] if len(sys.argv) > 1 else None) as folder:
        for kind in KINDS:
            many = written(Path(folder) / f"many_{kind}", kind, MANY, (16, 12), (15.0, 15.0, 7.5, 5.5))
            begin = time.perf_counter()
            recording = open_recording(many)
            opened = time.perf_counter() - begin
            assert len(recording) == MANY and recording.poses is not None
            some = open_recording(written(Path(folder) / f"some_{kind}", kind, SOME, LARGE, LARGE_LENGTHS))
            begin = time.perf_counter()
            for _ in some:
                pass
            rate = len(some) / (time.perf_counter() - begin)
            print(
                f"{kind:12s} {MANY} frames with poses opened in {opened:.2f} s; {rate:.0f} frames of 640 x 480 a second"
            )


if __name__ == "__main__":
    main()
