"""The good inputs that cases break: small recordings, meshes and JSON. Recordings are simulated once and copied."""

import json
import os
import shutil
import subprocess
import sys
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np

from broken.meshes import cube, ply_header

CAMERA = {
    "width": 160,
    "height": 120,
    "fx": 144.0,
    "fy": 144.0,
    "cx": 79.5,
    "cy": 59.5,
    "distortion": [0, 0, 0, 0, 0],
    "depth_scale": 1000,
    "principle": "structured_light",
    "sensor": "Kinect for Xbox 360",
}
BOARD = {"columns": 9, "rows": 6, "square_m": 0.04}
# how each is made; frames are few and small, so that a case costs little
SIMULATED = {
    "wall": [
        "wall",
        "--set",
        "distance_m=0.8,1.0",
        "--set",
        "frames=3",
        "--sensor",
        "kinect-v1",
        "--camera",
        "camera.json",
    ],
    "turntable": [
        "turntable",
        "--set",
        "frames=12",
        "--set",
        "turns=1.1",
        "--set",
        "mesh=lump.ply",
        "--sensor",
        "kinect-v1",
        "--camera",
        "camera.json",
    ],
    "checkerboard": ["checkerboard", "--set", "frames=6", "--camera", "board_camera.json"],
}
PROGRAM = "import sys; from fusion.commands.console import run; sys.exit(run())"  # what pip installs as `fusion`


def place() -> Path:
    """Where good inputs are kept for this process and its children."""
    return Path(os.environ["FUSION_BROKEN_BASES"])


def prepare(folder: Path) -> None:
    """Make all good inputs in a folder, and use it from now on."""
    folder.mkdir(parents=True, exist_ok=True)
    os.environ["FUSION_BROKEN_BASES"] = str(folder)
    (folder / "camera.json").write_text(json.dumps(CAMERA), encoding="utf-8")
    wide = CAMERA | {
        "width": 320,
        "height": 240,
        "fx": 288.0,
        "fy": 288.0,
        "cx": 159.5,
        "cy": 119.5,
        "principle": "itof",
    }
    (folder / "board_camera.json").write_text(json.dumps(wide), encoding="utf-8")
    lump(folder / "lump.ply")
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).resolve().parents[2])}
    for name, words in SIMULATED.items():
        command = [sys.executable, "-c", PROGRAM, "simulate", *words, "-o", name, "--seed", "1"]
        if not (folder / name).exists():
            subprocess.run(command, cwd=folder, env=environment, check=True, capture_output=True, timeout=120)
        (folder / name / ".fusion.json").unlink(missing_ok=True)  # a recording of a user, not an earlier result


def lump(path: Path) -> None:
    """A block with a smaller one on it, off the axis: a turn of it can be seen. Metres, z up; coloured."""
    low, high = cube(0.16), cube(0.08)
    vertices = low.vertices * [1, 0.6, 0.5] + [0, 0, 0.04]
    top = high.vertices + np.array([0.03, 0.01, 0.12])
    faces = [*low.faces.tolist(), *(high.faces + len(vertices)).tolist()]
    colours = "".join(f"property uchar {name}\n" for name in ("red", "green", "blue"))
    rows = [f"{x:.4f} {y:.4f} {z:.4f} 200 {150 + n} 120" for n, (x, y, z) in enumerate(np.vstack([vertices, top]))]
    rows += ["3 " + " ".join(map(str, face)) for face in faces]
    path.write_bytes(ply_header("ascii", 16, len(faces), colours) + "\n".join(rows).encode() + b"\n")


def recording(folder: Path, name: str = "rec", of: str = "wall") -> Path:
    """A copy of a good recording in a case's folder."""
    target = folder / name
    shutil.copytree(place() / of, target)
    return target


@cache
def depth_counts(of: str = "wall", frame: int = 0) -> "object":
    """Depth of a frame [counts], (120, 160) uint16."""
    import cv2

    return cv2.imread(str(place() / of / "depth" / f"{frame:06d}.png"), cv2.IMREAD_UNCHANGED)


def sensor() -> dict:
    """A good sensor model, as JSON."""
    return json.loads((place() / "wall" / "truth" / "sensor.json").read_text(encoding="utf-8"))


def scene() -> dict:
    """A good scene to simulate: the lump on a turntable."""
    return {
        "mesh": "lump.ply",
        "reflectance": 0.6,
        "camera": dict(CAMERA),
        "trajectory": {
            "turntable": {"axis_point": [0, 0, 0], "axis_direction": [0, 0, 1], "degrees_per_frame": 60, "frames": 3},
            "T_world_camera": {"eye": [0.5, 0, 0.3], "target": [0, 0, 0.05]},
        },
        "poses": {"source": "nominal", "sigma_m": 0.0005, "sigma_rad": 0.0005},
        "ambient_lux": 300,
    }


def write_json(path: Path, told: object) -> None:
    """As any program writes it."""
    path.write_text(json.dumps(told), encoding="utf-8")


def beside(folder: Path, words: list[str]) -> None:
    """The good files that a command line names beside the broken one."""
    from broken.meshes import ball, ply_ascii

    named = {word.split("=")[-1].split("/")[0] for word in words}
    for name in ("wall", "turntable", "checkerboard"):
        if name in named and words[0] != "simulate":
            recording(folder, name, name)
    if "good.ply" in named:
        (folder / "good.ply").write_bytes(ply_ascii(ball()))
    if "moved.ply" in named:  # the same one, another scan of it
        one = ball()
        (folder / "moved.ply").write_bytes(ply_ascii(replace(one, vertices=one.vertices + 0.001)))
    if "lump.ply" in named:
        lump(folder / "lump.ply")
    for name, told in (("camera.json", CAMERA), ("board.json", BOARD), ("scene.json", None)):
        if name in named:
            write_json(folder / name, told or scene())
            if name == "scene.json":
                lump(folder / "lump.ply")
