"""Spoils of where things are said to be: poses worse or better than stated, a camera file, a mesh of another size."""

from dataclasses import replace

import numpy as np

from tools.trial.spoiled.case import Case, Rng, Spoiled, Told, with_recordings
from tools.trial.spoiled.folder import Array, Taken, quaternion_of, rotation_of
from tools.trial.spoiled.geometry.motion import nudged
from tools.trial.spoiled.geometry.planes import planes_of
from tools.trial.spoiled.geometry.ply import changed_ply

WORSE, MODEST = (3.0, 10.0, 20.0), 0.2
SIGMA = 0.0005  # [m, rad] where a scene says none: what `fusion simulate` takes


def poses_worse(case: Case, rng: Rng) -> Spoiled:
    """Poses 3, 10 or 20 times worse than stated."""
    return poses_by(case, float(rng.choice(WORSE)), rng)


def poses_by(case: Case, k: float, rng: Rng) -> Spoiled:
    """The poses file is moved by one error per recording, k times the stated sigma on each axis."""
    moved = {i: _displaced(taken, k, rng) for i, taken in enumerate(case.recordings)}
    # the errors that were there before add up with the new ones
    told = Told("pose", pose_factor=float(np.hypot(1.0, k)))
    return Spoiled(with_recordings(case, moved), f"{k:.0f} times worse", told)


def poses_modest(case: Case, rng: Rng) -> Spoiled:
    """Sigmas of the poses stated five times too large."""
    changed = {}
    for i, taken in enumerate(case.recordings):
        poses = taken.scene["poses"]
        large = {name: poses.get(name, SIGMA) / MODEST for name in ("sigma_m", "sigma_rad")}
        changed[i] = replace(taken, scene={**taken.scene, "poses": {**poses, **large}})
    return Spoiled(with_recordings(case, changed), "sigma stated x 5", Told("pose", pose_factor=MODEST))


def centre_wrong(case: Case, rng: Rng) -> Spoiled:
    """cx or cy of camera.json off by 1 to 5 px; the depth was made by the right one."""
    return centre_by(case, str(rng.choice(["cx", "cy"])), float(rng.choice([-1, 1]) * rng.uniform(1, 5)))


def centre_by(case: Case, axis: str, by: float) -> Spoiled:
    """cx or cy of camera.json off by so many pixels."""
    told = Told(r"camera file|camera.json|principal|centre of the image|\bcx\b|\bcy\b")
    return Spoiled(_by_camera(case, {axis: by}, 1.0), f"{axis} {by:+.1f} px", told, ("principal_point",))


def focal_wrong(case: Case, rng: Rng) -> Spoiled:
    """fx and fy of camera.json off by 0.5 to 2 %."""
    by = float(rng.choice([-1, 1]) * rng.uniform(0.005, 0.02))
    case = _by_camera(case, {}, 1 + by)
    return Spoiled(case, f"f {100 * by:+.1f} %", Told(r"camera file|camera.json|focal|\bfx\b"), ("focal_length",))


def mesh_wrong(case: Case, rng: Rng) -> Spoiled:
    """The mesh 1 % too large or too small about a point 0.5 to 2 m before its first plane, as a world's origin is."""
    size = float(rng.choice([0.99, 1.01]))
    plane = planes_of(case.recordings[0].mesh)[0]
    camera = case.recordings[0].poses[0, 1:4]
    ahead = float(np.sign(camera @ plane[:3] - plane[3]) * rng.uniform(0.5, 2.0))
    origin = plane[:3] * (plane[3] + ahead)
    changed = {
        i: replace(taken, mesh=changed_ply(taken.mesh, lambda x: origin + size * (x - origin)))
        for i, taken in enumerate(case.recordings)
    }
    text = f"mesh x {size:.2f}, {1000 * abs(ahead) * 0.01:.0f} mm"
    told = Told("mesh|reference|shape|scale of the scene")
    return Spoiled(with_recordings(case, changed), text, told, ("reference_shape_error",))


def _displaced(taken: Taken, k: float, rng: Rng) -> Taken:
    stated = taken.scene["poses"]
    sizes = [stated.get("sigma_rad", SIGMA)] * 3 + [stated.get("sigma_m", SIGMA)] * 3
    motion = k * np.array(sizes) * rng.standard_normal(6)
    rows = taken.poses.copy()
    for row in rows:
        T = np.eye(4)
        T[:3, :3], T[:3, 3] = rotation_of(row[4:]), row[1:4]
        T = nudged(T, motion)
        row[1:4], row[4:] = T[:3, 3], _same_side(quaternion_of(T[:3, :3]), row[4:])
    return replace(taken, poses=rows)


def _same_side(q: Array, as_before: Array) -> Array:
    return q if q @ as_before > 0 else -q


def _by_camera(case: Case, add: dict[str, float], focal: float) -> Case:
    changed = {}
    for i, taken in enumerate(case.recordings):
        c = taken.camera
        wrong = {**c, "fx": c["fx"] * focal, "fy": c["fy"] * focal}
        wrong |= {name: c[name] + by for name, by in add.items()}
        changed[i] = replace(taken, camera=wrong)
    return with_recordings(case, changed)
