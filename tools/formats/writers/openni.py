"""A take through OpenNI2's own recorder: a driver without a camera (oni_driver.cpp) plays it to the library.

ROOT: the folder into which Debian's libopenni2-0 and libopenni2-dev were unpacked; g++ is needed.
"""

import os
import shutil
import struct
import subprocess
from pathlib import Path

import numpy as np

from tools.formats.take import Lens, Take

SOURCE = Path(__file__).with_name("oni_driver.cpp")
SECONDS = 2


def of_field(width: int, height: int, across: float, down: float) -> Lens:
    """The camera of fields of view [rad] as OpenNI2's converter has it (OniStream.cpp): x/z = (u / w - 1/2) 2 tan."""
    fx, fy = width / 2 / np.tan(across / 2), height / 2 / np.tan(down / 2)
    return Lens(width, height, float(fx), float(fy), width / 2, height / 2)


def write(take: Take, path: Path, root: Path, fast: bool = False) -> Path:
    """The recording, depth packed by its codec 16zT; of the camera it holds the field of view alone."""
    built = path.with_name(path.name + "_openni")
    made(built, root)
    lens, counts = take.lens, take.counts(0.001)
    fields = 2 * np.arctan([lens.width / 2 / lens.fx, lens.height / 2 / lens.fy])
    head = struct.pack("<3i2f", len(counts), lens.width, lens.height, *fields)
    stamps = np.rint(take.stamps * 1e6).astype("<u8").tobytes()
    (built / "frames").write_bytes(head + stamps + counts.astype("<u2").tobytes())
    out = path.with_suffix(".oni")
    pause_us = 1000 if fast else 20_000
    env = os.environ | {"JUDGE_FRAMES": str(built / "frames"), "JUDGE_PAUSE_US": str(pause_us)}
    seconds = SECONDS + round(2e-6 * pause_us * len(counts))
    subprocess.run([str(built / "record"), str(out.resolve()), str(seconds)], check=True, env=env, cwd=built)
    return out


def made(built: Path, root: Path) -> None:
    """Library, driver and program in one folder, where the library looks for drivers."""
    drivers = (built / "OpenNI2" / "Drivers").resolve()
    drivers.mkdir(parents=True)
    include = next(root.rglob("OpenNI.h")).parent
    library = next(root.rglob("libOpenNI2.so.0")).resolve()
    shutil.copy(library, built / "libOpenNI2.so.0")
    call = ["g++", "-O1", "-w", f"-I{include}", str(SOURCE)]
    subprocess.run([*call, "-shared", "-fPIC", "-o", str(drivers / "libJudge.so.0"), "-lpthread"], check=True)
    link = [str(built / "libOpenNI2.so.0"), f"-Wl,-rpath,{built.resolve()}"]
    subprocess.run([*call, "-DRECORD", "-o", str(built / "record"), *link], check=True)
