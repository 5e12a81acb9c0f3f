"""What passes before a scanned object, as the hand that turns it: pixels of a frame whose place others look through.

A finger near the object is no visitor that the region leaves out, and what is behind it takes no part in the volume, so
nothing wipes it away there. Once the motion is known every frame says of the others where nothing is.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.geometry import pose
from fusion.scan.finding.frames import masked
from fusion.scan.finding.seen import ASKED, facing
from fusion.turntable.pairs.edges import NOISES
from fusion.turntable.views import Region, usable
from fusion.volume.prepared import Prepared

Array = NDArray[np.float64]
SOME = 1500  # pixels of a frame that are asked: what passes is wider than what lies between them
NEAR = 0.005  # [m] beside noise: what a motion may be wrong by (guess)
AROUND = np.ones((5, 5), np.uint8)  # pixels that are asked beside those that pass: rims of it, which lie nearer (guess)


@dataclass(frozen=True)
class _Asked:
    """Pixels (m,) of a frame, their points (m, 3) and normals in the object's frame, and their noise [m]."""

    rows: NDArray[np.intp]
    columns: NDArray[np.intp]
    points: Array
    normals: Array
    sigma: NDArray[np.float32]


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
    for k in placed:
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
    points = pose.transform(T, frame.surface.points[v, u].astype(float))
    return _Asked(v, u, points, frame.surface.normals[v, u] @ T[:3, :3].T, frame.surface.sigma[v, u])


def _passing(asked: _Asked, others: list[tuple[Prepared | None, Array]]) -> NDArray[np.bool_]:
    """(m,) bool: pixels that more frames look through than show, their own included."""
    shown, through = np.ones(len(asked.points), int), np.zeros(len(asked.points), int)
    near = NEAR + NOISES * np.nan_to_num(asked.sigma, nan=0.0)
    for frame, T in others:
        assert frame is not None
        which, (v, u), z = facing(asked.points, asked.normals, frame, T)
        beyond = frame.surface.points[v, u, 2] - z
        shown[which[np.abs(beyond) <= near[which]]] += 1
        through[which[beyond > near[which]]] += 1
    return through > shown


def _image(asked: _Asked, passing: NDArray[np.bool_], shape: tuple[int, ...], step: int) -> NDArray[np.bool_]:
    """(h, w) bool: the pixels around those that were asked and pass; no lines, which are rims of the object."""
    grid = np.zeros((shape[0] // step + 1, shape[1] // step + 1), np.uint8)
    grid[asked.rows[passing] // step, asked.columns[passing] // step] = 1
    wide = cv2.dilate(cv2.morphologyEx(grid, cv2.MORPH_OPEN, np.ones((3, 3), np.uint8)), AROUND)
    return np.asarray(wide.repeat(step, axis=0).repeat(step, axis=1)[: shape[0], : shape[1]] > 0)
