"""Draws a scan of the hard set: three of four can be scanned, one of four is planted to fail."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray

from tools.sets.hard import planting, things, turning
from tools.sets.hard.cameras import CAMERAS, Camera
from tools.sets.hard.stage import OBJECT, OTHER, Moving, Stage
from tools.sets.hard.things import Thing
from tools.sets.hard.turning import Turning
from tools.sets.planted.shapes import joined

Array = NDArray[np.float64]
Rng = np.random.Generator

SHAPES = ("box", "sphere", "cylinder", "lumpy", "tower", "bricks")
LIKELY = (0.22, 0.12, 0.14, 0.18, 0.14, 0.2)


@dataclass(frozen=True)
class Drawn:
    """A scan before a picture is taken.

    Attributes:
        planted: why it cannot be scanned, empty where it can.
        T_world_item: (n, 4, 4) of the object.
        exposure: (n,) factor on the colours; `counts`: per metre, as stated over what is right.
        story: what is in it, in words.
    """

    name: str
    planted: str
    stage: Stage
    device: Camera
    item: trimesh.Trimesh
    turning: Turning
    T_world_item: Array
    exposure: Array
    unit: float = 1.0
    story: dict[str, Any] = field(default_factory=dict)


def drawn(name: str, planted: str, rng: Rng) -> Drawn:
    """A scan of the usual kind, or one with a planted failure (see tools/sets/hard/planting.py)."""
    kind = "sphere" if planted == planting.BALL else str(rng.choice(SHAPES, p=LIKELY))
    base = str(rng.choice(["disc", "square", "odd", "none", "carton"], p=[0.34, 0.16, 0.16, 0.2, 0.14]))
    if planted:
        base = "disc" if base in ("none", "carton") or planted == planting.BALL else base
    item = things.shape(rng, kind, rng.uniform(0.12, 0.24))
    if planted != planting.BALL:
        item.apply_translation([*rng.uniform(-0.02, 0.02, 2), 0])
    if base == "carton":
        item = on_carton(rng, item)
    reach = float(np.linalg.norm(item.vertices[:, :2], axis=1).max())
    plate = things.support(rng, base, reach + rng.uniform(0.02, 0.06))
    turns = turned(rng, base, planted)
    device = CAMERAS[str(rng.choice(list(CAMERAS)))]
    count, top = len(turns.degrees), float(item.vertices[:, 2].max())
    floor = 0.0 if plate is None else float(plate.bounds[0, 2]) - (rng.uniform(0.0, 0.03) if rng.random() < 0.5 else 0)
    close = rng.random() < 0.6
    behind = rng.uniform(0.05, 0.30) if close else rng.uniform(1.2, 2.5)
    wide = max(reach, 0.0 if plate is None else float(np.linalg.norm(plate.vertices[:, :2], axis=1).max()))
    paint = things.plain(rng) if planted == planting.BALL else things.printed(rng)
    thing = things.thing(item, paint)
    moving = [Moving(thing, turns.poses, np.ones(count, bool), OBJECT)]
    if plate is not None:
        surface = things.plain(rng, 150.0) if planted == planting.BALL else things.printed(rng, things.WOOD, 0.1, 0.3)
        moving.append(Moving(things.thing(plate, surface), turns.poses, np.ones(count, bool)))
    T_camera = looking(rng, device, top, wide)
    extras: list[str] = []
    if turns.hand.any():
        moving.append(hand(rng, turns, reach, top))
        extras.append("hand")
    if not close and rng.random() < 0.35:
        moving.append(walker(rng, count, behind, floor))
        extras.append("person")
    still = things.surroundings(rng, wide + behind, floor)
    if rng.random() < 0.25:
        around = rng.uniform(-np.pi, 0)
        cable = things.cable(rng, (wide + 0.01) * np.array([np.cos(around), np.sin(around)]), floor)
        moving.append(Moving(cable, np.repeat(np.eye(4)[None], count, axis=0), np.ones(count, bool)))
        extras.append("cable")
    exposure = np.ones(count)
    if rng.random() < 0.5:
        exposure = np.exp(
            rng.uniform(0.05, 0.25) * np.sin(np.linspace(0, rng.uniform(2, 9), count) + rng.uniform(0, 6))
        )
    stage = Stage(device.camera, still, moving, np.repeat(T_camera[None], count, axis=0))
    story = {
        "shape": kind, "base": base, "camera": next(k for k, c in CAMERAS.items() if c is device),
        "turned by": "hand" if turns.by_hand else "motor", "log": turns.logged is not None,
        "degrees": round(float(turns.degrees[-1]), 1), "frames": count,
        "largest step": round(float(np.abs(np.diff(turns.degrees)).max()), 1),
        "drift mm": round(1e3 * float(np.linalg.norm(turns.shift, axis=1).max()), 1),
        "wall cm": round(100 * behind), "extras": extras,
    }  # fmt: skip
    plain = Drawn(name, planted, stage, device, item, turns, turns.poses, exposure, 1.0, story)
    return planting.planted(plain, rng) if planted else plain


def turned(rng: Rng, base: str, planted: str) -> Turning:
    """By hand where nothing but a hand could; a motor does one of three of the others."""
    if planted in (planting.STILL, planting.WALK):
        return turning.still(int(rng.integers(20, 40)))
    degrees = turning.whole(rng) if not planted else float(rng.uniform(350, 420))
    if base in ("none", "carton") or rng.random() < 2 / 3:
        return turning.by_hand(rng, degrees, base in ("none", "carton"))
    return turning.motor(rng, degrees)


def on_carton(rng: Rng, item: trimesh.Trimesh) -> trimesh.Trimesh:
    """The object on a box that turns with it, and belongs to what is scanned."""
    wide = item.extents[:2] + rng.uniform(0.02, 0.06, 2)
    carton = things.lifted(trimesh.creation.box([*wide, rng.uniform(0.06, 0.14)]))
    middle = item.bounds.mean(axis=0)
    carton.apply_translation([middle[0], middle[1], 0])
    return joined([carton, things.lifted(item, carton.bounds[1, 2] - 0.0005)])


def looking(rng: Rng, device: Camera, top: float, wide: float) -> Array:
    """A camera on the side of -y that looks down by 12 to 40 deg, as near as the picture allows."""
    down, aim = np.deg2rad(rng.uniform(12, 40)), np.array([*rng.uniform(-0.03, 0.03, 2), 0.45 * top])
    half = min(device.camera.width, device.camera.height) / 2 / device.camera.f
    far = max(rng.uniform(0.42, 0.6), rng.uniform(0.85, 1.2) * max(top, wide) / half) + 0.5 * wide
    centre = aim + far * np.array([0, -np.cos(down), np.sin(down)])
    z = (aim - centre) / far
    x = np.cross(z, [0, 0, 1])
    x /= np.linalg.norm(x)
    T = np.eye(4)
    T[:3] = np.stack([x, np.cross(z, x), z, centre], axis=1)
    return T @ np.asarray(trimesh.transformations.rotation_matrix(np.deg2rad(rng.uniform(-4, 4)), [0, 0, 1]))


def hand(rng: Rng, turns: Turning, reach: float, top: float) -> Moving:
    """A hand that comes from the right or the left and touches the side; elsewhere each time."""
    poses = []
    for _ in turns.degrees:
        side = rng.choice([0.0, np.pi]) + rng.uniform(-0.7, 0.4)
        T = np.asarray(trimesh.transformations.rotation_matrix(side, [0, 0, 1]))
        T[:3, 3] = T[:3, :3] @ [0.92 * reach + rng.uniform(0, 0.01), 0, rng.uniform(0.02, max(0.03, 0.6 * top))]
        poses.append(T @ trimesh.transformations.rotation_matrix(rng.uniform(-0.35, -0.05), [0, 1, 0]))
    return Moving(things.hand(rng), np.array(poses), turns.hand, OTHER)


def walker(rng: Rng, count: int, behind: float, floor: float) -> Moving:
    """A person who walks to and fro before the wall."""
    x = rng.uniform(0.5, 1.0) * np.sin(np.linspace(0, rng.uniform(4, 12), count) + rng.uniform(0, 6))
    poses = np.repeat(np.eye(4)[None], count, axis=0)
    poses[:, 0, 3], poses[:, 1, 3] = x, rng.uniform(0.9, behind - 0.25)
    return Moving(things.person(rng, floor), poses, np.ones(count, bool), OTHER)


def other_thing(rng: Rng, height: float) -> tuple[Thing, trimesh.Trimesh]:
    """What an object may be exchanged for."""
    mesh = things.shape(rng, str(rng.choice(["lumpy", "tower", "bricks", "box"])), height)
    return things.thing(mesh, things.printed(rng)), mesh
