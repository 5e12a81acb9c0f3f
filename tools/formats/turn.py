"""The same turn as native and through five formats: `fusion turntable` on each, distances between the meshes.

A native folder says of its camera what the file beside it says: noise, and so the weights, go by the kind of camera.
"""

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from scipy.spatial import cKDTree

from tools.formats import folders
from tools.formats.cases import KINECT2, of
from tools.formats.take import Take, save
from tools.formats.turntable import SQUARE, turn
from tools.formats.writers import azure, phones, ros, xef
from tools.formats.writers.programs import Tools, elsewhere
from tools.sets.planted.measure import Surface

MODE = "NFOV_UNBINNED"
SAMPLES = 100_000


@dataclass(frozen=True)
class Row:
    """One format beside its native recording; distances [mm] both ways, `lossy` what the format cannot hold."""

    format: str
    writer: str
    beside: str
    lossy: str
    rms_mm: float
    max_mm: float
    same: bool
    told: str


@dataclass(frozen=True)
class Way:
    """A recording of the turn: how it is written, and which native one it is compared with."""

    name: str
    writer: str
    beside: str
    write: Callable[[Path], Path]
    lossy: str = "none"
    said: str | None = None  # for --camera


def takes(tools: Tools, seed: int) -> dict[str, Take]:
    """By the native recording that each is compared with."""
    fine = turn(SQUARE, None, seed, 0.0001, flight=False)
    made = {"native": fine, "native, in mm": replace(fine, depth=fine.counts(0.001) * 0.001, unit=0.001)}
    made["kinect2"] = replace(turn(KINECT2, None, seed, 0.001, flight=True), color=None)
    if tools.k4a is not None:
        lens, rays = azure.stated(MODE), azure.rays(tools.k4a, MODE)
        made["native-azure"] = turn(lens, rays, seed, 0.001, flight=True)
        color, T = azure.color_camera()
        made["azure, colour"] = turn(lens, rays, seed, 0.001, flight=True, color=(color, T))
    return made


def ways(tools: Tools, made: dict[str, Take], work: Path) -> list[Way]:
    """All that can be written with what is there."""
    take, whole = made["native"], made["native, in mm"]
    intel = {"principle": "active_stereo", "sensor": "Intel RealSense D405"}
    phone = {"principle": "structured_light", "sensor": "iphone-truedepth"}  # depth of 640 x 480 says it
    npz = save(take, work / "turn.npz")
    out = [
        Way("native", "by its description", "native", lambda p: folders.native(take, p)),
        Way("native, again", "by its description", "native", lambda p: folders.native(take, p)),
        Way("native, in mm", "by its description", "native, in mm", lambda p: folders.native(whole, p)),
        Way("native, as D405", "by its description", "native, as D405", lambda p: folders.native(take, p, **intel)),
        Way("ROS 2 MCAP 32FC1", "mcap-ros2-support", "native",
            lambda p: elsewhere(tools.mcap, "foxglove_mcap.py", npz, p, "32FC1")),
        Way("ROS 2 MCAP 16UC1", "rosbags", "native, in mm", lambda p: ros.bag(whole, p, "mcap"), "depth in whole mm"),
        Way("ROS 1 .bag 32FC1", "rosbags", "native", lambda p: ros.bag(take, p, "ros1", "32FC1")),
        Way("RealSense .bag", "pyrealsense2 2.56.5", "native, as D405",
            lambda p: elsewhere(tools.bag, "realsense.py", npz, p.with_suffix(".bag"))),
        Way("RealSense .db3", "pyrealsense2 2.59.1", "native, as D405",
            lambda p: elsewhere(tools.db3, "realsense.py", npz, p.with_suffix(".db3"))),
        Way("native, as TrueDepth", "by its description", "native, as TrueDepth",
            lambda p: folders.native(take, p, **phone)),
        Way("Record3D .r3d TrueDepth", "zipfile, lzfse, cv2", "native, as TrueDepth",
            lambda p: phones.record3d(take, p.with_suffix(".r3d")), "colour as JPEG"),
    ]  # fmt: skip
    out += kinect_studio(made["kinect2"])
    if "native-azure" in made:
        seen, libraries = made["native-azure"], tools.k4a
        assert libraries is not None
        said = {"principle": "itof", "sensor": "Azure Kinect"}
        bare = Take(seen.lens, seen.depth, seen.stamps, unit=seen.unit)
        out.append(Way("native-azure", "by its description", "native-azure", lambda p: folders.native(bare, p, **said)))
        out.append(Way("Azure .mkv", "libk4arecord 1.4", "native-azure",
                       lambda p: azure.write(bare, p.with_suffix(".mkv"), libraries, MODE), "no colour"))  # fmt: skip
        out.append(
            Way("native-azure, colour", "by its description", "native-azure", lambda p: folders.native(seen, p, **said))
        )
        out.append(Way("Azure .mkv, colour", "libk4arecord 1.4", "native-azure, colour",
                       lambda p: azure.write(bare, p.with_suffix(".mkv"), libraries, MODE, made["azure, colour"].color),
                       "colour as JPEG, another camera's"))  # fmt: skip
    return out


def kinect_studio(take: Take) -> list[Way]:
    """Both kinds of `.xef`, without its colour, whose place it does not tell; the camera is said."""
    beside, device = "native, as Kinect v2", {"principle": "itof", "sensor": "kinect-v2"}
    made = [Way(beside, "by its description", beside, lambda p: folders.native(take, p, **device))]
    for name, archived in (("Kinect .xef", False), ("Kinect .xef archived", True)):
        write = partial(xef.write, take, archived=archived)
        made.append(Way(name, "from its description", beside, write, "no colour", of(KINECT2)))
    return made


def judged(tools: Tools, work: Path, seed: int) -> list[Row]:
    """One row each; what `fusion turntable` says on the way is kept beside."""
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True)
    meshes: dict[str, trimesh.Trimesh | None] = {}
    rows = []
    for way in ways(tools, takes(tools, seed), work):
        if tools.only not in way.name:
            continue
        place = work / way.name.replace(" ", "_").replace(",", "").replace(".", "")
        try:
            meshes[way.name], told = scanned(way.write(place), place.with_name(place.name + "_out"), way.said)
        except (OSError, subprocess.CalledProcessError) as error:
            meshes[way.name], told = None, f"not written: {error}"
        rows.append(row(way, meshes, told))
        print(line(rows[-1]), flush=True)
    return rows


def scanned(path: Path, out: Path, said: str | None = None) -> tuple[trimesh.Trimesh | None, str]:
    """Mesh of a scan and the last line of what was told."""
    command = [str(Path(sys.executable).with_name("fusion")), "turntable", str(path), "-o", str(out), "--no-report"]
    command += ["--camera", said] if said else []
    env = os.environ | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    done = subprocess.run(command, capture_output=True, text=True, env=env, check=False)
    out.with_suffix(".txt").write_text(done.stdout + done.stderr, encoding="utf-8")
    if done.returncode:
        return None, (done.stderr.strip().splitlines() or ["no mesh"])[-1]
    mesh: Any = trimesh.load(out / "mesh.ply", process=False)
    settings = json.loads((out / "turntable.json").read_text(encoding="utf-8"))
    return mesh, settings.get("verdict", "")


def row(way: Way, meshes: dict[str, trimesh.Trimesh | None], told: str) -> Row:
    """Distances of a way's mesh and that of its native recording, as they stand."""
    mine, other = meshes[way.name], meshes.get(way.beside)
    if mine is None or other is None:
        return Row(way.name, way.writer, way.beside, way.lossy, float("nan"), float("nan"), False, told)
    same = mine.vertices.shape == other.vertices.shape and bool(np.array_equal(mine.vertices, other.vertices))
    far = [Surface(b).distance(np.asarray(trimesh.sample.sample_surface(a, SAMPLES, seed=0)[0], float))
           for a, b in ((mine, other), (other, mine))]  # fmt: skip
    both = 1000 * np.concatenate(far)
    if (off := color_off(mine, other)) is not None:
        told += f"; colours {off:.1f} of 255 apart"
    rms, worst = float(np.sqrt(np.mean(both**2))), float(both.max())
    return Row(way.name, way.writer, way.beside, way.lossy, rms, worst, same, told)


def color_off(mine: trimesh.Trimesh, other: trimesh.Trimesh) -> float | None:
    """Middle difference of the colours of nearest vertices, 0 to 255; None where one has none."""
    shown: list[Any] = [mine.visual, other.visual]
    if any(one is None or one.kind != "vertex" for one in shown):
        return None
    _, at = cKDTree(other.vertices).query(mine.vertices)
    off = np.asarray(shown[0].vertex_colors, float)[:, :3] - np.asarray(shown[1].vertex_colors, float)[at, :3]
    return float(np.median(np.abs(off)))


HEAD = f"{'format':20s} {'written by':38s} {'beside':15s} {'rms mm':>8s} {'max mm':>8s} same  lossy part"


def line(row: Row) -> str:
    """As text."""
    begin = f"{row.format:20s} {row.writer:38s} {row.beside:15s} {row.rms_mm:8.4f} {row.max_mm:8.3f}"
    return f"{begin} {'yes ' if row.same else 'no  '}  {row.lossy} ({row.told})"
