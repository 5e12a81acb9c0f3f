"""Is depth planar z, or the distance along the ray?

On a plane 1/z = a x + b y + c over the ray (x, y, 1). With n = |(x, y, 1)| and a stored value d, z = d for planar
depth and z = d / n for a range. So 1/d = a x + b y + c - s (n - 1) / d with s = 0 for planar z and s = 1 for a
range: s is one more unknown of a linear fit, and its standard deviation says whether the plane is large enough.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fusion.recording.looking.finding import Finding
from fusion.recording.looking.sample import Sample

# relative depth error up to which a pixel belongs to a plane: bowing by range reaches 20 % in corners
TOLERANCE = 0.01
TRIALS = 60
# a plane bows by 0 or by 1, and lenses add some; what bows otherwise is curved itself (a ball of radius r at the
# distance z by 1 + z / r): it says nothing
PLAIN = 0.3
# a saddle as large would turn one into the other: bent otherwise than a plane is by either, it is none
BENT = 0.5
# share of the valid pixels that a plane must hold to be asked
LARGE = 0.15
# standard deviation of s that a plane must reach to be asked
SURE = 0.05
SEED = 1


@dataclass(frozen=True)
class Bow:
    """Of one plane: `s` (0 planar z, 1 range), its standard deviation, and what tells how far that holds.

    Attributes:
        share: of the valid pixels that lie on it.
        saddle: how much it bends up one way and down the other, in the unit of `s`; of a true plane nothing.
    """

    s: float
    std: float
    share: float
    saddle: float


def check_range_or_z(sample: Sample) -> list[Finding]:
    """Planes that are flat only when the depth is read as a range."""
    bows = [bow for depth in sample.depths.values() if (bow := largest_plane(depth, sample.rays)) is not None]
    bows = [bow for bow in bows if bow.share > LARGE and bow.std < SURE]
    if not bows:
        return [Finding("range or z", "ok", "no plane large enough to tell planar z from range")]
    planes = [bow for bow in bows if min(abs(bow.s), abs(bow.s - 1)) < PLAIN and bow.saddle < BENT]
    if 2 * len(planes) <= len(bows):
        return [Finding("range or z", "ok", "the largest surfaces are curved: they cannot tell planar z from range")]
    s = float(np.median([bow.s for bow in planes]))
    seen = f"planes in {len(planes)} of {len(sample.depths)} frames bow by {s:.2f} (0: planar z, 1: range)"
    if np.mean([bow.s > 0.5 for bow in planes]) > 0.6:
        do = "the depth looks like the distance along the ray: convert it with z = d / sqrt(1 + x^2 + y^2)"
        return [Finding("range or z", "error", seen, do)]
    return [Finding("range or z", "ok", seen)]


def largest_plane(depth: NDArray[np.float32], rays: NDArray[np.float32]) -> Bow | None:
    """The bow of the largest plane in a depth image (h, w) [m] with rays (h, w, 2); None when there is none."""
    valid = np.isfinite(depth) & np.isfinite(rays).all(axis=2)
    if valid.sum() < 500:
        return None
    chosen = np.random.default_rng(SEED).permutation(int(valid.sum()))[:6000]
    x, y = rays[valid][chosen].astype(float).T
    d = depth[valid][chosen].astype(float)
    rows = np.column_stack([x, y, np.ones_like(x), -(np.sqrt(1 + x * x + y * y) - 1) / d])
    fits = [fit for s in (0.0, 1.0) if (fit := _refined(rows, d, _most_agreed(rows, d, s))) is not None]
    if not fits:
        return None
    fit = max(fits, key=lambda one: one.share)  # of equals the first
    return Bow(float(fit.plane[3]), fit.std, fit.share, _saddle(rows, d, fit.plane))


class _Fit(NamedTuple):
    plane: NDArray  # (4,) a, b, c, s
    std: float  # of s
    share: float


def _most_agreed(rows: NDArray, d: NDArray, s: float) -> NDArray:
    """(4,) coefficients of the plane with most agreeing pixels when `s` is given."""
    random = np.random.default_rng(SEED)
    target = 1 / d - s * rows[:, 3]
    best, most = np.zeros(4), -1
    for _ in range(TRIALS):
        three = random.integers(0, len(d), 3)
        if abs(np.linalg.det(rows[three, :3])) < 1e-5:
            continue
        plane = np.linalg.solve(rows[three, :3], target[three])
        agreed = int((np.abs(rows[:, :3] @ plane - target) * d < TOLERANCE).sum())
        if agreed > most:
            best, most = np.append(plane, s), agreed
    return best


def _refined(rows: NDArray, d: NDArray, fit: NDArray) -> _Fit | None:
    """The plane and `s` fitted together to the pixels that agree, until they settle."""
    std = np.inf
    inside = np.zeros(len(d), bool)
    for _ in range(8):
        inside = np.abs(rows @ fit - 1 / d) * d < TOLERANCE
        if inside.sum() < 100:
            return None
        # weights: an error of depth dz changes 1/d by dz / d^2; noise grows about with d^2, so 1/d has even noise
        A, b = rows[inside], 1 / d[inside]
        fit, _, rank, _ = np.linalg.lstsq(A, b, rcond=None)
        if rank < 4:
            return None
        residual = A @ fit - b
        std = float(np.sqrt(np.linalg.pinv(A.T @ A)[3, 3] * (residual @ residual) / (len(b) - 4)))
    return _Fit(fit, std, float(inside.mean()))


def _saddle(rows: NDArray, d: NDArray, fit: NDArray) -> float:
    """What pixels near a plane say of bends (x^2 - y^2) / 2 and x y, with all else free: a bow is (x^2 + y^2) / 2."""
    x, y = rows[:, 0], rows[:, 1]
    rows, fit = np.column_stack([rows, (x * x - y * y) / (2 * d), x * y / d]), np.append(fit, [0.0, 0.0])
    for _ in range(8):
        inside = np.abs(rows @ fit - 1 / d) * d < TOLERANCE
        fit = np.linalg.lstsq(rows[inside], 1 / d[inside], rcond=None)[0]
    return float(np.hypot(fit[4], fit[5]))
