"""Colour images that stand beside a camera that lies, or the other way round: which quarter turn makes them fit.

Rims in depth are seen in colour; of the two turns only one brings the one over the other.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.errors import RecordingError
from fusion.geometry.camera import Camera
from fusion.geometry.pose import transform
from fusion.recording.images.read import other_way

T = TypeVar("T")
Look = tuple[NDArray[np.float32], NDArray[np.uint8]]  # depth (h, w) [m] and colour of a frame
LEFT, RIGHT = 1, 3  # quarter turns against the clock, as numpy.rot90 counts them
LOOKED_AT = 5  # frames
STEP = 0.03  # of the depth: more from one pixel to the next is a rim
ALONG = 128  # pixels along the longer side of the images that are compared
SHIFTS = (-0.3, -0.2, -0.12, 0.0, 0.12, 0.2, 0.3)  # of a side: how well rims lie over colour by chance
# standard deviations of chance, of the better turn and over the other (guesses). Of four recordings turned by hand 24
# of 32 tries were clear and none was wrong; of depth beside another recording's colour none of 48 was clear
SURE, CLEAR = 3.0, 2.0


@dataclass(frozen=True)
class RimFit:
    """How well rims lie over edges of colour for each turn, in standard deviations of chance; `turn` 0: not clear."""

    left: float
    right: float

    @property
    def turn(self) -> int:
        best, other = max(self.left, self.right), min(self.left, self.right)
        if best < SURE or best - other < CLEAR:
            return 0
        return LEFT if self.left > self.right else RIGHT


def turned(picture: NDArray[np.uint8], shape: tuple[int, int], turn: int) -> NDArray[np.uint8]:
    """An image (h, w, 3) by quarter turns against the clock, where it has the sides of `shape` the other way round."""
    fits = not turn or not other_way(picture.shape[:2], shape)
    return picture if fits else np.ascontiguousarray(np.rot90(picture, turn))


def found_turn(
    has_color: NDArray[np.bool_],
    color: Callable[[int], NDArray[np.uint8] | None],
    depth: Callable[[int], NDArray[np.float32]],
    camera: Camera,
    stored: tuple[int, int] | None = None,
) -> tuple[int | None, list[str]]:
    """Quarter turns that make colour images fit, and what to tell; 0 where they fit as they come, None: not clear.

    Args:
        has_color: (n,) frames that have some.
        color: the image (h, w, 3) of a frame; raises RecordingError.
        depth: the depth (h, w) [m] of a frame; raises RecordingError.
        camera: of depth; its `color` where colour has pixels of its own.
        stored: (height, width) of the first image before its notes (EXIF) turned it, where that is known.
    """
    wanted = (camera.color or camera).shape
    known = np.flatnonzero(has_color)
    if not len(known) or wanted[0] == wanted[1] or stored == wanted:
        return 0, []
    first = _read(color, int(known[0]))
    if first is None:
        return 0, []
    h, w = first.shape[:2] if stored is None else stored
    told = f"colour images of {w} x {h} pixels are the other way round than their camera's {wanted[1]} x {wanted[0]}"
    if not other_way(first.shape[:2], wanted):
        asked = first.shape[:2] == wanted and other_way((h, w), wanted)
        return 0, [f"{told}: turned as their notes (EXIF) say"] * asked
    looks = [one for one in looks_of(known, color, depth) if other_way(one[1].shape[:2], wanted)]
    fit = fit_of(looks, camera)
    if not fit.turn:
        return None, [f"{told}, and which way is not clear: left out; turn them by 90 degrees and open it again"]
    way = "left" if fit.turn == LEFT else "right"
    return fit.turn, [f"{told}: turned by 90 degrees to the {way}, as rims in depth are seen so (a guess)"]


def looks_of(
    frames: NDArray[np.intp],
    color: Callable[[int], NDArray[np.uint8] | None],
    depth: Callable[[int], NDArray[np.float32]],
) -> list[Look]:
    """Depth and colour of a few of the frames (n,), of those that have both and can be read."""
    some = frames[np.unique(np.linspace(0, len(frames) - 1, LOOKED_AT).round().astype(int))] if len(frames) else frames
    both = ((_read(depth, i), _read(color, i)) for i in some.tolist())
    return [(z, shown) for z, shown in both if z is not None and shown is not None]


def _read(load: Callable[[int], T | None], index: int) -> T | None:
    try:
        return load(index)
    except RecordingError:  # told by the frame that is asked for
        return None


def fit_of(looks: Sequence[Look], camera: Camera) -> RimFit:
    """Of a few frames' depth (h, w) [m] and colour (W, H, 3) as it is stored.

    Args:
        looks: depth and colour; none: not clear.
        camera: of depth; its `color` where colour has pixels of its own.
    """
    found = np.array([_one(depth, color, camera) for depth, color in looks]).reshape(-1, 2, len(SHIFTS) ** 2)
    found = found[np.isfinite(found).all(axis=(1, 2))]
    if not len(found):
        return RimFit(0.0, 0.0)
    left, right = (_beside_chance(one) for one in found.mean(axis=0))
    return RimFit(left, right)


def _one(depth: NDArray[np.float32], color: NDArray[np.uint8], camera: Camera) -> list[list[float]]:
    """For both turns: mean edge under the rims, as they lie and moved elsewhere."""
    step = max(1, round(max(depth.shape) / ALONG))
    rims = _rims(depth)[::step, ::step]
    pixels = _pixels(depth, camera)[::step, ::step].astype(np.float32)
    edges = _edges(color)
    found = []
    for turn in (LEFT, RIGHT):
        turned = np.ascontiguousarray(np.rot90(edges, turn))
        at = pixels * (np.array(turned.shape[::-1]) / _size(camera)).astype(np.float32)
        seen: NDArray = cv2.remap(turned, at[..., 0], at[..., 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT,
                         borderValue=float("nan"))  # fmt: skip
        found.append(_under(seen, rims))
    return found


def _size(camera: Camera) -> NDArray[np.float64]:
    seen_by = camera.color or camera
    return np.array([seen_by.width, seen_by.height], float)


def _pixels(depth: NDArray[np.float32], camera: Camera) -> NDArray[np.float64]:
    """(h, w, 2) where in colour each pixel of depth lies; far outside where there is no depth."""
    h, w = depth.shape
    if camera.color is None:
        v, u = np.mgrid[:h, :w].astype(float)
        return np.stack([u, v], axis=-1)
    points = camera.points(depth).reshape(-1, 3).astype(float)
    if camera.T_color_depth is not None:
        points = transform(camera.T_color_depth, points)
    good = np.isfinite(points).all(axis=1) & (points[:, 2] > 0)
    pixels = np.full((h * w, 2), -1e6)
    pixels[good] = camera.color.project(points[good])
    return pixels.reshape(h, w, 2)


def _rims(depth: NDArray[np.float32]) -> NDArray[np.bool_]:
    """(h, w) pixels beside a step in depth, three wide so that those of a coarser grid are met."""
    z = np.nan_to_num(depth)
    rims = np.zeros(z.shape, bool)
    for a, b in ((np.s_[:, 1:], np.s_[:, :-1]), (np.s_[1:], np.s_[:-1])):
        near = np.minimum(z[a], z[b])
        rims[a] |= (near > 0) & (np.abs(z[a] - z[b]) > STEP * near)
    step = max(1, round(max(depth.shape) / ALONG))
    return cv2.dilate(rims.astype(np.uint8), np.ones((step, step), np.uint8)).astype(bool)


def _edges(color: NDArray[np.uint8]) -> NDArray[np.float32]:
    """How strong the edges of an image (about 128 long) are, by their rank, 0 to 1."""
    share = ALONG / max(color.shape[:2])
    small = cv2.resize(color, None, fx=share, fy=share, interpolation=cv2.INTER_AREA).astype(np.float32)
    across, down = cv2.Sobel(small, cv2.CV_32F, 1, 0), cv2.Sobel(small, cv2.CV_32F, 0, 1)
    strength = np.sqrt((across**2 + down**2).sum(axis=2))
    rank = np.empty(strength.size, np.float32)
    rank[np.argsort(strength, axis=None, kind="stable")] = np.linspace(0, 1, strength.size)
    return np.asarray(cv2.dilate(rank.reshape(strength.shape), np.ones((3, 3), np.uint8)), np.float32)


def _under(seen: NDArray, rims: NDArray[np.bool_]) -> list[float]:
    """Mean edge under the rims for each of the shifts; NaN where there are too few."""
    h, w = rims.shape
    found = []
    for down in SHIFTS:
        for across in SHIFTS:
            moved = np.roll(rims, (round(down * h), round(across * w)), axis=(0, 1))
            under = seen[moved & np.isfinite(seen)]
            found.append(float(under.mean()) if len(under) >= 30 else float("nan"))
    return found


def _beside_chance(under: NDArray[np.float64]) -> float:
    """The unmoved one beside the moved ones, in their standard deviations."""
    middle = len(under) // 2
    chance = np.delete(under, middle)
    return float((under[middle] - chance.mean()) / max(float(chance.std()), 1e-6))
