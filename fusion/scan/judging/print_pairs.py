"""What two frames show of the same places, by print: as much alike as by chance, or as one print is?

What counts is told by the images themselves: moved by a few pixels over itself a print agrees with itself so much, and
moved by many it agrees by chance only. What light makes of the shape is no print: it stands still as the object turns.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.geometry import pose
from fusion.scan.cleaning.facing import facing
from fusion.turntable.pairs.edges import NOISES, SLANT
from fusion.turntable.shading import print_of
from fusion.turntable.tones import AROUND
from fusion.turntable.views import Region, usable
from fusion.volume.prepared import Prepared

Array = NDArray[np.float64]
Image = NDArray[np.float32]
NEAR = 0.005  # [m] beside noise: what a motion may be wrong by, as depth cameras bend depth by millimetres (guess)
SOME = 3000  # places of a frame: print hangs together over more than lies between them
FEWEST = 40  # places that tell a correlation (guess)
OFF = 3  # [px] beyond what smoothing makes of the noise of single pixels; print that lies off by less still agrees
CLOSE = ((0, OFF), (OFF, 0))  # rows, columns
FAR = round(2 * AROUND)  # [px] beyond what contrast keeps of the surroundings
ELSEWHERE = tuple((FAR * v, FAR * u) for v in (-1, 0, 1) for u in (-1, 0, 1) if v or u)
HERE = (0, 0)


@dataclass(frozen=True)
class PrintedFrame:
    """A frame with its print, and some places of it in the object's frame.

    Attributes:
        frame, T: it, and (4, 4) where its camera stood.
        print: (FAR + h + FAR, FAR + w + FAR) see `tones.contrast`, NaN where it does not count and beside the image.
        rows, columns: (m,) of the places.
        points, normals, near: (m, 3), (m, 3), (m,) [m]; `near`: of a place seen there by others.
    """

    frame: Prepared
    T: Array
    print: Image
    rows: NDArray[np.intp]
    columns: NDArray[np.intp]
    points: Array
    normals: Array
    near: Array


@dataclass(frozen=True)
class PrintPair:
    """What a pair of frames says."""

    alike: float  # correlation of the prints of the same places, -1 to 1; NaN where they share too few
    own: float  # of a print with itself, `OFF` pixels beside; of the two prints the one that has less of it
    chance: float  # root mean square of the correlations with other places


def printed(frame: Prepared, region: Region, T: Array) -> PrintedFrame | None:
    """The print of a frame (cut to the window of the region); None where it has no colours or shows nothing."""
    surface = frame.surface
    assert surface.incidence is not None
    shown = usable(surface, region) & np.isfinite(frame.depth) & (surface.incidence < SLANT)
    if frame.color is None or not shown.any():
        return None
    grid = np.zeros_like(shown)
    step = max(1, round(np.sqrt(shown.sum() / SOME)))
    grid[step // 2 :: step, step // 2 :: step] = True
    v, u = np.nonzero(shown & grid)
    points = pose.transform(T, surface.points[v, u].astype(float))
    near = NEAR + NOISES * np.nan_to_num(surface.sigma[v, u].astype(float))
    normals = surface.normals[v, u] @ T[:3, :3].T
    print_ = np.pad(print_of(frame.color, surface.normals, shown), FAR, constant_values=np.nan)
    return PrintedFrame(frame, T, print_, v, u, points, normals, near)


def compared(one: PrintedFrame, other: PrintedFrame) -> PrintPair:
    """What two frames say where their motion puts them."""
    place, z, _ = (of_one[0] for of_one in facing(one.points, one.normals, other.frame.surface.camera, other.T[None]))
    same = (place >= 0) & (np.abs(other.frame.depth.ravel()[place] - z) < one.near)  # of NaN it is not true
    which, there = np.flatnonzero(same), np.unravel_index(place[same], other.frame.depth.shape)
    here = one.rows[which], one.columns[which]
    mine, its = _at(one.print, here, (HERE, *CLOSE)), _at(other.print, there, (HERE, *CLOSE))
    alike = float(_correlations(mine[0], its[:1])[0])
    own = min(float(np.mean(_correlations(print_[0], print_[1:]))) for print_ in (mine, its))
    chances = _correlations(mine[0], _at(other.print, there, ELSEWHERE))
    chances = chances[np.isfinite(chances)]
    chance = float(np.sqrt(np.mean(chances**2))) if len(chances) else float("nan")
    return PrintPair(alike, own, chance)


def _at(image: Image, at: tuple[NDArray, ...], by: tuple[tuple[int, int], ...]) -> Array:
    """(k, m) of an image with a border at pixels (rows, columns), moved by each of k (rows, columns)."""
    width = image.shape[1]
    moved = np.array([(FAR + v) * width + FAR + u for v, u in by])
    return np.asarray(image.ravel()[moved[:, None] + at[0] * width + at[1]], float)


def _correlations(a: Array, others: Array) -> Array:
    """(k,) of a (m,) with others (k, m), of what both know; contrasts are about 0 of themselves. NaN of too few."""
    known = np.isfinite(a) & np.isfinite(others)
    a, b = np.where(known, a, 0), np.where(known, others, 0)
    product, mine, its = ((x * y).sum(axis=1) for x, y in ((a, b), (a, a), (b, b)))
    return np.where(known.sum(axis=1) < FEWEST, np.nan, product / np.sqrt(np.maximum(mine * its, 1e-12)))
