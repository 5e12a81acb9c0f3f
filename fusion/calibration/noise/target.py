"""A flat target in an image: found by itself, with the parts of it that each measurement may use."""

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.errors import FusionError
from fusion.geometry.camera import Camera

Image = NDArray[np.floating]

JUMP = 0.03  # share of the depth: a step to a neighbour that is no tilt, even at 75 deg and 365 px focal length
SMALLEST = 400  # [px] a target of fewer pixels has no inside
MARGIN = 0.12  # of width and height of the target that the inside keeps away from its border


@dataclass(frozen=True)
class FlatTarget:
    """Where a flat target is, and how it stands."""

    mask: NDArray[np.bool_]  # (h, w) its pixels
    # rows, columns: first and last + 1 of the rectangle inside it, margins left out
    rows: tuple[int, int]
    columns: tuple[int, int]
    # normal, distance: its plane n . p = distance [m] in the camera frame, n towards the camera (distance < 0).
    normal: NDArray[np.float64]
    distance: float

    @property
    def inside(self) -> tuple[slice, slice]:
        """The rectangle as an index of an image."""
        return slice(*self.rows), slice(*self.columns)

    def plane_depth(self, camera: Camera) -> NDArray[np.float64]:
        """(h, w) depth of the plane along every pixel's ray [m]."""
        rays = np.dstack([camera.rays(), np.ones(camera.shape)])
        return self.distance / (rays @ self.normal)

    def tilt(self, camera: Camera) -> NDArray[np.float64]:
        """(h, w) angle between the pixels' rays and the normal [rad]."""
        rays = np.dstack([camera.rays(), np.ones(camera.shape)])
        return np.arccos(np.clip(-(rays @ self.normal) / np.linalg.norm(rays, axis=2), -1, 1))


def find_target(depth: Image, camera: Camera, smallest: int = SMALLEST) -> FlatTarget:
    """The flat thing in the middle of a depth image (h, w) [m], better a mean of many frames.

    Its pixels hang together without a step; the piece nearest the middle of the image is taken.
    FusionError when there is none.
    """
    mask = _middle_piece(depth, smallest)
    box = _inside(mask)
    normal, distance = _plane(camera.points(np.where(mask, depth, np.nan))[box])
    return FlatTarget(mask, (box[0].start, box[0].stop), (box[1].start, box[1].stop), normal, distance)


def fit_plane(depth: Image, camera: Camera, target: FlatTarget) -> FlatTarget:
    """The same pixels with the plane of another depth image (h, w) [m], for instance a corrected one."""
    normal, distance = _plane(camera.points(np.where(target.mask, depth, np.nan))[target.inside])
    return replace(target, normal=normal, distance=distance)


def _middle_piece(depth: Image, smallest: int) -> NDArray[np.bool_]:
    """(h, w) the piece without steps that has its centre nearest to that of the image."""
    known = np.isfinite(depth)
    torn = ~known
    filled = np.where(known, depth, 0.0).astype(np.float32)
    limit = JUMP * np.where(known, depth, np.inf)
    for axis in (0, 1):
        step = np.abs(np.diff(filled, axis=axis)) > np.delete(limit, 0, axis)
        torn |= np.insert(step, 0, False, axis=axis)
    # erosion cuts the thin bridges that noise builds; the dilation gives the border back
    solid = cv2.erode((~torn).astype(np.uint8), np.ones((3, 3), np.uint8))
    count, label, stats, _ = cv2.connectedComponentsWithStats(solid, connectivity=4)
    big = [i for i in range(1, count) if stats[i, cv2.CC_STAT_AREA] >= smallest]
    if not big:
        raise FusionError(
            "no target found",
            found=f"no piece of {smallest} px without steps",
            expected="a flat thing that stands free in the middle of the image",
            do="move it nearer, or away from what is behind it",
        )
    middle = np.array(depth.shape[::-1]) / 2
    best = min(big, key=lambda i: _reach(label == i, middle))
    piece = cv2.dilate((label == best).astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
    return piece & known


def _reach(piece: NDArray[np.bool_], middle: NDArray[np.float64]) -> float:
    """Distance [px] from the middle of the image to the piece, then to its centre."""
    v, u = np.nonzero(piece)
    return float(
        np.hypot(u - middle[0], v - middle[1]).min() + 1e-3 * np.hypot(u.mean() - middle[0], v.mean() - middle[1])
    )


def _inside(mask: NDArray[np.bool_]) -> tuple[slice, slice]:
    """The largest rectangle of the bounding box's shape about its centre that holds target only, less margins."""
    solid = cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_CLOSE, np.ones((5, 5), np.uint8))
    left, top, width, height = cv2.boundingRect(solid)
    total = cv2.integral(solid)
    for share in np.linspace(1.0, 0.2, 41):
        h, w = max(int(share * height), 1), max(int(share * width), 1)
        v, u = top + (height - h) // 2, left + (width - w) // 2
        if total[v + h, u + w] - total[v, u + w] - total[v + h, u] + total[v, u] >= 0.995 * h * w:
            break
    dv, du = max(int(MARGIN * h), 1), max(int(MARGIN * w), 1)
    return slice(v + dv, v + h - dv), slice(u + du, u + w - du)


def _plane(points: NDArray[np.floating]) -> tuple[NDArray[np.float64], float]:
    """Normal (3,) and distance [m] of the plane through points (..., 3) that may hold NaN.

    Along the ray (x, y, 1) a plane is 1 / z = a x + b y + c, linear, and the noise is in z alone: a fit of distances
    to the plane would turn a steep target.
    """
    p = points.reshape(-1, 3).astype(float)
    p = p[np.isfinite(p).all(axis=1)]
    if len(p) < 30:
        raise FusionError("the target has no inside", found=f"{len(p)} px with a depth", expected="30 or more")
    keep = np.ones(len(p), bool)
    for _ in range(3):
        q = p[keep]
        # an error of z is one of z^2 times as much in 1 / z
        A = np.column_stack([q[:, 0], q[:, 1], q[:, 2]]) * q[:, 2:]
        a = np.linalg.lstsq(A, q[:, 2], rcond=None)[0]
        off = np.abs(p[:, 2] - p[:, 2] / (p @ a))
        keep = off <= 4 * np.sqrt((off[keep] ** 2).mean()) + 1e-9
    length = float(np.linalg.norm(a))
    return -a / length, -1.0 / length
