"""A take through ScanNet's own C++ class. SOURCES: a checkout of github ScanNet/ScanNet, or its SensReader alone."""

import struct
import subprocess
from pathlib import Path

import numpy as np

from tools.formats.take import Take

PROGRAM = Path(__file__).with_name("sens_writer.cpp")


def write(take: Take, path: Path, sources: Path) -> Path:
    """Colour raw, depth packed by its zlib."""
    assert take.color is not None and take.poses is not None
    header = next(sources.rglob("sensorData.h")).parent
    built, held, out = path.with_name(path.name + "_writer"), path.with_suffix(".take"), path.with_suffix(".sens")
    subprocess.run(["g++", "-O1", "-w", f"-I{header}", str(PROGRAM), "-o", str(built), "-lpthread"], check=True)
    lens, counts = take.lens, take.counts()
    head = struct.pack("<3i5f", len(counts), lens.width, lens.height, *lens.four, 1 / take.unit)
    stamps, poses = np.rint(take.stamps * 1e6).astype("<u8"), take.poses.astype("<f4")
    images = take.color.tobytes() + counts.astype("<u2").tobytes()
    held.write_bytes(head + stamps.tobytes() + poses.tobytes() + images)
    subprocess.run([str(built), str(held), str(out)], check=True, stdout=subprocess.DEVNULL)
    return out
