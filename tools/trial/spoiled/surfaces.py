"""Spoils of surfaces and of the camera's rest: walls that are bowed unsaid, frames that shake."""

from dataclasses import replace

import numpy as np

from tools.trial.spoiled.case import Case, Rng, Spoiled, Told, with_recordings
from tools.trial.spoiled.folder import Array, Taken
from tools.trial.spoiled.geometry.motion import nudged
from tools.trial.spoiled.geometry.planes import Seen, planes_of, seen

WAVES = 4


def walls_bowed(case: Case, rng: Rng) -> Spoiled:
    """Every plane bent by 0.5 to 2 mm rms."""
    return bowed_by(case, float(rng.uniform(0.5e-3, 2e-3)), rng)


def bowed_by(case: Case, size: float, rng: Rng) -> Spoiled:
    """Every plane bent by `size` [m] rms in waves of 1.5 to 6 m; no tolerance of the mesh is given.

    The same place of a wall is as high in every recording. Depth moves along the ray.
    """
    bends = [_bend(rng) for _ in range(max(len(planes_of(taken.mesh)) for taken in case.recordings))]
    changed = {}
    for i, taken in enumerate(case.recordings):
        scene = {name: value for name, value in taken.scene.items() if name != "mesh_sigma_m"}
        changed[i] = replace(_lifted(taken, size, bends), scene=scene)
    # what was within the tolerance that is no longer given is unsaid now, too
    whole = float(np.hypot(size, case.recordings[0].scene.get("mesh_sigma_m", 0.0)))
    told = Told("shape|flat|bow|bent|mesh|wall", shape_rms_m=whole)
    return Spoiled(with_recordings(case, changed), f"bow {1000 * size:.1f} mm", told, ("reference_shape_error",))


def frames_shaken(case: Case, rng: Rng) -> Spoiled:
    """Each frame up to 1 to 5 mm and 0.6 to 3 mrad from the stated place."""
    return shaken_by(case, float(rng.uniform(0.2, 1.0)), rng)


def shaken_by(case: Case, strength: float, rng: Rng) -> Spoiled:
    """Each frame from a place of its own, up to `strength` times 5 mm and 3 mrad off, exact on planes."""
    most = strength * np.array([3e-3] * 3 + [5e-3] * 3)
    changed = {}
    for i, taken in enumerate(case.recordings):
        depth = taken.depth.copy()
        for frames, view in views(taken):
            for k in frames:
                depth[k] += view.moved(nudged(view.T, most * rng.uniform(-1, 1, 6)))
        changed[i] = replace(taken, depth=depth)
    text = f"{5 * strength:.1f} mm, {3 * strength:.1f} mrad"
    return Spoiled(with_recordings(case, changed), text, Told("shak|jitter|mov|pose"), ("pose_jitter",))


def views(taken: Taken) -> list[tuple[list[int], Seen]]:
    """The frames of each stated pose, and what they show."""
    groups: dict[bytes, list[int]] = {}
    for k in range(len(taken.times)):
        groups.setdefault(np.round(taken.pose(k), 7).tobytes(), []).append(k)
    return [(frames, seen(taken, frames[0])) for frames in groups.values()]


def _bend(rng: Rng) -> Array:
    """(k, 5): height, wave vector [rad/m], phase; the heights make a field of unit rms."""
    heights = rng.standard_normal(WAVES)
    lengths, ways = rng.uniform(1.5, 6.0, WAVES), rng.standard_normal((WAVES, 3))
    waves = 2 * np.pi * ways / np.linalg.norm(ways, axis=1, keepdims=True) / lengths[:, None]
    heights /= np.sqrt((heights**2).sum() / 2)
    return np.column_stack([heights, waves, rng.uniform(0, 2 * np.pi, WAVES)])


def _lifted(taken: Taken, size: float, bends: list[Array]) -> Taken:
    depth = taken.depth.copy()
    for frames, view in views(taken):
        height = np.zeros(view.which.shape)
        for number in np.unique(view.which[view.which >= 0]):
            inside = view.which == number
            points = view.points[inside]
            for h, x, y, z, phase in bends[number]:
                height[inside] += size * h * np.cos(points @ [x, y, z] + phase)
        depth[frames] += view.raised(height)
    return replace(taken, depth=depth)
