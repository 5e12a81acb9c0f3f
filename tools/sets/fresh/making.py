"""A unit becomes folders: board, walls, scan, sensor.json as its owner has them; the truth; a scan without errors."""

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tools.sets.fresh.angles import angle_std
from tools.sets.fresh.picture import Pictures
from tools.sets.fresh.unit import LASER, NOMINAL, Unit
from tools.sets.fresh.views import COLUMNS, OBJECT, ROWS, SQUARE, Board, Plane
from tools.sets.judging.writing import Recording, plain, trajectory

Array = NDArray[np.float64]
Rng = np.random.Generator

BOARDS, STILLS = 20, 6  # pictures of the board, frames of a wall
SEEN = 400  # surface points kept of each frame


def make(unit: Unit, folder: Path, rng: Rng) -> None:
    """An older unit of the same name is made anew."""
    shutil.rmtree(folder, ignore_errors=True)
    (folder / "truth").mkdir(parents=True)
    rays = unit.device.lens.four()
    stated = NOMINAL[unit.device.principle].fields | _kind(unit)
    corners = _boards(unit, folder, stated, rays, rng)
    _walls(unit, folder, stated, rays, rng)
    effects = unit.device.sensor(rng)
    model = {"format": "fusion-sensor/1", "name": unit.name, "principle": unit.device.principle, "effects": effects}
    (folder / "sensor.json").write_text(json.dumps(model, indent=1), encoding="utf-8")
    _scan(unit, folder, stated, rays, int(rng.integers(2**31)))
    turning = unit.turning
    truth = {
        "sensor": unit.device.principle, "object": unit.shape, "camera": unit.device.lens.fields,
        "axis_point": turning.point, "axis_direction": turning.direction,
        "angles_rad": turning.true - turning.true[0], "said_rad": turning.logged - turning.logged[0],
        "slip": {"frame": turning.slip}, "camera_distance_m": float(np.linalg.norm(unit.table.T[:3, 3])),
        "walls_m": unit.walls, "corners": corners, "angle_std_deg": angle_std(unit),
    }  # fmt: skip
    text = json.dumps({name: plain(x) for name, x in truth.items()}, indent=1)
    (folder / "truth" / "truth.json").write_text(text, encoding="utf-8")


def _kind(unit: Unit) -> dict[str, Any]:
    kind = unit.device.principle
    return {"depth_scale": unit.device.counts_per_metre, "principle": kind, "sensor": f"fresh-{kind}"}


def _boards(unit: Unit, folder: Path, stated: dict[str, Any], rays: list[Array], rng: Rng) -> list[Any]:
    """Pictures of the board; what is returned is where its corners (n, 54, 2) truly are [px]."""
    about = {"columns": COLUMNS, "rows": ROWS, "square_m": SQUARE}
    (folder / "board.json").write_text(json.dumps(about), encoding="utf-8")
    board, corners = Recording(folder / "board", stated), []
    pictures = Pictures(unit.device.lens, 12000 if unit.device.principle == "itof" else 5500)
    for i in range(BOARDS):
        scene = held(unit, rng)
        board.depth(5.0 + 2 * i, unit.device.frames(scene, 1, rng, rays)[0][0])
        board.ir(5.0 + 2 * i, pictures.of(scene, rng))
        corners.append(np.round(unit.device.lens.pixels(scene.corners), 4).tolist())
    board.done()
    return corners


def held(unit: Unit, rng: Rng) -> Board:
    """A board that is wholly in the picture, tilted by up to 45 deg."""
    lens = unit.device.lens
    while True:
        T = np.eye(4)
        axis = np.array([*rng.standard_normal(2), 0.0])
        tilt = np.deg2rad(rng.uniform(5, 45)) * axis / np.linalg.norm(axis)
        spin = Rotation.from_rotvec([0, 0, np.deg2rad(rng.uniform(-35, 35))])
        T[:3, :3] = (Rotation.from_rotvec(tilt) * spin).as_matrix()
        z = rng.uniform(0.42, 0.95)
        middle = lens.rays()[int(rng.integers(lens.height)), int(rng.integers(lens.width))] * z
        half = np.array([COLUMNS - 1, ROWS - 1, 0]) * SQUARE / 2
        T[:3, 3] = middle - T[:3, :3] @ half
        board = Board(T)
        outer = np.array([[s, t, 0] for s in (-1, COLUMNS) for t in (-1, ROWS)]) * SQUARE
        seen = lens.pixels(outer @ T[:3, :3].T + T[:3, 3])
        if (seen > 3).all() and (seen < [lens.width - 4, lens.height - 4]).all():
            return board


def _walls(unit: Unit, folder: Path, stated: dict[str, Any], rays: list[Array], rng: Rng) -> None:
    """Nearly frontal walls; `distance_m` is along the optical axis, as the laser has it."""
    for k, z in enumerate(unit.walls):
        tilt = np.deg2rad(rng.uniform(-4, 4, 2))
        normal = Rotation.from_euler("xy", tilt).apply([0, 0, -1.0])
        wall = Recording(folder / f"wall_{k:02d}", stated)
        depths, ir = unit.device.frames(Plane(normal, float(z)), STILLS, rng, rays)
        times = 60 + 20 * k + np.arange(STILLS) / 30
        for time, depth in zip(times, depths, strict=True):
            wall.depth(time, depth)
        if ir is not None:
            wall.ir(times[0], ir)
        wall.done(distance_m=np.full(STILLS, z + LASER * rng.standard_normal()))


def _scan(unit: Unit, folder: Path, stated: dict[str, Any], rays: list[Array], noise: int) -> None:
    """The scan; its object alone with a true camera and nothing but noise; poses, mesh and the surface that is seen."""
    poses, truth = unit.poses(), folder / "truth"
    times = 300 + 0.5 * np.arange(len(poses))
    scan = Recording(folder / "scan", stated)
    clean = Recording(folder / "clean", unit.device.lens.fields | _kind(unit))
    few, seen, middle = np.random.default_rng(noise), [], unit.device.lens.rays()
    for i, (time, T) in enumerate(zip(times, poses, strict=True)):
        scene = unit.table.at(T)
        view = scene.look(middle)
        both = [
            unit.device.frames(scene, 1, np.random.default_rng([noise, i]), rays, ideal)[0][0]
            for ideal in (False, True)
        ]
        scan.depth(time, both[0])
        clean.depth(time, np.where(view.part == OBJECT, both[1], 0.0))
        at = np.argwhere(view.part == OBJECT)
        v, u = few.permutation(at)[:SEEN].T
        points = view.z[v, u, None] * middle[v, u]
        seen.append(points @ T[:3, :3].T + T[:3, 3])
    scan.done(turntable_deg=np.rad2deg(unit.turning.logged - unit.turning.logged[0]))
    clean.done()
    trajectory(truth / "poses.txt", times, poses)
    unit.table.item.mesh.export(truth / "truth.ply")
    np.savez(truth / "visible.npz", points=np.concatenate(seen).astype(np.float32))
