"""Each scan against the others: whether one shows something else, and where a place differs."""

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray
from scipy.special import fdtri  # scipy.stats takes a second to import

from fusion.geometry.robust import robust_std
from fusion.mesh.comparison.surface_samples import SurfaceSamples
from fusion.repeatability.find_forms import one_piece, spacing_of
from fusion.repeatability.spread import GROSS

Array = NDArray[np.float64]
FEWEST = 100  # places that two scans must share to be compared
RARE = 0.05  # of the comparisons of scans that are alike, one stands out so far by chance
# of the object's size, rms: what no pose, scale and offset take away; the errors of depth cameras are less (guess)
OTHER = 0.005


@dataclass(frozen=True)
class AgainstOthers:
    """One scan of three or more beside the others; the differences are rms over the places that two scans share."""

    off: float  # of the scan to another one, the median of them [m]
    apart: float  # of the others to each other, the (lower) median [m]
    chance: float  # what `times` reaches now and then if all scans are alike
    lost: bool  # what is left without scale and offset is another shape

    @property
    def times(self) -> float:
        """How far it is off, over what the others are apart."""
        return self.off / max(self.apart, 1e-12)


@dataclass(frozen=True)
class DifferingPlace:
    """The largest piece of the surface at which scans lie far further apart than elsewhere."""

    share: float  # of the surface
    centre_m: Array  # (3,) on the mean surface [m]
    across_m: float  # diagonal of the box about it [m]
    height_m: float  # that scan is off the mean of the others there at most [m]
    scan: int  # index of the one that is furthest from the mean there


def against_others(surface: SurfaceSamples, offsets: Array, condition: NDArray[np.intp]) -> list[AgainstOthers | None]:
    """Of offsets (m, n) [m] at points of the mean surface (m, 3): each scan beside those of its condition (n,).

    Beside all where its condition has less than three scans; None where there are less than three, or none overlap.
    """
    out: list[AgainstOthers | None] = []
    for k in range(offsets.shape[1]):
        others = np.flatnonzero(condition == condition[k])
        others = np.setdiff1d(others if len(others) > 2 else np.arange(len(condition)), k)
        out.append(_against(surface, offsets[:, k], offsets[:, others], len(condition)) if len(others) > 1 else None)
    return out


def _against(surface: SurfaceSamples, own: Array, others: Array, scans: int) -> AgainstOthers | None:
    off = [away for other in others.T if np.isfinite(away := difference(own, other))]
    pairs = [(away, i, j) for i, j in combinations(range(others.shape[1]), 2)
             if np.isfinite(away := difference(others[:, i], others[:, j]))]  # fmt: skip
    if not off or not pairs:
        return None
    pairs.sort()
    apart, i, j = pairs[(len(pairs) - 1) // 2]
    a, b = others[:, i], others[:, j]
    chance = _chance(own - (a + b) / 2, a - b, scans, others.shape[1] - 1)
    middle, far = float(np.median(off)), 0.0
    if middle > max(GROSS * apart, 1e-12):
        rest = _shape(surface, own - (a + b) / 2)
        lost_for = OTHER * float(np.linalg.norm(np.ptp(surface.points, axis=0)))
        far = float(np.median(np.abs(rest))) if len(rest) and np.sqrt(np.mean(rest**2)) > lost_for else 0.0
    return AgainstOthers(middle, apart, chance, middle > chance * apart and far > GROSS * apart)


def difference(a: Array, b: Array) -> float:
    """Root mean square [m] over what two scans share; NaN where that is little."""
    apart = (a - b)[np.isfinite(a) & np.isfinite(b)]
    return float(np.sqrt(np.mean(apart**2))) if len(apart) >= FEWEST else float("nan")


def _chance(own: Array, others: Array, scans: int, free: int) -> float:
    """What one of `scans` alike ones exceeds in a few of 100 cases.

    A surface has many independent places or, where scans err as a whole (a scale), one: patterns of errors of v places
    correlate by 1 / sqrt(v).
    """
    both = np.isfinite(own) & np.isfinite(others)
    if both.sum() < FEWEST:
        return float("inf")
    a, b = own[both], others[both]
    alike = float(a @ b) ** 2 / max(float(a @ a) * float(b @ b), 1e-300)
    places = 1 / max(alike, 1e-4)
    return float(np.sqrt(fdtri(places, places * free, 1 - RARE / scans)))


def _shape(surface: SurfaceSamples, apart: Array) -> Array:
    """What is left of differences (m,) without an offset all over and a scale."""
    assert surface.normals is not None
    known = np.isfinite(apart)
    points = surface.points[known]
    grown = np.einsum("ij,ij->i", points - points.mean(axis=0), surface.normals[known])
    A = np.column_stack([np.ones(len(grown)), grown])
    return np.asarray(apart[known] - A @ np.linalg.lstsq(A, apart[known], rcond=None)[0])


def differing_place(points: Array, offsets: Array) -> DifferingPlace | None:
    """The largest connected one, of offsets (m, n) [m] at points (m, 3); None where there is none."""
    known = np.isfinite(offsets)
    two = known.sum(axis=1) > 1
    if not two.any():
        return None
    usual = robust_std(offsets[two][known[two]])
    largest = np.where(known, np.abs(offsets), 0).max(axis=1)
    members = np.flatnonzero(two & (largest > GROSS * usual + 1e-6))
    spacing = spacing_of(points)
    members = one_piece(points, members, spacing)
    if len(members) < 2:
        return None
    scan = int(np.argmax(np.where(known[members], np.abs(offsets[members]), 0).mean(axis=0)))
    away = _from_others(offsets, scan)
    # what lies so far off is a place's peaks; it ends where the scan is half as far off
    half = float(np.nanmedian(away[members])) / 2
    reached = one_piece(points, np.union1d(members, np.flatnonzero(away > half)), spacing)
    members = reached if np.isin(members, reached).any() else members
    at = points[members]
    across = float(np.linalg.norm(np.ptp(at, axis=0)))
    return DifferingPlace(len(members) / len(points), at.mean(axis=0), across, float(np.nanmax(away[members])), scan)


def _from_others(offsets: Array, scan: int) -> Array:
    """How far (m,) [m] one scan lies off the mean of the others; NaN where it or all of them show nothing."""
    others = np.delete(offsets, scan, axis=1)
    known = np.isfinite(others)
    mean = np.where(known, others, 0).sum(axis=1) / np.maximum(known.sum(axis=1), 1)
    return np.asarray(np.where(known.any(axis=1), np.abs(offsets[:, scan] - mean), np.nan))
