"""What passes before a scanned object, as the hand that turns it: pixels of a frame whose place others look through.

A finger near the object is no visitor that the region leaves out, and what is behind it takes no part in the volume, so
nothing wipes it away there. Once the motion is known every frame says of the others where nothing is.

Two frames show the same where they differ, along the normal and over some neighbours, by no more than they differ all
over: that holds the noise, what is alike in neighbours, and what the motion is wrong by.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.geometry import pose
from fusion.geometry.robust import MAD_TO_STD
from fusion.progress import each
from fusion.scan.cleaning.facing import facing
from fusion.scan.cleaning.seen import ASKED
from fusion.scan.finding.alone import masked
from fusion.turntable.pairs.edges import NOISES
from fusion.turntable.views import Region, usable
from fusion.volume.prepared import Prepared

Array = NDArray[np.float64]
SOME = 1500  # pixels of a frame that are asked: what passes is wider than what lies between them
BESIDE = np.ones((3, 3), np.uint8)
AROUND = np.ones((5, 5), np.uint8)  # pixels that are asked beside those that pass: rims of it, which lie nearer (guess)


@dataclass(frozen=True)
class _Asked:
    """Pixels of a frame on a grid.

    Attributes:
        at: rows and columns (m,) in the grid.
        shape: of the grid.
        points, normals: (m, 3) in the object's frame [m].
        beside: half a pixel's width [m]: how far beside a point the pixel lies that says something of it.
    """

    at: tuple[NDArray[np.intp], NDArray[np.intp]]
    shape: tuple[int, int]
    points: Array
    normals: Array
    beside: float


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
    for k in each(placed.tolist(), "passing"):
        frame = frames[k]
        assert frame is not None
        shown = usable(frame.surface, region) & np.isfinite(frame.depth)
        step = max(1, round(np.sqrt(shown.sum() / SOME)))
        asked = _asked(frame, shown, poses[k], step)
        passing = _passing(asked, [(frames[m], poses[m]) for m in others if m != k])
        image = _image(asked, passing, frame.depth.shape, step)
        if (image & shown).any():
            found[k] = masked(frame, ~image)
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


def _passing(asked: _Asked, others: list[tuple[Prepared | None, Array]]) -> NDArray[np.bool_]:
    """(m,) bool: pixels that more frames look through than show, their own included."""
    beyond = np.array([_beyond(asked, *other) for other in others]).reshape(-1, len(asked.points))
    known = np.abs(beyond[np.isfinite(beyond)])
    if not len(known):
        return np.zeros(len(asked.points), bool)
    near = max(NOISES * MAD_TO_STD * float(np.median(known)), asked.beside)
    with np.errstate(invalid="ignore"):
        shown, through = (np.abs(beyond) <= near).sum(axis=0), (beyond > near).sum(axis=0)
    return np.asarray(through > shown + 1)


def _beyond(asked: _Asked, frame: Prepared | None, T: Array) -> NDArray[np.float32]:
    """(m,) how far along the normal a frame at T (4, 4) shows something behind what is asked, median of its neighbours
    [m]; NaN where it says nothing.

    In depth a slant would count noise and errors of the motion many times.
    """
    assert frame is not None
    which, (v, u), z = facing(asked.points, asked.normals, frame, T)
    towards = T[:3, 3] - asked.points[which]
    slant = np.einsum("ij,ij->i", asked.normals[which], towards) / np.linalg.norm(towards, axis=1)
    grid = np.full((asked.shape[0] + 2, asked.shape[1] + 2), np.nan, np.float32)
    rows, columns = (axis[which] + 1 for axis in asked.at)
    grid[rows, columns] = (frame.surface.points[v, u, 2] - z) * slant
    around = grid[rows[:, None] + np.repeat((-1, 0, 1), 3), columns[:, None] + np.tile((-1, 0, 1), 3)]
    found = np.full(len(asked.points), np.nan, np.float32)
    told = np.isfinite(around[:, 4])  # its own place, the middle of nine
    found[which[told]] = _medians(around[told])
    return found


def _medians(rows: NDArray[np.float32]) -> NDArray[np.float32]:
    """(m,) medians of what is known in each row (m, 9), one value at least; NumPy's takes ten times as long."""
    ordered = np.sort(rows, axis=1)  # NaN last
    known, each_row = np.isfinite(rows).sum(axis=1), np.arange(len(rows))
    return (ordered[each_row, (known - 1) // 2] + ordered[each_row, known // 2]) / np.float32(2)


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
