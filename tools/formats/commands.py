"""Every command takes every format as it is: reconstruct, turntable and convert, once for each, on small samples.

`fusion reconstruct` on a camera that moves round the box of `boxes`, `fusion turntable` on one turn; each mesh is put
beside that of the native recording of the same take, so that a part that a format cannot hold shows itself.
"""

import shutil
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from scipy.spatial.transform import Rotation

import fusion
from tools.formats import files, folders
from tools.formats.boxes import ramp, seen
from tools.formats.cases import KINECT2, foxglove, intel, of
from tools.formats.take import Array, Lens, Take
from tools.formats.turntable import SQUARE, turn
from tools.formats.writers import azure, openni, orbbec, phones, ros, xef
from tools.formats.writers.programs import Tools
from tools.sets.planted.measure import Surface

HALF = Lens(320, 240, 302.125, 302.75, 161.25, 117.8125)
FRAMES, SAMPLES = 12, 20_000
MODE = "NFOV_2X2BINNED"
Write = Callable[[Take, Path], Path]


@dataclass(frozen=True)
class Row:
    """One format: rms [mm] to the native mesh of what it could hold, nan where a command failed; and why it did."""

    format: str
    reconstruct_mm: float
    turntable_mm: float
    frames: int
    told: str


@dataclass(frozen=True)
class Kind:
    """How a format is written, through which camera, and what a user would say with --camera."""

    name: str
    lens: Lens
    write: Write
    said: str | None = None
    rays: Array | None = None


def kinds(tools: Tools) -> list[Kind]:
    """All that can be written here."""

    out = [
        Kind("TUM RGB-D", HALF, folders.tum, of(HALF)),
        Kind("7-Scenes", HALF, lambda take, path: folders.seven_scenes(placed(take), path), of(HALF)),
        Kind("BOP", HALF, lambda take, path: folders.bop(placed(take), path)),
        Kind("fakenect", SQUARE, files.fakenect, of(SQUARE)),
        Kind("Open3D", HALF, lambda take, path: folders.open3d(placed(take), path)),
        Kind("Orbbec .bag", HALF, orbbec.bag),
        Kind("ROS 1 .bag", HALF, partial(ros.bag, kind="ros1")),
        Kind("ROS 2 SQLite", HALF, partial(ros.bag, kind="sqlite3")),
        Kind("ROS 2 MCAP", HALF, partial(ros.bag, kind="mcap")),
        Kind("nerfstudio", HALF, lambda take, path: folders.nerfstudio(placed(take), path)),
        Kind("Record3D .r3d", HALF, phones.record3d),
        Kind("Polycam raw", HALF, lambda take, path: phones.polycam(placed(take), path)),
        Kind("Stray Scanner", HALF, lambda take, path: phones.stray(replace(placed(take), color=None), path)),
        Kind("ScanNet .sens", HALF, lambda take, path: files.sens(placed(take), path)),
        Kind(".klg", SQUARE, files.klg, of(SQUARE)),
        Kind("libfreenect2", KINECT2, files.freenect2, of(KINECT2)),
        Kind("Kinect Studio .xef", KINECT2, xef.write, of(KINECT2)),
        Kind("plain PNG", HALF, folders.plain, of(HALF)),
        Kind("plain NPY", HALF, folders.arrays, of(HALF)),
    ]
    for name, python, ending in (("RealSense .bag", tools.bag, ".bag"), ("RealSense .db3", tools.db3, ".db3")):
        if python is not None:
            out.append(Kind(name, HALF, partial(intel, python=python, ending=ending, words=())))
    if tools.mcap is not None:
        out.append(Kind("bare MCAP", HALF, partial(foxglove, python=tools.mcap)))
    if tools.oni is not None:
        out.append(Kind(".oni", HALF, partial(openni.write, root=tools.oni), of(HALF)))
    if tools.k4a is not None:
        out.append(Kind("Azure .mkv", azure.stated(MODE), partial(mkv, libraries=tools.k4a), None,
                        azure.rays(tools.k4a, MODE)))  # fmt: skip
    return out


def mkv(take: Take, path: Path, libraries: Path) -> Path:
    """By Microsoft's library."""
    return azure.write(replace(take, color=None), path.with_suffix(".mkv"), libraries, MODE)


def placed(take: Take) -> Take:
    """With poses where a format must have some: of a camera that stands still."""
    return take if take.poses is not None else replace(take, poses=np.repeat(np.eye(4)[None], len(take.depth), axis=0))


def moving(lens: Lens, rays: Array | None) -> Take:
    """A hand's small steps before the box; poses are left to tracking."""
    given = lens.rays() if rays is None else rays
    blind, depth = ~np.isfinite(given[..., 0]), []
    for i in range(FRAMES):
        T = np.eye(4)
        T[:3, :3] = Rotation.from_euler("xyz", [0.6 * i, -0.8 * i, 0.4 * i], degrees=True).as_matrix()
        T[:3, 3] = [0.008 * i, -0.004 * i, 0.003 * i]
        depth.append(np.where(blind, 0, seen(np.nan_to_num(given), T)[0]))
    color = np.stack([ramp(lens, 0)] * FRAMES)
    return Take(lens, np.rint(np.stack(depth) * 1000) / 1000, 12.5 + np.arange(FRAMES) / 30, color, lens)


@cache
def _taken(lens: Lens, mode: str | None, libraries: Path | None, seed: int) -> tuple[Take, Take]:
    rays = None if mode is None or libraries is None else azure.rays(libraries, mode)
    # these two send light and time it: their noise is not a matcher's
    return moving(lens, rays), turn(lens, rays, seed, 0.001, flight=rays is not None or lens is KINECT2)


def judged(tools: Tools, work: Path, seed: int) -> list[Row]:
    """One row each."""
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True)
    native: dict[tuple, trimesh.Trimesh | None] = {}
    rows = []
    for kind in kinds(tools):
        if any(word in kind.name for word in tools.only.split(",")):
            rows.append(
                row(kind, _taken(kind.lens, None if kind.rays is None else MODE, tools.k4a, seed), work, native)
            )
            print(line(rows[-1]), flush=True)
    return rows


def row(kind: Kind, takes: tuple[Take, Take], work: Path, native: dict[tuple, Any]) -> Row:
    """Both takes through a format and through native, a mesh of each; the turn is converted and opened as well."""
    far, told, frames = {}, [], 0
    place = work / "".join(c if c.isalnum() else "_" for c in kind.name)
    for command, take in zip(("reconstruct", "turntable"), takes, strict=True):
        mesh = other = None
        try:
            path = kind.write(take, place.with_name(f"{place.name}_{command}"))
            other = beside(command, take, fusion.open_recording(path, kind.said), work, native)
            mesh, why = made(command, path, kind.said)
            told += [f"{command}: {why}"] if mesh is None else []
            if command == "turntable":
                frames = converted(path, kind.said)
        except (OSError, subprocess.CalledProcessError, fusion.FusionError) as error:
            told.append(f"{command}: {' '.join(str(error).split())}")
        far[command] = apart(mesh, other)
    return Row(kind.name, far["reconstruct"], far["turntable"], frames, "; ".join(told))


def beside(
    command: str, take: Take, recording: fusion.Recording, work: Path, native: dict[tuple, Any]
) -> trimesh.Trimesh | None:
    """The mesh of the native recording of the same kind of camera, with colour where there is some: noise, weights and
    what an object is told by go by these."""
    camera, colored = recording.camera, recording.has_color is not None and bool(recording.has_color.any())
    key = command, take.lens, camera.principle, camera.sensor, colored
    if key not in native:
        path = work / f"native_{len(native)}"
        held = take if colored else replace(take, color=None)
        folders.native(held, path, principle=camera.principle, sensor=camera.sensor)
        native[key] = made(command, path, None)[0]
    return native[key]


def made(command: str, path: Path, said: str | None) -> tuple[trimesh.Trimesh | None, str]:
    """The mesh that a command makes of a recording, and its last line where it makes none."""
    out = path.with_name(path.name + "_out")
    done = call(command, path, "-o", out, "--no-report", *(["--camera", said] if said else []))
    if done.returncode:
        return None, (done.stderr.strip().splitlines() or ["no word"])[-1]
    mesh: Any = trimesh.load(out / "mesh.ply", process=False)
    return mesh, ""


def converted(path: Path, said: str | None) -> int:
    """Frames of the native recording that it becomes."""
    out = path.with_name(path.name + "_native")
    done = call("convert", path, out, *(["--camera", said] if said else []))
    return len(fusion.open_recording(out)) if not done.returncode else 0


def call(*words: object) -> "subprocess.CompletedProcess[str]":
    """The program as a user starts it."""
    program = str(Path(sys.executable).with_name("fusion"))
    return subprocess.run([program, *map(str, words)], capture_output=True, text=True, check=False)


def apart(mesh: trimesh.Trimesh | None, other: trimesh.Trimesh | None) -> float:
    """rms [mm] from one mesh to the other."""
    if mesh is None or other is None:
        return float("nan")
    points = np.asarray(trimesh.sample.sample_surface(mesh, SAMPLES, seed=0)[0], float)
    return 1000 * float(np.sqrt(np.mean(Surface(other).distance(points) ** 2)))


HEAD = f"{'format':16s} {'reconstruct mm':>14s} {'turntable mm':>12s} {'converted':>9s} told where one failed"


def line(row: Row) -> str:
    """As text."""
    begin = f"{row.format:16s} {row.reconstruct_mm:14.4f} {row.turntable_mm:12.4f}"
    return f"{begin} {row.frames:9d} {row.told or '-'}"
