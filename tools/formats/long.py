"""20 000 frames of each format: seconds to open, memory beside that of 2 000; and large frames read in turn.

Images are as small as the format allows; where it fixes them they are links to, or repeats of, a few.
"""

import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from tools.formats import files, folders
from tools.formats.boxes import ramp, taken, way
from tools.formats.cases import KINECT2, LARGE, foxglove, intel, of
from tools.formats.take import Lens, Take
from tools.formats.writers import azure, openni, orbbec, phones, ros, xef
from tools.formats.writers.programs import Tools

FEW, MANY, SPREAD, SOME = 2_000, 20_000, 200, 200
SMALL = Lens(16, 12, 14.5, 14.25, 7.25, 5.75)
BINNED = "NFOV_2X2BINNED"
Write = Callable[[Take, Path], Path]


@dataclass(frozen=True)
class Row:
    """Opening [s of processor time], growth of the peak memory [MB] from 2 000 to 20 000 frames, frames a second."""

    format: str
    image: str
    frames: int
    open_s: float
    open_mb: float
    growth_mb: float
    rate: float
    told: str = ""


def take(lens: Lens, count: int) -> Take:
    """Four pictures of the scene again and again; large ones are held once, and have noise of a millimetre."""
    few = taken(lens)
    large, index = lens.width > SMALL.width, np.arange(count) % 4
    poses = np.repeat(way(1), count, axis=0)
    poses[:, 0, 3] += 1e-4 * np.arange(count)
    color = None if large else np.stack([ramp(lens, 0)])[np.zeros(count, int)]
    noise = np.random.default_rng(1).normal(0, 0.001, few.depth.shape)
    depth = few.depth + noise * (few.depth > 0) if large else few.depth[index]
    return Take(lens, depth, 12.5 + np.arange(count) / 30, color, lens, poses=poses)


def linked(write: Write, lens: Lens, lists: str = "") -> Write:
    """Folders of large images: four are written, the others are links to them."""

    def writer(whole: Take, path: Path) -> Path:
        few = taken(lens, still=True)
        write(few, path)
        made = sorted(entry for entry in path.iterdir() if entry.suffix in (".bin", ".pgm"))
        names = []
        for i in range(len(whole.stamps)):
            old = made[i % len(made)]
            new = f"d-{1_400_000_000 + i / 30:.6f}-{i}.pgm" if lists else f"frame{i:06d}{old.suffix}"
            os.link(old, path / new)
            names.append(new)
        for old in made:
            old.unlink()
        if lists:
            (path / lists).write_text("\n".join([*names, ""]), encoding="utf-8")
        return path

    return writer


def kinds(tools: Tools) -> list[tuple[str, Lens, Write, str | None]]:
    """Name, camera, writer, what is said with --camera."""
    said = of(SMALL)
    out: list[tuple[str, Lens, Write, str | None]] = [
        ("native", SMALL, folders.native, None),
        ("TUM RGB-D", SMALL, folders.tum, said),
        ("7-Scenes", SMALL, folders.seven_scenes, camera_file(SMALL)),
        ("BOP", SMALL, folders.bop, None),
        ("fakenect", LARGE, linked(files.fakenect, LARGE, "INDEX.txt"), None),
        ("Open3D", SMALL, folders.open3d, None),
        ("Orbbec .bag", SMALL, orbbec.bag, None),
        ("ROS 1 .bag", SMALL, partial(ros.bag, kind="ros1"), None),
        ("ROS 2 SQLite", SMALL, partial(ros.bag, kind="sqlite3"), None),
        ("ROS 2 MCAP", SMALL, partial(ros.bag, kind="mcap"), None),
        ("nerfstudio", SMALL, folders.nerfstudio, None),
        ("Record3D .r3d", SMALL, phones.record3d, None),
        ("Polycam raw", SMALL, phones.polycam, None),
        ("Stray Scanner", SMALL, without_color(phones.stray), None),
        ("ScanNet .sens", SMALL, files.sens, None),
        (".klg", LARGE, flat(files.klg), of(LARGE)),
        ("Kinect .xef archived", KINECT2, flat(partial(xef.write, archived=True)), of(KINECT2)),
        ("libfreenect2", KINECT2, linked(files.freenect2, KINECT2), None),
        ("plain PNG", SMALL, folders.plain, said),
        ("plain NPY", SMALL, folders.arrays, said),
    ]
    if tools.bag is not None:
        out.append(("RealSense .bag", SMALL, partial(intel, python=tools.bag, ending=".bag", words=("fast",)), None))
    if tools.db3 is not None:
        out.append(("RealSense .db3", SMALL, partial(intel, python=tools.db3, ending=".db3", words=("fast",)), None))
    if tools.mcap is not None:
        out.append(("bare MCAP", SMALL, partial(foxglove, python=tools.mcap), None))
    if tools.oni is not None:
        out.append((".oni", SMALL, partial(openni.write, root=tools.oni, fast=True), said))
    if tools.k4a is not None:
        write = partial(mkv, libraries=tools.k4a, mode=BINNED)
        out.append(("Azure .mkv", azure.stated(BINNED), write, None))
    return out


def without_color(write: Write) -> Write:
    """No video: it would be larger than all else."""
    return lambda take, path: write(replace(take, color=None), path)


def flat(write: Write) -> Write:
    """Depth of one value, which packs small."""

    def writer(whole: Take, path: Path) -> Path:
        even = np.ones((4, whole.lens.height, whole.lens.width))
        return write(replace(whole, depth=even, color=np.full((*even.shape, 3), 9, np.uint8)), path)

    return writer


def camera_file(lens: Lens) -> str:
    """A camera.json: formats with a usual size take another one from it alone."""
    with tempfile.NamedTemporaryFile("w", encoding="utf-8", suffix=".json", delete=False) as file:
        told = {"width": lens.width, "height": lens.height, "fx": lens.fx, "fy": lens.fy, "cx": lens.cx, "cy": lens.cy}
        json.dump(told | {"depth_scale": 1000}, file)
    return file.name


def mkv(take: Take, path: Path, libraries: Path, mode: str) -> Path:
    """Depth alone."""
    return azure.write(take, path.with_suffix(".mkv"), libraries, mode, infrared=False)


def judged(tools: Tools, work: Path, seed: int) -> list[Row]:
    """One row for each format; files are taken away at once."""
    rows = []
    for name, lens, write, said in kinds(tools):
        if tools.only not in name:
            continue
        found = [measured(write, lens, count, said, work) for count in (FEW, MANY)]
        rows.append(row(name, lens, found))
        print(line(rows[-1]), flush=True)
    return rows + rates(tools, work)


def measured(write: Write, lens: Lens, count: int, said: str | None, work: Path, spread: int = SPREAD) -> dict | str:
    """What tools/formats/opening.py says of a recording of so many frames."""
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True)
    try:
        path = write(take(lens, count), work / "x")
        call = [sys.executable, str(Path(__file__).with_name("opening.py")), str(path), said or "-", str(spread)]
        done = subprocess.run(call, capture_output=True, text=True, check=True)
        return dict(json.loads(done.stdout))
    except subprocess.CalledProcessError as error:
        return (error.stderr or str(error)).strip().splitlines()[-1]
    finally:
        shutil.rmtree(work, ignore_errors=True)


def row(name: str, lens: Lens, found: list[dict | str]) -> Row:
    """Of 2 000 and 20 000 frames, or of large ones alone."""
    size, last = f"{lens.width} x {lens.height}", found[-1]
    if isinstance(last, str) or isinstance(found[0], str):
        return Row(name, size, 0, np.nan, np.nan, np.nan, np.nan, str(last))
    growth = last["all_mb"] - found[0]["all_mb"]
    return Row(name, size, last["frames"], last["cpu_s"], last["open_mb"], growth, last["rate"])


def rates(tools: Tools, work: Path) -> list[Row]:
    """Depth of 640 x 480 (640 x 576 in .mkv) read in turn."""
    wide = "NFOV_UNBINNED"
    some: list[tuple[str, Lens, Any]] = [
        ("Kinect .xef", KINECT2, xef.write),
        ("RealSense .bag", LARGE, tools.bag and partial(intel, python=tools.bag, ending=".bag", words=())),
        ("RealSense .db3", LARGE, tools.db3 and partial(intel, python=tools.db3, ending=".db3", words=())),
        ("ROS 1 .bag", LARGE, partial(ros.bag, kind="ros1")),
        ("ROS 2 MCAP", LARGE, partial(ros.bag, kind="mcap")),
        ("bare MCAP", LARGE, tools.mcap and partial(foxglove, python=tools.mcap)),
        ("Record3D .r3d", LARGE, phones.record3d),
        ("Azure .mkv", azure.stated(wide), tools.k4a and partial(mkv, libraries=tools.k4a, mode=wide)),
    ]  # fmt: skip
    rows = []
    for name, lens, write in some:
        if write is not None and tools.only in name:
            rows.append(row(f"{name}, large", lens, [measured(write, lens, SOME, None, work)]))
            print(line(rows[-1]), flush=True)
    return rows


HEAD = f"{'format':22s} {'image':>10s} {'frames':>7s} {'open s':>7s} {'open MB':>8s} {'growth MB':>9s} {'frames/s':>9s}"


def line(row: Row) -> str:
    """As text."""
    begin = f"{row.format:22s} {row.image:>10s} {row.frames:7d} {row.open_s:7.2f} {row.open_mb:8.1f}"
    return f"{begin} {row.growth_mb:9.1f} {row.rate:9.0f} {row.told}"
