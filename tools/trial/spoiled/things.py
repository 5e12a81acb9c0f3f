"""Spoils of what is in the picture: a box before the wall, a person who passes."""

from dataclasses import replace

import cv2
import numpy as np

from tools.trial.spoiled.case import Case, Rng, Spoiled, Told, some, with_recordings
from tools.trial.spoiled.folder import Array, Taken, counted
from tools.trial.spoiled.geometry.motion import nudged

NEAREST = 0.4  # [m] before the camera: nearer, nobody puts a thing


def box_before(case: Case, rng: Rng) -> Spoiled:
    """A box in 1 to 3 recordings, in the depth and the infrared and not in the mesh."""
    changed, texts = {}, []
    for i in some(case, rng, 3):
        taken = case.recordings[i]
        size = rng.uniform(0.08, 0.35, 3)
        away, T_camera_box = _place(taken, size, rng)
        z = np.minimum(entered(taken.rays(), T_camera_box, size), _middle(taken))
        depth = np.array([hidden(frame, z, taken) for frame in taken.depth])
        infrared = [(t, lit(image, taken.depth, z)) for t, image in taken.infrared]
        changed[i] = replace(taken, depth=depth, infrared=infrared)
        texts.append(f"{taken.name} {100 * size[0]:.0f} cm at -{100 * away:.0f} cm")
    names = tuple(case.recordings[i].name for i in changed)
    told = Told("|".join(["object|clutter|outlier|before the|not in the mesh", *names]), outliers=names)
    return Spoiled(with_recordings(case, changed), ", ".join(texts), told)


def person_passing(case: Case, rng: Rng) -> Spoiled:
    """Somebody walks across 1 to 4 frames of 1 to 3 recordings: an upright ellipse, 1.2 m/s or slower."""
    changed, texts = {}, []
    for i in some(case, rng, 3):
        taken = case.recordings[i]
        depth, count = taken.depth.copy(), int(rng.integers(1, 5))
        first = int(rng.integers(0, max(len(depth) - count, 0) + 1))
        distance = max(float(np.nanmedian(depth)) - rng.uniform(0.4, 1.2), NEAREST)
        middle, speed = rng.uniform(-0.3, 0.3), rng.uniform(0.4, 1.2) * rng.choice([-1, 1])
        for k in range(first, min(first + count, len(depth))):
            x = middle + speed * min(float(taken.times[k] - taken.times[first]), 0.2)
            depth[k] = hidden(depth[k], _body(taken.rays(), x, distance), taken)
        changed[i] = replace(taken, depth=depth)
        texts.append(f"{taken.name} {count} frames at {distance:.1f} m")
    names = tuple(case.recordings[i].name for i in changed)
    told = Told("|".join(["pass|outlier|moving|person", *names]), outliers=names)
    return Spoiled(with_recordings(case, changed), ", ".join(texts), told)


def entered(rays: Array, T_camera_box: Array, size: Array) -> Array:
    """(h, w) z [m] where rays (z = 1) enter a box of edges `size` about its centre; inf where they miss it."""
    origin = -T_camera_box[:3, :3].T @ T_camera_box[:3, 3]
    ways = rays @ T_camera_box[:3, :3]
    with np.errstate(divide="ignore", invalid="ignore"):
        a, b = (-size / 2 - origin) / ways, (size / 2 - origin) / ways
    near, far = np.minimum(a, b).max(axis=-1), np.maximum(a, b).min(axis=-1)
    return np.where((near < far) & (near > 0), near, np.inf)


def hidden(frame: Array, z: Array, taken: Taken) -> Array:
    """The frame (h, w) with a surface at z (h, w) before it; what is noise there grows as z does, or as its square."""
    middle = _middle(taken)
    power = 1 if taken.camera.get("principle") == "itof" else 2
    before = z < np.nan_to_num(middle, nan=-np.inf)
    noise = np.nan_to_num(frame - middle) * (np.where(before, z, 1.0) / np.nan_to_num(middle, nan=1.0)) ** power
    thing = counted(np.where(before, z, 0.0) + noise, taken.camera)
    return np.where(before & np.isfinite(frame), thing, frame)


def lit(image: Array, depth: Array, z: Array) -> Array:
    """Infrared (h, w) of what stands nearer: by the square of the distance, grey where the wall was grey."""
    wall = np.nanmedian(depth)
    nearer = np.isfinite(z) & (z < wall)
    return np.where(nearer, np.minimum(image * (wall / np.where(nearer, z, wall)) ** 2, 60000.0), image)


def _middle(taken: Taken) -> Array:
    """(h, w) mean of the frames where they are valid, NaN elsewhere."""
    valid = np.isfinite(taken.depth)
    with np.errstate(invalid="ignore"):
        return np.asarray(np.where(valid, taken.depth, 0.0).sum(axis=0) / valid.sum(axis=0))


def _place(taken: Taken, size: Array, rng: Rng) -> tuple[float, Array]:
    """How far before the wall [m], and the pose of the box, in the middle two thirds of the image."""
    h, w = taken.depth.shape[1:]
    v, u = int(rng.uniform(0.2, 0.8) * h), int(rng.uniform(0.2, 0.8) * w)
    around = taken.depth[:, max(v - 8, 0) : v + 8, max(u - 8, 0) : u + 8]
    wall = float(np.nanmedian(around)) if np.isfinite(around).any() else float(np.nanmedian(taken.depth))
    away = min(float(rng.uniform(0.15, 0.6)), max(wall - NEAREST - size[2] / 2, 0.1))
    T = np.eye(4)
    T[:3, :3] = cv2.Rodrigues(rng.uniform(-0.6, 0.6, 3))[0]
    T[:3, 3] = taken.rays()[v, u] * (wall - away)
    return away, nudged(T, np.zeros(6))


def _body(rays: Array, x: float, distance: float) -> Array:
    """(h, w) z [m] of an elliptic cylinder 0.44 m wide, upright in the camera's axes; inf beside it."""
    half = 0.22
    across = (rays[..., 0] * distance - x) / half
    bulge = 0.12 * np.sqrt(np.clip(1 - across**2, 0, None))
    return np.where(np.abs(across) < 1, distance - bulge, np.inf)
