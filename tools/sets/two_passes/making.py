"""A case becomes two recordings and the truth: the object's own frame is that of `truth/object.ply`."""

import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import trimesh

from tools.sets.hard.cameras import Stereo
from tools.sets.judging.writing import Recording, plain, trajectory
from tools.sets.planted.devices import Device
from tools.sets.planted.shapes import BRIGHT, Array, Paint, Rng, paint
from tools.sets.planted.stage import Solid, Stage, stage_of, turned
from tools.sets.two_passes.cases import CAMERAS, FAR, Case, Way, made

COUNTS = 1000  # per metre
STD = 0.001  # relative standard deviation of a calibrated focal length
EVERY = 0.25  # [s] between frames


@dataclass(frozen=True)
class Laid:
    """The paint of an object that lies at T (4, 4) in the solid's frame."""

    paint: Paint
    T: Array

    def at(self, points: Array) -> Array:
        """Colours (..., 3) of points in the solid's frame."""
        back = np.linalg.inv(self.T)
        return self.paint.at(points @ back[:3, :3].T + back[:3, 3])


@dataclass(frozen=True)
class Pass:
    """One pass before a picture is taken; angles [deg] (n,), `T_plate_object` (4, 4) at the angle 0."""

    stage: Stage
    angles: Array
    T_plate_object: Array


def make(case: Case, folder: Path, rng: Rng, frames: int) -> None:
    """Write `folder/pass_1`, `folder/pass_2` and `folder/truth`."""
    height = rng.uniform(0.14, 0.24)
    item = made(case.shape, rng, height)
    other = made(case.second, rng, rng.uniform(0.14, 0.24)) if case.second else item
    printed = paint(rng, BRIGHT, 0.06)
    passes = [
        pass_of(rng, case.way(1), (item, printed), _stood(rng), frames),
        pass_of(rng, case.way(2), (other, printed), _turned_over(rng, other), frames),
    ]
    off = 1 + STD * float(np.clip(rng.standard_normal(), -2, 2))
    truth = folder / "truth"
    truth.mkdir(parents=True, exist_ok=True)
    for number, one in enumerate(passes, 1):
        way = case.way(number)
        device = CAMERAS[way.camera]
        recording = Recording(folder / f"pass_{number}", camera_of(way.camera, case.color, off))
        _record(recording, (one, device, case.color), rng)
        poses = [np.linalg.inv(turned(a) @ one.T_plate_object) @ one.stage.T_world_camera for a in one.angles]
        trajectory(truth / f"poses_{number}.txt", 100 + EVERY * np.arange(frames), np.array(poses))
    item.export(truth / "object.ply")
    cameras = " and ".join(dict.fromkeys(case.way(k).camera for k in (1, 2)))
    told = {"shape": case.shape, "camera": cameras, "refused": case.refused, "height_m": height} | {
        f"T_plate_object_{k}": p.T_plate_object for k, p in enumerate(passes, 1)
    }
    text = json.dumps({name: plain(x) for name, x in told.items()}, indent=1)
    (truth / "truth.json").write_text(text, encoding="utf-8")


def pass_of(rng: Rng, way: Way, thing: tuple[trimesh.Trimesh, Paint], T: Array, frames: int) -> Pass:
    """Another camera place, wall and table each time; the object lies at T on the plate."""
    item, printed = thing
    T = T.copy()
    laid = np.asarray(item.vertices) @ T[:3, :3].T
    T[:3, 3] = [*(-(laid.min(axis=0) + laid.max(axis=0))[:2] / 2 + rng.uniform(-0.01, 0.01, 2)), -laid[:, 2].min()]
    lying = trimesh.Trimesh(laid + T[:3, 3], item.faces, process=False)
    far = rng.uniform(FAR[way.camera], FAR[way.camera] + 0.1) + float(np.ptp(laid, axis=0).max()) / 2
    stage = stage_of(rng, CAMERAS[way.camera].camera, lying, far + way.farther, way.down)
    paints: Any = (stage.paints[0], stage.paints[1], Laid(printed, T))
    stage = replace(stage, item=Solid(lying), paints=paints)
    angles = rng.choice([-1, 1]) * (np.linspace(0, way.degrees, frames) + 0.05 * rng.standard_normal(frames))
    return Pass(stage, angles - angles[0], T)


def _stood(rng: Rng) -> Array:
    return turned(rng.uniform(0, 360))


def _turned_over(rng: Rng, item: trimesh.Trimesh) -> Array:
    """By 80 to 180 deg about a level axis, then about the upright; half of them come to lie on a face, as things do."""
    way = rng.uniform(0, 2 * np.pi)
    T = trimesh.transformations.rotation_matrix(np.deg2rad(rng.uniform(80, 180)), [np.cos(way), np.sin(way), 0])
    if rng.random() < 0.5:
        hull = item.convex_hull
        down = hull.face_normals @ T[:3, :3].T @ [0, 0, -1] + 0.2 * hull.area_faces / hull.area_faces.max()
        normal = T[:3, :3] @ hull.face_normals[int(np.argmax(down))]
        T = trimesh.geometry.align_vectors(normal, [0, 0, -1]) @ T
    return np.asarray(turned(rng.uniform(0, 360)) @ T)


def _record(recording: Recording, what: tuple[Pass, Device | Stereo, bool], rng: Rng) -> None:
    one, device, color = what
    backdrop = one.stage.backdrop(one.stage.T_world_camera)
    for i, angle in enumerate(one.angles):
        hits, colours = one.stage.seen(backdrop, turned(angle), turned(angle))
        recording.depth(100 + EVERY * i, device.depth(hits, 0.0, rng))
        if color:
            recording.rgb(100 + EVERY * i, colours)
    recording.done(turntable_deg=np.abs(one.angles))


def camera_of(name: str, color: bool, off: float) -> dict[str, Any]:
    """camera.json of a calibrated camera whose focal length is `off` times the true one."""
    device = CAMERAS[name]
    true, f = device.camera, device.camera.f * off
    lens: dict[str, Any] = {"width": true.width, "height": true.height, "fx": f, "fy": f, "cx": true.cx, "cy": true.cy}
    lens |= {"distortion": [0.0] * 5}
    std = {"fx": STD * true.f, "fy": STD * true.f, "cx": 0.5, "cy": 0.5}
    colors = {"color": lens | {"T_color_depth": np.eye(4).tolist()}} if color else {}
    kind = {"depth_scale": COUNTS, "principle": device.principle, "sensor": name, "std": std}
    return lens | kind | colors
