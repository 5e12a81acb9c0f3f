"""What `fusion info` tells of samples with planted faults: three frames lost, a clock set back; and of settings.

Each format is written three times: whole, without frames 5, 9 and 14 of 24, and with a clock that goes back by 2 s
before frame 12. What it tells more than of the whole one is shown.
"""

import json
import shutil
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from tools.formats import files, folders
from tools.formats.boxes import taken
from tools.formats.cases import KINECT2, LARGE, PLAIN, apart, intel, of
from tools.formats.cases import SIX as COLOR
from tools.formats.take import Lens, Take
from tools.formats.writers import azure, openni, orbbec, phones, ros, xef
from tools.formats.writers.programs import Tools

FRAMES, LOST, BACK_AT, BACK_S = 24, (5, 9, 14), 12, -2.0
START_S = 12.5
HALF = Lens(160, 120, 143.75, 145.625, 70.5, 64.0)


@dataclass(frozen=True)
class Row:
    """New sentences of `fusion info` for each fault ("" where it is silent), and the settings that it shows."""

    format: str
    planted: str
    frames: int
    told: tuple[str, ...]
    settings: str


Write = Callable[[Take, Path], Path]


def kinds(tools: Tools) -> list[tuple[str, Lens, Write, str | None]]:
    """Formats with a clock."""
    out: list[tuple[str, Lens, Write, str | None]] = [
        ("native", HALF, folders.native, None),
        ("TUM RGB-D", HALF, folders.tum, of(HALF)),
        ("fakenect", LARGE, files.fakenect, of(LARGE)),
        ("Open3D", HALF, folders.open3d, None),
        ("Orbbec .bag", HALF, lambda take, path: orbbec.bag(apart(take, COLOR), path), None),
        ("ROS 1 .bag", HALF, partial(ros.bag, kind="ros1"), None),
        ("ROS 2 MCAP", HALF, partial(ros.bag, kind="mcap"), None),
        ("Record3D .r3d", HALF, phones.record3d, None),
        ("Polycam raw", HALF, phones.polycam, None),
        ("Stray Scanner", HALF, lambda take, path: phones.stray(replace(take, color=None), path), None),
        ("ScanNet .sens", HALF, files.sens, None),
        (".klg", LARGE, files.klg, of(LARGE)),
        ("Kinect .xef", KINECT2, xef.write, of(KINECT2)),
    ]
    for name, python, ending in (("RealSense .bag", tools.bag, ".bag"), ("RealSense .db3", tools.db3, ".db3")):
        if python is not None:
            out.append((name, HALF, partial(intel, python=python, ending=ending, words=()), None))
    if tools.oni is not None:
        out.append((".oni", PLAIN, partial(openni.write, root=tools.oni), of(PLAIN)))
    if tools.k4a is not None:
        mode = "NFOV_2X2BINNED"
        write = partial(mkv, libraries=tools.k4a, mode=mode)
        out.append(("Azure .mkv", azure.stated(mode), write, None))
    return out


def mkv(take: Take, path: Path, libraries: Path, mode: str) -> Path:
    """By Microsoft's library."""
    return azure.write(replace(take, color=None), path.with_suffix(".mkv"), libraries, mode)


def faulty(take: Take, planted: str) -> Take:
    """The take as a camera that loses frames, or whose clock is set back, gives it."""
    if planted == "frames lost":
        kept = np.setdiff1d(np.arange(FRAMES), LOST)
        poses = None if take.poses is None else take.poses[kept]
        color = None if take.color is None else take.color[kept]
        return replace(take, depth=take.depth[kept], stamps=take.stamps[kept], color=color, poses=poses)
    if planted == "clock back":
        return replace(take, stamps=take.stamps + BACK_S * (np.arange(FRAMES) >= BACK_AT))
    return take


def judged(tools: Tools, work: Path, seed: int) -> list[Row]:
    """Three rows for each format."""
    rows = []
    for name, lens, write, said in kinds(tools):
        if tools.only not in name:
            continue
        take = taken(lens, FRAMES)
        take = replace(take, stamps=START_S + np.arange(FRAMES) / 30)
        usual: set[str] = set()
        for planted in ("nothing", "frames lost", "clock back"):
            shutil.rmtree(work, ignore_errors=True)
            work.mkdir(parents=True)
            rows.append(row(name, planted, partial(write, faulty(take, planted), work / "x"), said, usual))
            print(line(rows[-1]), flush=True)
    return rows


def row(name: str, planted: str, write: Callable[[], Path], said: str | None, usual: set[str]) -> Row:
    """One sample; what is told of the whole one is put into `usual`."""
    try:
        path = write()
    except (RuntimeError, subprocess.CalledProcessError) as error:
        return Row(name, planted, 0, (f"not written: {error}",), "")
    call = [str(Path(sys.executable).with_name("fusion")), "info", "--quick", "--json", str(path)]
    done = subprocess.run([*call, *(["--camera", said] if said else [])], capture_output=True, text=True, check=False)
    if not done.stdout.startswith("{"):
        return Row(name, planted, 0, (done.stderr.strip(),), "")
    info = json.loads(done.stdout)
    sentences = [f"{one['check']}: {one['seen']}" for one in info["findings"] if one["severity"] != "ok"]
    new = tuple(one for one in sentences if one not in usual)
    if planted == "nothing":
        usual.update(sentences)
    settings = ", ".join(f"{key} {value}" for key, value in (info.get("settings") or {}).items())
    return Row(name, planted, info["frames"], new, settings if planted == "nothing" else "")


HEAD = f"{'format':16s} {'planted':12s} {'frames':>6s} told by fusion info (of nothing planted: what it tells of all)"


def line(row: Row) -> str:
    """As text."""
    told = " | ".join(row.told) or "-"
    settings = f"\n{'':37s}settings: {row.settings or 'none shown'}" if row.planted == "nothing" else ""
    return f"{row.format:16s} {row.planted:12s} {row.frames:6d} {told}{settings}"
