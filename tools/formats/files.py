"""Single files and dumps without a library: ScanNet's .sens, .klg, fakenect's and libfreenect2's dumps."""

import json
import struct
import zlib
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tools.formats.take import Array, Take
from tools.formats.writers.phones import jpeg

# of a Kinect v1, centimetres, as libfreenect reads them from it
EMITTER_CM, REFERENCE_CM, PIXEL_CM, CONST_SHIFT, NO_RAW = 7.5, 120.0, 0.1042, 200, 2047
FREENECT2 = (512, 424)


def sens(take: Take, path: Path) -> Path:
    """ScanNet's SensReader (c++/sensorData.h), version 4: colour JPEG, depth by zlib in millimetres."""
    assert take.color is not None and take.poses is not None
    K = np.eye(4, dtype="<f4")
    K[:3, :3] = take.lens.matrix
    head = struct.pack("<IQ", 4, 5) + b"judge"
    head += b"".join(m.tobytes() for m in (K, np.eye(4, dtype="<f4"), K, np.eye(4, dtype="<f4")))
    w, h = take.lens.width, take.lens.height
    head += struct.pack("<iiIIIIfQ", 2, 1, w, h, w, h, 1 / take.unit, len(take.depth))
    with path.open("wb") as file:
        file.write(head)
        for i, counts in enumerate(take.counts()):
            picture, packed = jpeg(take.color[i]), zlib.compress(counts.astype("<u2").tobytes())
            us = round(take.stamps[i] * 1e6)
            file.write(take.poses[i].astype("<f4").tobytes() + struct.pack("<QQQQ", us, us, len(picture), len(packed)))
            file.write(picture + packed)
    return path


def klg(take: Take, path: Path) -> Path:
    """Logger2 (github mp3guy/Logger2, README): depth millimetres by zlib, JPEG; 640 x 480."""
    assert take.color is not None
    parts = [
        (zlib.compress(z.astype("<u2").tobytes()), jpeg(c)) for z, c in zip(take.counts(0.001), take.color, strict=True)
    ]
    with path.open("wb") as file:
        file.write(struct.pack("<i", len(take.stamps)))
        for i, stamp in enumerate(take.stamps):
            depth, picture = parts[i % len(parts)]
            file.write(struct.pack("<qii", round(stamp * 1e6), len(depth), len(picture)) + depth + picture)
    return path


def fakenect(take: Take, path: Path) -> Path:
    """fakenect-record's folder (libfreenect, fakenect/record.c): 11-bit values, device.json with the unit's numbers."""
    assert take.color is not None
    path.mkdir(parents=True)
    names = []
    for i, raw in enumerate(raw_of(take.depth)):
        stamp = f"{1_400_000_000 + take.stamps[i]:.6f}-{round(take.stamps[i] * 60e6) % 2**32}"
        names += [f"d-{stamp}.pgm", f"r-{stamp}.ppm"]
        (path / names[-2]).write_bytes(b"P5 640 480 65535\n" + raw.astype("<u2").tobytes())
        (path / names[-1]).write_bytes(b"P6 640 480 255\n" + take.color[i].tobytes())
    (path / "INDEX.txt").write_text("\n".join([*names, ""]), encoding="utf-8")
    plane = {"dcmos_emitter_distance": EMITTER_CM, "dcmos_rcmos_distance": 2.4, "reference_distance": REFERENCE_CM}
    told = {"reg_info": {"zero_plane_info": plane | {"reference_pixel_size": PIXEL_CM}}, "const_shift": CONST_SHIFT}
    (path / "device.json").write_text(json.dumps(told), encoding="utf-8")
    return path


def raw_of(depth: NDArray[np.floating]) -> Array:
    """libfreenect's freenect_raw_to_mm turned round, to the nearest value; none of it where there is no depth."""
    with np.errstate(divide="ignore"):
        m = EMITTER_CM - REFERENCE_CM * EMITTER_CM / (100 * depth)
        raw = 4 * (m / PIXEL_CM + 0.375) + 4 * CONST_SHIFT
    return np.asarray(np.where(depth > 0, np.clip(np.rint(np.nan_to_num(raw, neginf=0)), 0, NO_RAW), NO_RAW))


def freenect2(take: Take, path: Path) -> Path:
    """Dumps of libfreenect2's Frame.data: float32 millimetres, mirrored as its camera gives them."""
    path.mkdir(parents=True)
    for i, z in enumerate(take.depth):
        (path / f"{i}.bin").write_bytes(np.ascontiguousarray(1000 * z[:, ::-1]).astype("<f4").tobytes())
    return path
