"""What a recording, as the program opens it, says of the scene: size, place, hand, poses, colour, clock."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.ndimage import maximum_filter, minimum_filter
from scipy.spatial.transform import Rotation

from tools.formats.boxes import planes, seen, way
from tools.formats.take import Array, Lens, Take

EDGE = 2  # pixels beside another surface that are left out
# what an image can be turned into: as it is, mirrored, upside down, turned, and the same with columns for rows
HANDS = {
    "right": np.diag([1.0, 1, 1]), "mirrored": np.diag([-1.0, 1, 1]), "upside down": np.diag([1.0, -1, 1]),
    "turned by 180 deg": np.diag([-1.0, -1, 1]), "transposed": np.array([[0.0, 1, 0], [1, 0, 0], [0, 0, 1]]),
    "turned by 90 deg": np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]]),
    "turned by -90 deg": np.array([[0.0, 1, 0], [-1, 0, 0], [0, 0, 1]]),
    "transposed, turned": np.array([[0.0, -1, 0], [-1, 0, 0], [0, 0, 1]]),
}  # fmt: skip


@dataclass(frozen=True)
class Found:
    """Errors of a recording; NaN where it has none of it.

    Attributes:
        size_pct: of width, height and depth the worst [%]; place_px: of the principal point [px].
        spread_mm: rms of what is left, mostly rounding. hand: which way round the points fit the scene.
        turn_deg, shift_mm: worst of the poses between frames. color_px: of colour beside depth, worst of the medians.
        clock_us: worst of the times between frames, frames that are missing counted as such.
    """

    size_pct: float
    place_px: float
    spread_mm: float
    hand: str
    turn_deg: float
    shift_mm: float
    color_px: float
    clock_us: float
    frames: int


def found(recording: Any, take: Take) -> Found:
    """The recording beside what was taken."""
    truth = way_of(take)
    clouds = [recording.camera.points(recording[i].depth).astype(float) for i in range(len(recording))]
    gross = gross_size(clouds, take)  # a wrong unit: the rest is measured with it taken out
    clouds = [cloud / gross for cloud in clouds]
    hand = min(
        HANDS, key=lambda name: sum(misfit(c @ HANDS[name].T, take, T) for c, T in zip(clouds, truth, strict=False))
    )
    turned = [cloud @ HANDS[hand].T for cloud in clouds]
    rows, left = zip(*(equations(c, take, T) for c, T in zip(turned, truth, strict=False)), strict=True)
    A, r = np.concatenate(rows), np.concatenate(left)
    x = np.linalg.lstsq(A, r, rcond=None)[0]
    spread = float(np.sqrt(np.mean((r - A @ x) ** 2)))
    turn, shift = poses(recording, truth) if take.poses is not None else (np.nan, np.nan)
    return Found(
        float(100 * np.abs(gross * (1 + x[:3]) - 1).max()), float(np.hypot(*x[3:])), 1000 * spread, hand, turn, shift,
        color(recording, take), clock(recording, take), len(recording),
    )  # fmt: skip


def gross_size(clouds: list[Array], take: Take) -> float:
    """How many times too large it is, where that is more than a tenth; else 1."""
    mine = np.concatenate([cloud[..., 2].ravel() for cloud in clouds])
    ratio = float(np.nanmedian(mine) / np.median(take.depth[take.depth > 0]))
    return ratio if abs(ratio - 1) > 0.1 else 1.0


def way_of(take: Take) -> Array:
    """True poses, also where they are not written."""
    count = len(take.depth)
    return np.repeat(way(1), count, axis=0) if take.poses is None else take.poses


def inner(take: Take, cloud: Array, T: Array) -> tuple[Array, Array]:
    """Points (n, 3) that are well within a surface, and which it is, by the true camera's picture of the scene."""
    points = cloud.reshape(-1, 3)
    points = points[np.isfinite(points).all(axis=1) & (points[:, 2] > 0.05)]
    lens, which = take.lens, face_image(take.lens, T)
    at = np.rint(lens.project(points)).astype(int)
    good = ((at >= 0) & (at < [lens.width, lens.height])).all(axis=1)
    points, at = points[good], at[good]
    face = which[at[:, 1], at[:, 0]]
    return points[face >= 0], face[face >= 0]


_faces: dict[tuple, Array] = {}


def face_image(lens: Lens, T: Array) -> Array:
    """(h, w) index of the plane, -1 at edges."""
    key = (lens, T.tobytes())
    if key not in _faces:
        which = seen(lens.rays(), T)[1]
        width = 2 * EDGE + 1
        _faces[key] = np.where(maximum_filter(which, width) == minimum_filter(which, width), which, -1)
    return _faces[key]


def behind(points: Array, face: Array, T: Array) -> tuple[Array, Array]:
    """Distances (n,) [m] of camera points from their planes, and the planes' normals in the camera (n, 3)."""
    all_planes = planes()
    n = np.stack([p.n for p in all_planes])[face] @ T[:3, :3]
    d = np.array([p.d - p.n @ T[:3, 3] for p in all_planes])[face]
    return (points * n).sum(axis=1) - d, n


def misfit(cloud: Array, take: Take, T: Array) -> float:
    """Median distance [m], large where hardly a point meets the scene."""
    points, face = inner(take, cloud, T)
    return 1.0 if len(points) < 500 else float(np.median(np.abs(behind(points, face, T)[0])))


def equations(cloud: Array, take: Take, T: Array) -> tuple[Array, Array]:
    """Rows for the errors of width, height and depth (shares) and of the principal point [px]; distances [m]."""
    points, face = inner(take, cloud, T)
    distance, n = behind(points, face, T)
    z = points[:, 2]
    across = np.stack([n[:, 0] * z / take.lens.fx, n[:, 1] * z / take.lens.fy], axis=1)
    near = np.abs(distance) < 0.05
    return np.hstack([n * points, across])[near], distance[near]


def poses(recording: Any, truth: Array) -> tuple[float, float]:
    """Worst turn [deg] and shift [mm] between the first frame and each other."""
    if recording.poses is None:
        return float("nan"), float("nan")
    stated = recording.poses.at(recording.timestamps).poses
    apart = [np.linalg.inv(T) @ (np.linalg.inv(stated[0]) @ stated[i]) for i, T in
             enumerate(np.linalg.inv(truth[0]) @ truth)]  # fmt: skip
    turns = [np.rad2deg(np.linalg.norm(Rotation.from_matrix(T[:3, :3]).as_rotvec())) for T in apart]
    return float(max(turns)), float(1000 * max(np.linalg.norm(T[:3, 3]) for T in apart))


def color(recording: Any, take: Take) -> float:
    """Where colour lies beside where it should [px of colour], read from its ramps at the program's own points."""
    if take.color is None or take.color_lens is None:
        return float("nan")
    worst = []
    for i in range(len(recording)):
        frame = recording[i]
        if frame.color is not None:
            v, u = np.mgrid[: frame.depth.shape[0], : frame.depth.shape[1]]
            pixels, picture = np.stack([u, v], axis=-1).reshape(-1, 2).astype(float), frame.color
        elif recording.color_is_apart and (picture := recording.color_apart(i)) is not None:
            points = recording.camera.points(frame.depth).reshape(-1, 3).astype(float)
            points = points[np.isfinite(points).all(axis=1)]
            T, camera = recording.camera.T_color_depth, recording.camera.color
            moved = points if T is None else points @ T[:3, :3].T + T[:3, 3]
            pixels = camera.project(moved)
        else:
            return float("nan")
        worst.append(ramp_error(picture, pixels, points_of(recording, frame, pixels), take))
    return float(max(worst))


def points_of(recording: Any, frame: Any, pixels: Array) -> Array:
    """The program's points (n, 3) that belong to the pixels."""
    points = recording.camera.points(frame.depth).reshape(-1, 3).astype(float)
    return points if len(points) == len(pixels) else points[np.isfinite(points).all(axis=1)]


def ramp_error(picture: Array, pixels: Array, points: Array, take: Take) -> float:
    """Median over the image of what red and green tell beside where the true colour camera sees the points [px]."""
    lens = take.color_lens
    assert lens is not None
    h, w = picture.shape[:2]
    with np.errstate(invalid="ignore"):
        at = np.rint(np.nan_to_num(pixels, nan=-1)).astype(int)
        good = ((at >= 0) & (at < [w, h])).all(axis=1) & np.isfinite(points).all(axis=1)
    moved = points[good] @ take.T_color_depth[:3, :3].T + take.T_color_depth[:3, 3]
    true = lens.project(moved)
    at, sub = at[good], pixels[good] - at[good]
    told = (picture[at[:, 1], at[:, 0], :2].astype(float) - 20) / 200 * [lens.width, lens.height]
    return float(np.abs(np.median(told + sub * [lens.width / w, lens.height / h] - true, axis=0)).max())


def clock(recording: Any, take: Take) -> float:
    """Worst error [us] of the times since the first frame."""
    mine = np.asarray(recording.timestamps, float)
    if len(mine) != len(take.stamps):
        return float("nan")
    return float(1e6 * np.abs((mine - mine[0]) - (take.stamps - take.stamps[0])).max())
