"""Recordings that are no turntable scan, or not one of one rigid thing; and a wrong unit of the depth."""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import trimesh
from numpy.typing import NDArray

from tools.sets.hard.stage import OBJECT, Moving, Stage

if TYPE_CHECKING:
    from tools.sets.hard.drawing import Drawn

Array = NDArray[np.float64]
Rng = np.random.Generator

TUMBLED = "moved by hand about no axis"
SWAPPED = "another object from half way on"
BALL = "a ball of one colour"
BUMPED = "the camera is moved half way"
STILL = "nothing turns"
UNIT = "wrong unit of the depth"
TIPPED = "the object is tipped over half way"
WALK = "the camera walks, all else stands"
PLANTED = (TUMBLED, SWAPPED, BALL, BUMPED, STILL, UNIT, TIPPED, WALK)
RECOVERABLE = (BUMPED, TIPPED)  # a right mesh is possible, and may be said to be good


def planted(plain: "Drawn", rng: Rng) -> "Drawn":
    """The scan with its failure; a log goes where the angles do not."""
    kind, count = plain.planted, len(plain.turning.degrees)
    half = count // 2 + int(rng.integers(-2, 3))
    stage, first = plain.stage, plain.stage.moving[0]
    if kind == UNIT:
        return replace(plain, unit=float(rng.choice([0.1, 0.2, 5.0, 10.0])))
    if kind == BALL:
        return replace(plain, turning=replace(plain.turning, logged=None))
    if kind == BUMPED:
        T = stage.T_world_camera.copy()
        T[half:] = around(rng.choice([-1, 1]) * rng.uniform(8, 25)) @ T[half:] @ nudge(rng, 4.0, 0.05)
        return replace(plain, stage=staged(stage, stage.moving, T))
    if kind == WALK:
        T = walked(rng, stage.T_world_camera)
        return replace(plain, stage=staged(stage, stage.moving, T))
    if kind == SWAPPED:
        from tools.sets.hard.drawing import other_thing

        second = other_thing(rng, float(plain.item.extents[2]) * rng.uniform(0.8, 1.2))[0]
        before = np.arange(count) < half
        pair = [replace(first, shown=before), Moving(second, first.poses, ~before, OBJECT)]
        return replace(plain, stage=staged(stage, [*pair, *stage.moving[1:]], stage.T_world_camera))
    poses = first.poses.copy()
    if kind == TIPPED:
        poses[half:] = poses[half:] @ stood(plain.item, turn(rng, 90.0, flat=True))
    if kind == TUMBLED:
        own = np.eye(4)
        for i in range(count):
            own = turn(rng, rng.uniform(10, 35)) @ own
            poses[i] = stood(plain.item, own)
            poses[i, :2, 3] += rng.uniform(-0.02, 0.02, 2)
    moved = [replace(first, poses=poses), *stage.moving[1:]]
    if kind == TUMBLED:  # what it stands on, the second, turns no more
        moved[1] = replace(moved[1], poses=np.repeat(moved[1].poses[:1], count, axis=0))
    turning = replace(plain.turning, logged=None) if kind == TUMBLED else plain.turning
    return replace(plain, stage=staged(stage, moved, stage.T_world_camera), T_world_item=poses, turning=turning)


def staged(stage: Stage, moving: list[Moving], T_world_camera: Array) -> Stage:
    return Stage(stage.camera, stage.still, moving, T_world_camera)


def around(degrees: float) -> Array:
    """A turn about the world's upright."""
    return np.asarray(trimesh.transformations.rotation_matrix(np.deg2rad(degrees), [0, 0, 1]))


def turn(rng: Rng, degrees: float, flat: bool = False) -> Array:
    """A turn about any axis, or any level one."""
    axis = rng.standard_normal(3) * ([1, 1, 0] if flat else [1, 1, 1])
    return np.asarray(trimesh.transformations.rotation_matrix(np.deg2rad(degrees), axis))


def nudge(rng: Rng, degrees: float, metres: float) -> Array:
    T = turn(rng, degrees)
    way = rng.standard_normal(3)
    T[:3, 3] = metres * way / np.linalg.norm(way)
    return T


def stood(item: trimesh.Trimesh, T: Array) -> Array:
    """The turned object, moved so that it stands on the plate, about the axis."""
    points = trimesh.transform_points(item.vertices, T)
    out = T.copy()
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    out[:3, 3] -= [middle[0], middle[1], points[:, 2].min()]
    return out


def walked(rng: Rng, T: Array) -> Array:
    """A camera in a hand that goes round by 40 to 80 deg and shakes."""
    way = np.linspace(0, rng.choice([-1, 1]) * rng.uniform(40, 80), len(T))
    shake = np.cumsum(rng.standard_normal((len(T), 3)), axis=0) * 0.003
    out = np.array(
        [around(a - way[len(T) // 2]) @ pose @ nudge(rng, 0.5, 0.002) for a, pose in zip(way, T, strict=True)]
    )
    out[:, :3, 3] += shake
    return out
