"""Depth that lies beside colour whose stated camera stands, or the other way round: the camera brought to the depth.

Numbers of cameras are counted from the image's corner here, where a quarter turn is without halves of pixels.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.errors import RecordingError
from fusion.geometry.camera import Camera
from fusion.geometry.pose import Array, inverse, transform
from fusion.geometry.trajectory import Trajectory
from fusion.recording.cameras.turned import LEFT, LOOKED_AT, fit_of, looks_of

FEW = 500  # pixels that two frames must share to tell whose poses they have
BETTER = 0.5  # frames agree so much better by the poses of one camera than by those of the other (guess)
POINTS = 5000  # about so many of a frame are laid over another


@dataclass(frozen=True)
class Laid:
    """Intrinsics (n, 4) fx, fy, cx, cy [px from the corner] of images of `size` (width, height), once these were turned
    by quarter turns against the clock, and the pictures by `pictures` of these; what to tell."""

    stated: Array
    size: tuple[int, int]
    turn: int = 0
    pictures: int = 0
    told: tuple[str, ...] = ()


def in_proportion(one: tuple[int, int], other: tuple[int, int]) -> bool:
    """True where one image is the other evenly resized, to a pixel of the smaller one."""
    (a, b), (c, d) = one, other
    return abs(a * d - b * c) <= max(min(a, c), min(b, d))


def out_of_proportion(depth: tuple[int, int], color: tuple[int, int], where: object) -> RecordingError:
    """What is said where a depth camera would be a colour camera squeezed; (width, height), and what is named."""
    found = "depth of {} x {}, colour of {} x {} pixels".format(*depth, *color)
    do = "pass --camera fx,fy,cx,cy of the depth images"
    return RecordingError("depth and colour are of other shapes", where, found, "sides in proportion", do)


def laid_as_depth(
    stated: Array,
    size: tuple[int, int],
    depth: Callable[[int], NDArray[np.float32]],
    depth_size: tuple[int, int],
    color: Callable[[int], NDArray[np.uint8] | None],
    asked: int,
    where: object,
) -> Laid:
    """The stated cameras as the depth images lie.

    Args:
        stated: (n, 4) fx, fy, cx, cy [px from the corner] of each frame.
        size: (width, height) that these are of.
        depth: the depth (h, w) [m] of a frame.
        depth_size: (width, height) of these.
        color: the picture of a frame as it is stored, or None.
        asked: the quarter turns that its notes (EXIF) ask for.

    Raises:
        RecordingError: sides are not in proportion in either way, or it is not clear which way they are to be turned.
    """
    if in_proportion(depth_size, size):
        return Laid(stated, size)
    (a, b), (c, d) = depth_size, size
    turn = pictures = 0
    if in_proportion(depth_size, size[::-1]):
        looks = looks_of(np.arange(len(stated)), color, depth)
        lie = looks and in_proportion(looks[0][1].shape[1::-1], depth_size)
        # pictures that are stored as the depth lies and shown as their camera stands say it themselves
        turn = -asked % 4 if lie else fit_of(looks, Camera(a, b, 1.0, 1.0, 0.0, 0.0)).turn
        pictures = 0 if lie else turn
    if turn not in (1, 3):
        raise out_of_proportion(depth_size, size, where)
    why = "rims in depth are seen so (a guess)" if pictures else "the notes (EXIF) of the images say"
    told = f"depth of {a} x {b} pixels is the other way round than colour of {c} x {d}: this and its camera are turned"
    way = "left" if turn == LEFT else "right"
    return Laid(turned_numbers(stated, size, turn), size[::-1], turn, pictures, (f"{told} to the {way}, as {why}",))


def turned_numbers(stated: Array, size: tuple[int, int], turn: int) -> Array:
    """fx, fy, cx, cy (n, 4) [px from the corner] of images of `size`, turned once to the left (1) or the right (3)."""
    fx, fy, cx, cy = np.asarray(stated, float).T
    across, down = (cy, size[0] - cx) if turn == LEFT else (size[1] - cy, cx)
    return np.stack([fy, fx, across, down], axis=1)


def poses_laid(
    poses: Trajectory, turn: int, depth: Callable[[int], NDArray[np.float32]], camera: Camera
) -> tuple[Trajectory, list[str]]:
    """The poses of the depth camera, where a file's may be those of the colour camera before its images were turned.

    Frames lie over each other by the right ones.

    Args:
        poses: one for each frame.
        turn: quarter turns of the colour images.
        depth: (h, w) [m] of a frame; raises RecordingError.
    """
    sign = 1.0 if turn == LEFT else -1.0
    T_color_depth = np.eye(4)
    T_color_depth[:2, :2] = [[0.0, -sign], [sign, 0.0]]  # to the left: x' = y, y' = -x
    other = Trajectory(poses.timestamps, poses.poses @ T_color_depth)
    of_depth, of_color = (_apart(one, depth, camera) for one in (poses, other))
    if of_color < BETTER * of_depth:
        return other, ["poses are those of the colour images before the turn: frames fit each other so"]
    clear = of_depth < BETTER * of_color
    return poses, [] if clear else ["poses are taken for the depth camera's: frames do not tell whose they are"]


def _apart(poses: Trajectory, depth: Callable[[int], NDArray[np.float32]], camera: Camera) -> float:
    """Median difference of depth between frames that are laid over each other, as a share of it; infinite: unknown."""
    known = np.flatnonzero(np.isfinite(poses.poses).all(axis=(1, 2)))
    chosen = known[np.unique(np.linspace(0, len(known) - 1, LOOKED_AT).round().astype(int))] if len(known) else known
    seen = {int(i): z for i in chosen if (z := _readable(depth, int(i))) is not None}
    off = [_between(seen[i], seen[j], inverse(poses.poses[j]) @ poses.poses[i], camera)
           for i in seen for j in seen if i != j]  # fmt: skip
    off = [one for one in off if len(one) >= FEW]
    return float(np.median(np.concatenate(off))) if off else float("inf")


def _between(one: NDArray[np.float32], other: NDArray[np.float32], T_other_one: Array, camera: Camera) -> Array:
    stride = max(1, round((camera.width * camera.height / POINTS) ** 0.5))
    points = camera.points(one)[::stride, ::stride].reshape(-1, 3).astype(float)
    points = transform(T_other_one, points[np.isfinite(points).all(axis=1)])
    points = points[points[:, 2] > 0]
    u, v = np.rint(camera.project(points)).T
    inside = (u >= 0) & (u < camera.width) & (v >= 0) & (v < camera.height)
    there = other[v[inside].astype(int), u[inside].astype(int)]
    off = np.abs(there - points[inside, 2]) / points[inside, 2]
    return np.asarray(off[np.isfinite(off)], float)


def _readable(depth: Callable[[int], NDArray[np.float32]], index: int) -> NDArray[np.float32] | None:
    try:
        return depth(index)
    except RecordingError:  # told by the frame that is asked for
        return None
