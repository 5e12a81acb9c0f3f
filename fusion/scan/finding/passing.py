"""What passes before a scanned object, as the hand that turns it: pixels of a frame whose place others look through.

A finger near the object is no visitor (turntable/turning/visitors.py) that the region leaves out, and what is behind it
takes no part in the volume, so nothing wipes it away there. Once the motion is known every frame says of the others
where nothing is.

Two frames show the same where they differ, along the normal and over some neighbours, by no more than they differ all
over: that holds the noise, what is alike in neighbours, and what the motion is wrong by.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.geometry import pose
from fusion.geometry.camera import Camera
from fusion.geometry.robust import MAD_TO_STD
from fusion.progress import each
from fusion.recording.ahead import ahead
from fusion.scan.cleaning.facing import facing
from fusion.scan.cleaning.seen import ASKED
from fusion.turntable.pairs.edges import NOISES
from fusion.turntable.views import Region, before_wall, usable
from fusion.volume.prepared import Prepared

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
SOME = 1500  # pixels of a frame that are asked: what passes is wider than what lies between them
BESIDE = np.ones((3, 3), np.uint8)


@dataclass(frozen=True)
class _Asked:
    """Pixels of a frame on a grid."""

    at: tuple[NDArray[np.intp], NDArray[np.intp]]  # rows and columns (m,) in the grid
    shape: tuple[int, int]  # of the grid
    # points, normals: (m, 3) in the object's frame [m]; back along the line of sight where a pixel has no normal
    points: Array
    normals: Array
    inner: Mask  # (m,) no rim, of which views differ by more
    beside: float  # half a pixel's width [m]: how far beside a point the pixel lies that says something of it


@dataclass(frozen=True)
class _Others:
    """Frames that are asked: poses (k, 4, 4), and which rows (k,) of the images (all, h * w) [m] are theirs.

    `nearest` has of each pixel the least depth beside it: at a rim pixels show the object or what is behind it.
    """

    poses: Array
    depths: NDArray[np.float32]
    nearest: NDArray[np.float32]
    which: NDArray[np.intp]


@dataclass(frozen=True)
class _Told:
    """How far along the normals of m pixels each of k frames shows something behind them [m]; NaN: it says nothing."""

    beyond: NDArray[np.float32]  # (k, m) median of those pixels that are asked beside each other
    nearest: NDArray[np.float32]  # (k, m) the least of what the frame shows around the place


@dataclass(frozen=True)
class _Passing:
    """Pixels (m,) that more frames look through than show, their own included."""

    some: Mask
    surely: Mask  # those that as many look through all around: no rim of the object


@dataclass(frozen=True)
class Clear:
    """Frames without what passes before the object."""

    frames: list[Prepared | None]
    pulled: float  # share of them that lost patches of which the motion is found; narrow rests pull little


def without_passing(frames: Sequence[Prepared | None], region: Region, poses: Array) -> Clear:
    """The frames without the pixels that more of the other frames look through than show.

    Args:
        frames: k of them, cut to the window of the region; points outside it say what is behind.
        region: where the object is, its images cut to the same window.
        poses: (k, 4, 4) `T_object_camera`, NaN where a frame has none.
    """
    placed = np.array([k for k, f in enumerate(frames) if f is not None and np.isfinite(poses[k]).all()], int)
    others = placed[np.unique(np.linspace(0, max(len(placed) - 1, 0), min(ASKED, len(placed))).round().astype(int))]
    found = list(frames)
    images = [f.surface.points[..., 2] for m in others if (f := frames[m]) is not None]
    depths, nearest = (np.array([of(image).ravel() for image in images]) for of in (np.asarray, _nearest))

    def without(k: int) -> tuple[Prepared, bool]:
        frame = frames[k]
        assert frame is not None
        # rims and what stands still too: the motion takes nothing of them, the volume does
        taken = before_wall(frame.surface, region) & np.isfinite(frame.depth)
        step = max(1, round(np.sqrt(taken.sum() / SOME)))
        inner = usable(frame.surface, region)
        asked = _asked(frame, taken, inner, poses[k], step)
        some = np.flatnonzero(others != k)
        told = _told(asked, frame.surface.camera, _Others(poses[others[some]], depths, nearest, some))
        passing = _passing(told, asked)
        image = _image(asked, passing, frame.depth.shape, step)
        wide = _patches(asked, passing.some & asked.inner).any()
        return _without(frame, image) if (image & taken).any() else frame, bool(wide)

    pulled = 0
    for k, cut in zip(placed, each(ahead(without, placed.tolist()), "passing", len(placed)), strict=True):
        found[k], pulls = cut()
        pulled += pulls
    return Clear(found, pulled / max(len(frames), 1))


def _without(frame: Prepared, passing: Mask) -> Prepared:
    before = frame.passing
    return replace(frame.masked(~passing), passing=passing if before is None else passing | before)


def _asked(frame: Prepared, taken: Mask, inner: Mask, T: Array, step: int) -> _Asked:
    grid = np.zeros_like(taken)
    grid[step // 2 :: step, step // 2 :: step] = True
    v, u = np.nonzero(taken & grid)
    seen, camera = frame.surface.points[v, u].astype(float), frame.surface.camera
    beside = 0.5 * float(np.median(seen[:, 2])) / camera.fx if len(seen) else 0.0
    shape = taken.shape[0] // step + 1, taken.shape[1] // step + 1
    normals = frame.surface.normals[v, u].astype(float)
    bare = ~np.isfinite(normals[:, 0])
    normals[bare] = -seen[bare] / np.linalg.norm(seen[bare], axis=1, keepdims=True)
    normals = normals @ T[:3, :3].T
    return _Asked((v // step, u // step), shape, pose.transform(T, seen), normals, inner[v, u], beside)


def _nearest(depth: NDArray[np.float32]) -> NDArray[np.float32]:
    """(h, w) least depth [m] of each pixel and those beside it; NaN where the pixel has none."""
    known = np.isfinite(depth)
    least = cv2.erode(np.where(known, depth, np.float32(np.inf)).astype(np.float32), BESIDE)
    return np.asarray(np.where(known, least, np.float32(np.nan)))


def _passing(told: _Told, asked: _Asked) -> _Passing:
    known = np.abs(told.beyond[np.isfinite(told.beyond) & asked.inner])
    near = max(NOISES * MAD_TO_STD * float(np.median(known)), asked.beside) if len(known) else asked.beside
    with np.errstate(invalid="ignore"):
        shown = (np.abs(told.beyond) <= near).sum(axis=0) + 1
        through, surely = ((beyond > near).sum(axis=0) > shown for beyond in (told.beyond, told.nearest))
    return _Passing(through, through & surely)


def _told(asked: _Asked, camera: Camera, others: _Others) -> _Told:
    """What other frames say of the pixels. In depth a slant would count noise and errors of the motion many times."""
    place, z, slant = facing(asked.points, asked.normals, camera, others.poses)
    which = others.which[:, None]
    off, nearest = (
        np.where(place >= 0, (depths[which, place] - z) * slant, np.nan).astype(np.float32)
        for depths in (others.depths, others.nearest)
    )
    height, width = (size + 2 for size in asked.shape)
    grids = np.full((len(place), height * width), np.nan, np.float32)
    at = (asked.at[0] + 1) * width + asked.at[1] + 1
    grids[:, at] = off
    found = np.full(place.shape, np.nan, np.float32)
    frame, point = np.nonzero(np.isfinite(off))
    beside = (width * np.array([[-1], [0], [1]]) + (-1, 0, 1)).reshape(9, 1)
    found[frame, point] = _medians(grids.ravel()[frame * grids.shape[1] + at[point] + beside])
    return _Told(found, nearest)


def _medians(columns: NDArray[np.float32]) -> NDArray[np.float32]:
    """(m,) medians of what is known in each column (9, m), one value at least; NumPy's take six times as long."""
    known, every = np.isfinite(columns).sum(axis=0), np.arange(columns.shape[1])
    ordered = np.sort(columns, axis=0)  # NaN last
    return (ordered[(known - 1) // 2, every] + ordered[known // 2, every]) / np.float32(2)


def _patches(asked: _Asked, some: Mask) -> NDArray[np.uint8]:
    """Which of some pixels (m,) that were asked form patches, as an image of the grid."""
    grid = np.zeros(asked.shape, np.uint8)
    grid[asked.at[0][some], asked.at[1][some]] = 1
    return np.asarray(cv2.morphologyEx(grid, cv2.MORPH_OPEN, BESIDE), np.uint8)


def _image(asked: _Asked, passing: _Passing, shape: tuple[int, ...], step: int) -> Mask:
    """(h, w) bool: the pixels that were asked and pass, and what lies between them; lines alone may be rims.

    What hangs together with a patch, or with what surely passes, belongs to it, however narrow it is and across pixels
    that show nothing.
    """
    grid, sure = np.zeros((2, *asked.shape), np.uint8)
    rows, columns = asked.at
    grid[rows, columns], sure[rows, columns] = passing.some, passing.surely
    sure = np.maximum(sure, _patches(asked, passing.some))
    labels = cv2.connectedComponents(cv2.dilate(grid, BESIDE))[1]
    whole = (grid > 0) & np.isin(labels, np.unique(labels[sure > 0]))
    wide = cv2.dilate(whole.astype(np.uint8), BESIDE)
    return np.asarray(wide.repeat(step, axis=0).repeat(step, axis=1)[: shape[0], : shape[1]] > 0)
