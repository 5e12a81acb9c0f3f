"""What passes before a scanned object, as the hand that turns it: pixels of a frame whose place others look through.

A finger near the object is no visitor (turntable/turning/visitors.py) that the region leaves out, and what is behind it
takes no part in the volume, so nothing wipes it away there. Once the motion is known every frame says of the others
where nothing is.

Two frames show the same where they differ, along the normal and over some neighbours, by no more than they differ all
over: that holds the noise, what is alike in neighbours, and what the motion is wrong by.
"""

from collections.abc import Sequence
from dataclasses import dataclass

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
from fusion.turntable.views import Region, usable
from fusion.volume.prepared import Prepared

Array = NDArray[np.float64]
SOME = 1500  # pixels of a frame that are asked: what passes is wider than what lies between them
BESIDE = np.ones((3, 3), np.uint8)
AROUND = np.ones((5, 5), np.uint8)  # pixels that are asked beside those that pass: rims of it, which lie nearer (guess)


@dataclass(frozen=True)
class _Asked:
    """Pixels of a frame on a grid."""

    at: tuple[NDArray[np.intp], NDArray[np.intp]]  # rows and columns (m,) in the grid
    shape: tuple[int, int]  # of the grid
    # points, normals: (m, 3) in the object's frame [m]
    points: Array
    normals: Array
    beside: float  # half a pixel's width [m]: how far beside a point the pixel lies that says something of it


@dataclass(frozen=True)
class _Others:
    """Frames that are asked: poses (k, 4, 4), and which rows (k,) of `depths` (all, h * w) [m] are theirs."""

    poses: Array
    depths: NDArray[np.float32]
    which: NDArray[np.intp]


def without_passing(frames: Sequence[Prepared | None], region: Region, poses: Array) -> list[Prepared | None]:
    """The frames without the pixels that more of the other frames look through than show.

    Args:
        frames: k of them, cut to the window of the region; points outside it say what is behind.
        region: where the object is, its images cut to the same window.
        poses: (k, 4, 4) `T_object_camera`, NaN where a frame has none.
    """
    placed = np.array([k for k, f in enumerate(frames) if f is not None and np.isfinite(poses[k]).all()], int)
    others = placed[np.unique(np.linspace(0, max(len(placed) - 1, 0), min(ASKED, len(placed))).round().astype(int))]
    found = list(frames)
    depths = np.array([f.surface.points[..., 2].ravel() for m in others if (f := frames[m]) is not None])

    def without(k: int) -> Prepared:
        frame = frames[k]
        assert frame is not None
        shown = usable(frame.surface, region) & np.isfinite(frame.depth)
        step = max(1, round(np.sqrt(shown.sum() / SOME)))
        asked = _asked(frame, shown, poses[k], step)
        some = np.flatnonzero(others != k)
        beyond = _beyond(asked, frame.surface.camera, _Others(poses[others[some]], depths, some))
        passing = _passing(beyond, asked.beside)
        image = _image(asked, passing, frame.depth.shape, step)
        return frame.masked(~image) if (image & shown).any() else frame

    for k, cut in zip(placed, each(ahead(without, placed.tolist()), "passing", len(placed)), strict=True):
        found[k] = cut()
    return found


def _asked(frame: Prepared, shown: NDArray[np.bool_], T: Array, step: int) -> _Asked:
    grid = np.zeros_like(shown)
    grid[step // 2 :: step, step // 2 :: step] = True
    v, u = np.nonzero(shown & grid)
    seen, camera = frame.surface.points[v, u].astype(float), frame.surface.camera
    beside = 0.5 * float(np.median(seen[:, 2])) / camera.fx if len(seen) else 0.0
    shape = shown.shape[0] // step + 1, shown.shape[1] // step + 1
    normals = frame.surface.normals[v, u] @ T[:3, :3].T
    return _Asked((v // step, u // step), shape, pose.transform(T, seen), normals, beside)


def _passing(beyond: NDArray[np.float32], beside: float) -> NDArray[np.bool_]:
    """(m,) bool: pixels that more frames look through than show, their own included; `beyond` (k, m) by k others."""
    known = np.abs(beyond[np.isfinite(beyond)])
    if not len(known):
        return np.zeros(beyond.shape[1], bool)
    near = max(NOISES * MAD_TO_STD * float(np.median(known)), beside)
    with np.errstate(invalid="ignore"):
        shown, through = (np.abs(beyond) <= near).sum(axis=0), (beyond > near).sum(axis=0)
    return np.asarray(through > shown + 1)


def _beyond(asked: _Asked, camera: Camera, others: _Others) -> NDArray[np.float32]:
    """(k, m) how far along the normal each other frame shows something behind what is asked, median of its neighbours
    [m]; NaN where it says nothing.

    In depth a slant would count noise and errors of the motion many times.
    """
    place, z, slant = facing(asked.points, asked.normals, camera, others.poses)
    faces = place >= 0
    off = (others.depths[others.which[:, None], place] - z) * slant
    height, width = (size + 2 for size in asked.shape)
    grids = np.full((len(place), height * width), np.nan, np.float32)
    at = (asked.at[0] + 1) * width + asked.at[1] + 1
    grids[:, at] = np.where(faces, off, np.nan)
    found = np.full(place.shape, np.nan, np.float32)
    frame, point = np.nonzero(np.isfinite(grids[:, at]))
    beside = (width * np.array([[-1], [0], [1]]) + (-1, 0, 1)).reshape(9, 1)
    found[frame, point] = _medians(grids.ravel()[frame * grids.shape[1] + at[point] + beside])
    return found


def _medians(columns: NDArray[np.float32]) -> NDArray[np.float32]:
    """(m,) medians of what is known in each column (9, m), one value at least; NumPy's take six times as long."""
    known, every = np.isfinite(columns).sum(axis=0), np.arange(columns.shape[1])
    ordered = np.sort(columns, axis=0)  # NaN last
    return (ordered[(known - 1) // 2, every] + ordered[known // 2, every]) / np.float32(2)


def _image(asked: _Asked, passing: NDArray[np.bool_], shape: tuple[int, ...], step: int) -> NDArray[np.bool_]:
    """(h, w) bool: the pixels around those that were asked and pass, in patches; lines alone are rims of the object.

    What hangs together with a patch belongs to it, however narrow it is and across pixels that show nothing.
    """
    grid = np.zeros(asked.shape, np.uint8)
    grid[asked.at[0][passing], asked.at[1][passing]] = 1
    patches = cv2.morphologyEx(grid, cv2.MORPH_OPEN, BESIDE) > 0
    labels = cv2.connectedComponents(cv2.dilate(grid, BESIDE))[1]
    whole = (grid > 0) & np.isin(labels, np.unique(labels[patches]))
    wide = cv2.dilate(whole.astype(np.uint8), AROUND)
    return np.asarray(wide.repeat(step, axis=0).repeat(step, axis=1)[: shape[0], : shape[1]] > 0)
