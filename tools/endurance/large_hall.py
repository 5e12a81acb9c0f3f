"""A hall or a corridor larger than memory, at 5 mm with 1 GB: time, peak memory, and equality with a volume in memory.

    python -m tools.endurance.large_hall [--scene hall|corridor] [--memory 1] [--voxel 0.005] [-o OUT]

The scene is made of boxes and seen by Open3D's ray casting, so that no line of the renderer is the package's own. Then
`fusion reconstruct --poses stated --memory` runs in a process of its own, whose largest resident memory is read, and a
part that fits into memory is reconstructed without tiles: vertices, normals and faces in it must be the same, bit for
bit. Nothing is kept but OUT, where that is given.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import open3d
from scipy.spatial.transform import Rotation

from fusion.volume.settings import BLOCK

o3d: Any = open3d  # its stubs know less than it does
SIZES = {"hall": (30.0, 30.0, 5.0), "corridor": (60.0, 2.4, 3.0)}  # [m] x, y, z; z up
WIDTH, HEIGHT, FOCAL, SCALE = 640, 480, 480.0, 2000
PART = {"hall": ((9.0, 9.0, -0.1), (13.0, 13.0, 3.0)), "corridor": ((20.0, -0.1, -0.1), (26.0, 2.5, 3.1))}  # that fits
FUSION = "import sys; from fusion.commands.console import run; sys.exit(run())"
CHUNK = 1 << 22  # faces looked at together
WITHIN = 2  # blocks inside of the part's border, where the part is as the whole


def scene_of(name: str) -> Any:
    """Floor, walls and ceiling, and boxes that stand and lie about."""
    size, rng = np.array(SIZES[name]), np.random.default_rng(7)
    boxes = [
        ((-0.1, -0.1, -0.1), (*(size[:2] + 0.1), 0.0)),
        ((-0.1, -0.1, size[2]), (*(size[:2] + 0.1), size[2] + 0.1)),
    ]
    for axis in (0, 1):
        for at in (-0.1, size[axis]):
            low, high = np.full(3, -0.1), size + 0.1
            low[axis], high[axis] = at, at + 0.1
            boxes.append((tuple(low), tuple(high)))
    count = 60 if name == "hall" else 24
    for _ in range(count):
        side = rng.uniform(0.3, 1.2 if name == "hall" else 0.5, 3)
        low = np.append(rng.uniform(0.0, size[:2] - side[:2]), 0.0)
        boxes.append((tuple(low), tuple(low + side)))
    if name == "hall":
        boxes += [((x, y, 0.0), (x + 0.4, y + 0.4, size[2])) for x in (7.0, 14.8, 22.6) for y in (7.0, 14.8, 22.6)]
    scene = o3d.t.geometry.RaycastingScene()
    for first, last in boxes:
        box = o3d.t.geometry.TriangleMesh.create_box(*(np.subtract(last, first).tolist()))
        scene.add_triangles(box.translate(list(map(float, first))))
    return scene


def views(name: str) -> list[np.ndarray]:
    """Poses `T_world_camera` (4, 4) on a grid, in all directions, up and down."""
    size = np.array(SIZES[name])
    step = 6.0 if name == "hall" else 3.0
    places = [
        (x, y)
        for x in np.arange(2.5, size[0], step)
        for y in (np.arange(2.5, size[1], step) if name == "hall" else [1.2])
    ]
    found = []
    for x, y in places:
        for yaw in np.arange(0, 360, 45.0):
            for pitch in (-35.0, 0.0, 30.0):
                # camera axes (x right, y down, z forward) in a world whose z is up
                turned = Rotation.from_euler("xz", [-90.0 + pitch, yaw], degrees=True).as_matrix()
                T = np.eye(4)
                T[:3, :3], T[:3, 3] = turned, (x + 0.013, y + 0.007, 1.7)
                found.append(T)
    return found


def write(name: str, folder: Path) -> int:
    """A recording in the native format; its number of frames."""
    scene, poses = scene_of(name), views(name)
    (folder / "depth").mkdir(parents=True)
    v, u = np.mgrid[:HEIGHT, :WIDTH]
    rays = np.stack([(u - WIDTH / 2 + 0.5) / FOCAL, (v - HEIGHT / 2 + 0.5) / FOCAL, np.ones(u.shape)], axis=-1)
    lists, truth = [], []
    for index, T in enumerate(poses):
        directions = rays @ T[:3, :3].T
        both = np.concatenate([np.broadcast_to(T[:3, 3], rays.shape), directions], axis=-1).astype(np.float32)
        depth = scene.cast_rays(o3d.core.Tensor(both))["t_hit"].numpy()  # z is 1 in the camera: t is planar depth
        counts = np.where(np.isfinite(depth), np.rint(depth * SCALE), 0).astype(np.uint16)
        cv2.imwrite(str(folder / "depth" / f"{index:06d}.png"), counts)
        stamp = f"{index / 10:.4f}"
        lists.append(f"{stamp} depth/{index:06d}.png")
        q = Rotation.from_matrix(T[:3, :3]).as_quat()
        truth.append(" ".join([stamp, *(f"{x:.9f}" for x in (*T[:3, 3], *q))]))
    (folder / "depth.txt").write_text("\n".join(lists) + "\n")
    (folder / "groundtruth.txt").write_text("\n".join(truth) + "\n")
    camera = {"width": WIDTH, "height": HEIGHT, "fx": FOCAL, "fy": FOCAL, "cx": WIDTH / 2 - 0.5, "cy": HEIGHT / 2 - 0.5}
    (folder / "camera.json").write_text(json.dumps(camera | {"depth_scale": SCALE, "principle": "itof"}))
    return len(poses)


def run(words: list[str]) -> tuple[float, float]:
    """Seconds and largest resident memory [GB] of `fusion reconstruct`."""
    begin = time.monotonic()
    child = subprocess.Popen([sys.executable, "-c", FUSION, "reconstruct", *words])
    _, status, used = os.wait4(child.pid, 0)
    if status:
        raise SystemExit(f"fusion reconstruct {' '.join(words)}: status {os.waitstatus_to_exitcode(status)}")
    return time.monotonic() - begin, used.ru_maxrss * 1024 / 1e9


def within(path: Path, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Faces (m, 18) of a PLY file that lie in a box, corners and normals, in an order that they alone decide."""
    with path.open("rb") as file:
        head = [file.readline().split()]
        while head[-1] != [b"end_header"]:
            head.append(file.readline().split())
        begin = file.tell()
    kinds = {b"float": "<f4", b"double": "<f8"}
    counts = [int(line[2]) for line in head if line[:1] == [b"element"]]
    kind = np.dtype(
        [(line[2].decode(), kinds[line[1]]) for line in head if line[:1] == [b"property"] and line[1] in kinds]
    )
    vertices = np.memmap(path, kind, "r", begin, counts[0])
    face = np.dtype([("count", "u1"), ("indices", "<i4", 3)])
    faces = np.memmap(path, face, "r", begin + counts[0] * kind.itemsize, counts[1])
    inside = np.ones(counts[0], bool)
    for axis, name in enumerate("xyz"):
        inside &= (vertices[name] > low[axis]) & (vertices[name] < high[axis])
    chosen = []
    for at in range(0, counts[1], CHUNK):
        some = faces["indices"][at : at + CHUNK]
        chosen.append(some[inside[some].all(axis=1)])
    corners = vertices[np.concatenate(chosen)]
    rows = np.stack([corners[name].astype(float) for name in ("x", "y", "z", "nx", "ny", "nz")], axis=-1)
    first = np.lexsort(np.moveaxis(rows, -1, 0)[::-1], axis=-1)[:, :1]  # begin at the least corner
    rows = np.take_along_axis(rows, ((first + np.arange(3)) % 3)[..., None], axis=1).reshape(len(rows), -1)
    return rows[np.lexsort(rows.T[::-1])]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scene", choices=tuple(SIZES), default="hall")
    parser.add_argument("--memory", type=float, default=1.0, help="GB")
    parser.add_argument("--voxel", type=float, default=0.005, help="m")
    parser.add_argument("-o", "--output", type=Path)
    chosen = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        home = chosen.output or Path(folder)
        rec = home / "recording"
        print(
            f"{write(chosen.scene, rec)} frames of a {chosen.scene} of {' x '.join(map(str, SIZES[chosen.scene]))} m",
            flush=True,
        )
        same = [
            str(rec),
            "--poses",
            "stated",
            "--voxel",
            str(chosen.voxel),
            "--truncation",
            str(4 * chosen.voxel),
            "--quiet",
        ]
        seconds, memory = run([*same, "--memory", str(chosen.memory), "-o", str(home / "whole")])
        told = json.loads((home / "whole" / "settings.json").read_text())["tiles"]
        print(
            f"whole: {seconds:.0f} s, {memory:.2f} GB at most, {told['pieces']} pieces, {told['faces']:,} triangles",
            flush=True,
        )
        box = [str(x) for corner in PART[chosen.scene] for x in corner]
        seconds, part_memory = run([*same, "--box", *box, "-o", str(home / "part"), "--no-report"])
        print(f"part: {seconds:.0f} s, {part_memory:.2f} GB at most")
        inner = WITHIN * BLOCK * chosen.voxel
        low, high = np.array(PART[chosen.scene][0]) + inner, np.array(PART[chosen.scene][1]) - inner
        ours, theirs = (within(home / one / "mesh.ply", low, high) for one in ("whole", "part"))
        equal = ours.shape == theirs.shape and bool((ours == theirs).all())
        found = "the same, bit for bit" if equal else "NOT the same"
        print(f"in the part: {len(ours):,} and {len(theirs):,} triangles, {found}")
    return int(not equal or memory > chosen.memory)


if __name__ == "__main__":
    raise SystemExit(main())
