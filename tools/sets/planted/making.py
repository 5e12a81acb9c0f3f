"""One case becomes a recording, and its truth in a folder beside it."""

import json
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import trimesh
from numpy.typing import NDArray

from tools.sets.planted.cases import Case
from tools.sets.planted.devices import DEVICES, Device
from tools.sets.planted.shapes import SHAPES, Array, Rng, Waves, waves
from tools.sets.planted.stage import OBJECT, Hits, Stage, stage_of, turned

COUNTS = 1000  # per metre, in all files
SEEN = 300  # surface points kept of each frame
STD = 0.001  # relative standard deviation of a calibrated focal length


@dataclass(frozen=True)
class Plan:
    """What is drawn for one case before a picture is taken; angles [deg] (n,), poses (n, 4, 4)."""

    stage: Stage
    device: Device
    angles: Array
    logged: Array
    T_world_camera: Array
    T_world_item: Array
    black: Waves | None
    notes: dict[str, Any]


def make(case: Case, seed: int, folder: Path) -> None:
    """Write `folder/recording` and `folder/truth`; the same seed, the same case."""
    rng = np.random.default_rng([seed, zlib.crc32(case.name.encode())])
    plan = planned(case, rng)
    recording, truth = folder / "recording", folder / "truth"
    for made in (recording / "depth", recording / "rgb", truth):
        made.mkdir(parents=True)
    times = 100 + 0.25 * np.arange(case.frames)
    bend, seen = _bend(case, plan.device, rng), []
    backdrop = plan.stage.backdrop(plan.T_world_camera[0])
    for i, time in enumerate(times):
        if (plan.T_world_camera[i] != backdrop.T_world_camera).any():
            backdrop = plan.stage.backdrop(plan.T_world_camera[i])
        hits, colour = plan.stage.seen(backdrop, turned(plan.angles[i]), plan.T_world_item[i])
        depth = _taken(case, plan, hits, bend, rng)
        colour[_dark(plan, hits)] = 8
        _picture(recording / "depth" / f"{time:.6f}.png", np.rint(depth * COUNTS).astype(np.uint16))
        _picture(recording / "rgb" / f"{time:.6f}.jpg", np.ascontiguousarray(colour[..., ::-1]))
        points = hits.point[hits.part == OBJECT]
        seen.append(points[rng.permutation(len(points))[:SEEN]])
    for kind, ending in (("depth", "png"), ("rgb", "jpg")):
        lines = [f"{time:.6f} {kind}/{time:.6f}.{ending}" for time in times]
        (recording / f"{kind}.txt").write_text("\n".join(["# timestamp filename", *lines, ""]), encoding="utf-8")
    stated = _stated_camera(case, plan, rng)
    (recording / "camera.json").write_text(json.dumps(stated, indent=1), encoding="utf-8")
    if case.log:
        rows = [f"{time:.6f},{angle:.4f}" for time, angle in zip(times, plan.logged, strict=True)]
        (recording / "telemetry.csv").write_text("\n".join(["timestamp,turntable_deg", *rows, ""]), encoding="utf-8")
    plan.stage.item.mesh.export(truth / "object.ply")
    np.savez(truth / "seen.npz", points=np.concatenate(seen).astype(np.float32))
    told = plan.notes | {"planted": case.planted, "f": plan.stage.camera.f, "angles_deg": plan.angles.tolist()}
    (truth / "truth.json").write_text(json.dumps(told, indent=1), encoding="utf-8")


def planned(case: Case, rng: Rng) -> Plan:
    """Stage, motion and log of a case."""
    device = DEVICES[case.device]
    height = rng.uniform(0.14, 0.26)
    item = SHAPES[case.shape](rng, height)
    item.apply_translation([*rng.uniform(-0.015, 0.015, 2), 0])
    stage = stage_of(rng, device.camera, item, rng.uniform(0.65, 0.75) + height / 2)
    n, half = case.frames, case.frames // 2
    commanded = np.linspace(0, case.degrees, n)
    uneven = 0.05 * rng.standard_normal(n) * (case.degrees > 0)
    turning = commanded + uneven
    notes: dict[str, Any] = {"height_m": height}
    if case.name == "slip":
        turning = turning - 12.0 * (np.arange(n) >= half)
    direction = rng.choice([-1, 1])
    logged = commanded
    if case.name == "log-wrong":
        notes["log"] = factor = float(rng.choice([np.pi / 180, 1.5]))
        logged = commanded * factor
    angles = direction * turning
    T_item = np.array([turned(a) for a in angles])
    if case.name == "nudged":
        T_item[half:] = T_item[half:] @ _nudge(rng)
    T_camera = np.repeat(stage.T_world_camera[None], n, axis=0)
    if case.name == "bumped":
        T_camera[half:] = T_camera[half:] @ _bump(rng)
    black = waves(rng, 0.18, 3) if case.name == "black" else None
    return Plan(stage, device, angles, logged, T_camera, T_item, black, notes)


def _nudge(rng: Rng) -> Array:
    T = turned(rng.choice([-5.0, 5.0]))
    way = rng.uniform(0, 2 * np.pi)
    T[:2, 3] = 0.008 * np.array([np.cos(way), np.sin(way)])
    return T


def _bump(rng: Rng) -> Array:
    axis, way = rng.standard_normal((2, 3))
    T = np.asarray(trimesh.transformations.rotation_matrix(np.deg2rad(2.0), axis))
    T[:3, 3] = 0.005 * way / np.linalg.norm(way)
    return T


def _bend(case: Case, device: Device, rng: Rng) -> Array | float:
    """Error over the image [px of disparity], the product of two waves of 0.9 px in 640 columns."""
    if case.name != "bent-depth":
        return 0.0
    v, u = np.mgrid[: device.camera.height, : device.camera.width]
    scale = device.camera.width / 640
    long = scale * rng.uniform(110, 160, 2)
    phase = rng.uniform(0, 2 * np.pi, 2)
    return np.asarray(
        0.9 * scale * np.cos(2 * np.pi * u / long[0] + phase[0]) * np.cos(2 * np.pi * v / long[1] + phase[1])
    )


def _taken(case: Case, plan: Plan, hits: Hits, bend: Array | float, rng: Rng) -> Array:
    """Depth [m] of one frame, as the device gives it."""
    depth = plan.device.depth(hits, bend, rng)
    depth[_dark(plan, hits)] = 0.0
    if case.name == "range":
        depth = depth * np.linalg.norm(plan.stage.camera.rays, axis=-1)
    return depth


def _dark(plan: Plan, hits: Hits) -> NDArray[np.bool_]:
    """Pixels on black parts, which are 40 % of the object's vertices."""
    dark = np.zeros(hits.part.shape, bool)
    if plan.black is not None:
        field = plan.black.at(np.asarray(plan.stage.item.mesh.vertices))
        mine = hits.part == OBJECT
        dark[mine] = plan.black.at(hits.point[mine]) > np.quantile(field, 0.6)
    return dark


def _stated_camera(case: Case, plan: Plan, rng: Rng) -> dict[str, Any]:
    """camera.json as its owner believes it to be."""
    true = plan.stage.camera
    f = true.f
    std: dict[str, Any] = {}
    if case.camera == "calibrated":
        f *= 1 + STD * float(np.clip(rng.standard_normal(), -2, 2))
        std = {"std": {"fx": STD * true.f, "fy": STD * true.f, "cx": 0.5, "cy": 0.5}}
    if case.name.startswith("focal"):
        f *= float(rng.choice([0.92, 1.08]))
    lens: dict[str, Any] = {"width": true.width, "height": true.height, "fx": f, "fy": f, "cx": true.cx, "cy": true.cy}
    lens |= {"distortion": [0.0] * 5}
    counts = COUNTS * float(rng.choice([5, 10, 0.1])) if case.name == "unit" else COUNTS
    kind = {"principle": plan.device.principle, "sensor": case.device}
    color = lens | {"T_color_depth": np.eye(4).tolist()}
    return lens | {"depth_scale": counts} | kind | std | {"color": color}


def _picture(file: Path, image: NDArray[Any]) -> None:
    if not cv2.imwrite(str(file), image):
        raise OSError(f"{file}: not written")
