"""Writes what the engine may see: recordings, the mesh as stated, poses as stated, the known part of the sensor."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

from tools.trial.furnished.motions import CameraWalk
from tools.trial.furnished.physics.bench import Bench, CameraRun
from tools.trial.furnished.physics.poses import Array
from tools.trial.furnished.physics.recorder import TakenFrames, record
from tools.trial.furnished.physics.sensor import Effects
from tools.trial.furnished.rooms.parts import MergedParts, ScenePart, merge

HEAD = """ply
format binary_little_endian 1.0
element vertex {vertices}
property float x
property float y
property float z
property uchar red
property uchar green
property uchar blue
element face {faces}
property list uchar int vertex_indices
end_header
"""


@dataclass(frozen=True)
class CaseTold:
    """What a case tells beside its images.

    Attributes:
        parts: of the scene as stated.
        sensor: content of sensor.json.
        telemetry: whether temperatures are told.
        lux: [lx] light of the room, None where it is not told.
    """

    parts: list[ScenePart]
    sensor: dict[str, Any]
    telemetry: bool
    lux: float | None


def write_case(folder: Path, bench: Bench, walk: CameraWalk, effects: Effects, written: CaseTold) -> None:
    folder.mkdir(parents=True)
    _json(folder / "sensor.json", written.sensor)
    merged = merge(written.parts)
    for one in walk.recordings:
        target = folder / f"rec_{one.index:02d}"
        (target / "depth").mkdir(parents=True)
        taken = record(bench, one, effects, True)
        bench.casts.clear()
        _write_mesh(target / "scene.ply", merged)
        _json(target / "camera.json", _camera(bench, written.sensor["sensor"]))
        _json(target / "scene.json", _scene(walk, written.lux))
        _write_images(target, one, taken, bench.camera.scale)
        if written.telemetry:
            _write_temperatures(target / "telemetry.csv", bench, one)


def _json(file: Path, content: Any) -> None:
    file.write_text(json.dumps(content, indent=1), encoding="utf-8")


def _camera(bench: Bench, sensor: str) -> dict[str, Any]:
    c = bench.camera
    lens: dict[str, Any] = {"width": c.width, "height": c.height, "fx": c.fx, "fy": c.fy, "cx": c.cx, "cy": c.cy}
    lens |= {"distortion": c.distortion}
    return {**lens, "depth_scale": c.scale, "principle": c.principle, "sensor": sensor}


def _scene(walk: CameraWalk, lux: float | None) -> dict[str, Any]:
    poses = {"source": walk.source, "sigma_m": walk.sigma[0], "sigma_rad": walk.sigma[1]}
    return {"mesh": "scene.ply", "poses": poses, **({} if lux is None else {"ambient_lux": lux})}


def _write_images(folder: Path, recording: CameraRun, taken: TakenFrames, scale: float) -> None:
    depths, irs = ["# timestamp filename"], ["# timestamp filename"]
    poses = ["# timestamp tx ty tz qx qy qz qw"]
    lit = taken.amplitude[0] is not None
    if lit:
        (folder / "ir").mkdir()
    for k, time in enumerate(recording.times):
        name = f"{time:.6f}"
        counts = np.round(np.nan_to_num(taken.depth[k]) * scale)
        counts[(counts >= 65535) | (counts < 0)] = 0
        _image(folder / "depth" / f"{name}.png", counts)
        depths.append(f"{name} depth/{name}.png")
        if lit:
            _image(folder / "ir" / f"{name}.png", np.clip(np.round(taken.amplitude[k]), 0, 65535))
            irs.append(f"{name} ir/{name}.png")
        T = recording.stated(time)
        numbers = np.r_[T[:3, 3], Rotation.from_matrix(T[:3, :3]).as_quat()]
        poses.append(" ".join([name, *(f"{x:.9f}" for x in numbers)]))
    _lines(folder / "depth.txt", depths)
    _lines(folder / "groundtruth.txt", poses)
    if lit:
        _lines(folder / "ir.txt", irs)


def _image(file: Path, counts: Array) -> None:
    cv2.imwrite(str(file), counts.astype(np.uint16))


def _lines(file: Path, lines: list[str]) -> None:
    file.write_text("".join(f"{line}\n" for line in lines), encoding="utf-8")


def _write_temperatures(file: Path, bench: Bench, recording: CameraRun) -> None:
    rng = np.random.default_rng([bench.seed, 3, recording.index])
    rows = [f"{t:.6f},{bench.temperature(t) + rng.normal(0, 0.03):.3f}" for t in recording.times]
    _lines(file, ["timestamp,temperature_c", *rows])


def _write_mesh(file: Path, merged: MergedParts) -> None:
    grey = np.repeat(np.round(merged.reflectance * 255).astype(np.uint8), 3)
    vertices = np.empty(len(merged.vertices), dtype=[("place", "<f4", 3), ("colour", "u1", 3)])
    vertices["place"], vertices["colour"] = merged.vertices, grey[:, None]
    faces = np.empty(len(merged.faces), dtype=[("corners", "u1"), ("indices", "<i4", 3)])
    faces["corners"], faces["indices"] = 3, merged.faces
    head = HEAD.format(vertices=len(vertices), faces=len(faces))
    file.write_bytes(head.encode() + vertices.tobytes() + faces.tobytes())
