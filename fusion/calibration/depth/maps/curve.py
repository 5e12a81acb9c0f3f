"""The error over distance as one curve with its interval, on the optical axis."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from fusion.calibration.depth.laws.information import WallEvidence
from fusion.calibration.depth.laws.terms import LawTerm
from fusion.calibration.depth.walls.samples import WallSamples, samples_on_axis
from fusion.calibration.depth.walls.wall import Wall
from fusion.geometry.camera import Camera
from fusion.sensor.sensor import Sensor

POINTS = 81
CONFIDENCE = 0.90
Array = NDArray[np.floating]


@dataclass(frozen=True)
class DepthCurve:
    """The mean error of a depth on the optical axis."""

    distance: Array  # (n,) true depth [m]
    bias: Array  # (n,) measured less true [m]
    std: Array  # (n,) of the bias [m]

    @property
    def half_width(self) -> Array:
        """(n,) [m] half of the 90 % interval."""
        return ndtri(0.5 + CONFIDENCE / 2) * self.std


@dataclass(frozen=True)
class Rival:
    """Another law that the walls do not rule out: terms (k,), numbers (k,), covariance, weight to the chosen's 1."""

    terms: tuple[LawTerm, ...]
    numbers: Array
    covariance: Array
    weight: float


def deviation_of(rows: Array, covariance: Array) -> Array:
    """(n,) standard deviation of rows (n, k) times numbers of this covariance."""
    return np.sqrt(np.maximum(np.einsum("ij,jk,ik->i", rows, covariance, rows), 0.0))


def among_rivals(bias: Array, std: Array, rivals: list[tuple[Rival, Array]]) -> Array:
    """(n,) standard deviation when it is not sure which law holds (Buckland, Burnham, Augustin 1997).

    Args:
        bias, std: (n,) of the chosen law [m].
        rivals: each with its terms on the axis (n, k).
    """
    total, weights = std.copy(), 1.0
    for rival, rows in rivals:
        off = rows @ rival.numbers - bias
        total = total + rival.weight * np.hypot(deviation_of(rows, rival.covariance), off)
        weights += rival.weight
    return total / weights


def axis_terms(terms: tuple[LawTerm, ...], distance: Array, camera: Camera, sensor: Sensor, light: float) -> Array:
    """(n, k) change of the depth per unit of each term at depths (n,) [m] on the axis; `light`: IR times z^2."""
    return changes(terms, samples_on_axis(distance, camera, sensor, light))


def changes(terms: tuple[LawTerm, ...], at: WallSamples) -> Array:
    """(n, k) change of the depth per unit of each term."""
    return np.column_stack([np.zeros((len(at.depth), 0)), *(term.change(at) for term in terms)])


def light_of(walls: list[Wall]) -> float:
    """IR amplitude times squared distance in the middle of the walls [count m^2]; 0 without IR."""
    found = []
    for wall in walls:
        if wall.ir is not None:
            h, w = wall.ir.shape
            box = np.s_[2 * h // 5 : 3 * h // 5 + 1, 2 * w // 5 : 3 * w // 5 + 1]
            inside = wall.ir[box][wall.mask[box]]
            if inside.size:
                found.append(float(np.nanmedian(inside)) * wall.plane.distance**2)
    return float(np.median(found)) if found else 0.0


def span(walls: list[Wall]) -> tuple[float, float]:
    """Nearest and farthest wall [m]."""
    distances = [wall.depth_there for wall in walls]
    return min(distances), max(distances)


def measured_offsets(evidence: list[WallEvidence], bias: Array) -> tuple[Array, Array]:
    """(w,) error of each wall on the axis [m] and its standard deviation; NaN where the distance is not known.

    Args:
        evidence: with `rest` [m] that a law leaves over.
        bias: (w,) of that law on the axis at the walls [m].
    """
    offset, std = np.full(len(evidence), np.nan), np.full(len(evidence), np.nan)
    for i, e in enumerate(evidence):
        if np.isfinite(e.distance_std):
            w = 1 / np.sqrt(e.variance)
            G = e.nuisances * w[:, None]
            offset[i] = bias[i] + np.linalg.lstsq(G, e.rest * w, rcond=None)[0][2]
            std[i] = np.sqrt(e.distance_std**2 + np.linalg.inv(G.T @ G)[2, 2])
    return offset, std
