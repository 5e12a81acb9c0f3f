"""Recordings that are one file: bags, sensor streams; cut, with bytes changed, with sizes that lie, and none at all.

Samples of the makers' own recorders lie with the tests of their readers; `.sens` and `.klg` are written here from
their published layouts.
"""

import gzip
import lzma
import struct
import zlib
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from broken import bases
from broken.case import ACCEPTED, EITHER, REFUSED, Case, Expected
from broken.crossing import outside

SAMPLES = Path(__file__).resolve().parent.parent.parent / "recording"
CUTS = (0.0, 0.01, 0.2, 0.5, 0.9, 0.999)
CHANGES = 12  # places at which bytes are changed, drawn with a seed
RUNS = {"convert": ["convert", "FILE", "out"], "info": ["info", "FILE"]}
SIZES = {".klg": {"width": 640, "height": 480}, ".oni": {"width": 320, "height": 240}}
HUGE = b"\xff\xff\xff\x7f"


def cases() -> Iterator[Case]:
    """Every case of files that are recordings."""
    for name, content, more in good():
        yield from _over(name, "good", content, more, ACCEPTED, quick=True)
        for share in CUTS:
            right = REFUSED if share <= CUTS[1] else EITHER
            yield from _over(name, f"cut at {share:.1%}", content[: int(share * len(content))], more, right)
        rng = np.random.default_rng(len(content))
        for k in range(CHANGES):
            at = int(rng.integers(0, min(len(content) - 4, 4000 if k % 2 else len(content) - 4)))
            for word, bytes_ in (("noise", rng.bytes(4)), ("a huge number", HUGE)):
                changed = content[:at] + bytes_ + content[at + 4 :]
                yield from _over(name, f"{word} in place {k}", changed, more, EITHER, quick=k == 1)
        yield from _over(name, "twice", content + content, more, EITHER)
        yield from _over(name, "zeros behind its head", content[:64] + bytes(len(content)), more, EITHER)


def good() -> Iterator[tuple[str, bytes, list[str]]]:
    """Name, content, and further words of each kind of file."""
    for name in ("bags/realsense_2_56.bag", "bags/realsense_2_59.db3", "samples/openni2_dummy.oni"):
        more = ["--camera", "camera.json"] if name.endswith(".oni") else []
        yield Path(name).name, (SAMPLES / name).read_bytes(), more
    yield "azure.mkv", gzip.decompress((SAMPLES / "samples/azure_box.mkv.gz").read_bytes()), []
    yield "room.sens", _sens(), []
    yield "room.klg", _klg(), ["--camera", "camera.json"]
    yield "room_Depth.dat", _xef_depth(), []
    for kind in ("plain", "archived"):
        yield f"{kind}.xef", lzma.decompress((SAMPLES / f"samples/kinect_studio_{kind}.xef.xz").read_bytes()), []


def _over(
    name: str, broken: str, content: bytes, more: list[str], expected: Expected, quick: bool = False
) -> Iterator[Case]:
    for run, words in RUNS.items():

        def make(place: Path, words: list[str] = words) -> list[str]:
            outside(place)
            (place / name).write_bytes(content)
            bases.write_json(place / "camera.json", bases.CAMERA | SIZES.get(Path(name).suffix, {}))
            return [name if word == "FILE" else word for word in words] + more

        right = expected if run == "convert" else EITHER
        where = (name,) if right is REFUSED else ()
        yield Case(f"{name}: {broken}: {run}", make, right, where, quick=quick and run == "convert")


def _plane(rows: int, columns: int) -> bytes:
    return np.full((rows, columns), 1200, "<u2").tobytes()


def _sens() -> bytes:
    """ScanNet's stream of two frames: version, name, four matrices, compressions, sizes, unit, frames, no IMU."""
    turn = np.eye(4, dtype="<f4")
    lens = turn.copy()
    lens[0, 0] = lens[1, 1] = 140.0
    lens[0, 2], lens[1, 2] = 79.5, 59.5
    head = struct.pack("<IQ", 4, 4) + b"room" + lens.tobytes() + turn.tobytes() + lens.tobytes() + turn.tobytes()
    head += struct.pack("<iiIIIIfQ", 2, 1, 160, 120, 160, 120, 1000.0, 2)
    depth = zlib.compress(_plane(120, 160))
    for stamp in (0, 33_000):
        head += turn.tobytes() + struct.pack("<QQQQ", stamp, stamp, 0, len(depth)) + depth
    return head + struct.pack("<Q", 0)


def _xef_depth() -> bytes:
    """As XEFExtract writes it: its head, then a number and 512 x 424 millimetres for each of two frames."""
    depth = np.tile(np.arange(600, 1112, dtype="<u2"), (424, 1)).tobytes()
    frames = b"".join(struct.pack("<q", k) + depth for k in range(2))
    return struct.pack("<qIII", 2, 512, 424, len(depth)) + frames


def _klg() -> bytes:
    """Logger2's file of two frames: count, then stamp [us], sizes of depth and picture, and these."""
    depth = zlib.compress(_plane(480, 640))
    frames = [struct.pack("<qii", stamp, len(depth), 0) + depth for stamp in (1_000_000, 1_033_000)]
    return struct.pack("<i", 2) + b"".join(frames)
