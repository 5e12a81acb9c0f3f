"""Colour decides where shape does not: which of several transforms lays the same print on each other."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from fusion.geometry import pose
from fusion.mesh.mesh import Mesh
from fusion.passes.poses.lying import Lying, judged, pairs
from fusion.passes.poses.sides import PassSide

Array = NDArray[np.float64]
STEP = np.deg2rad(3.0)  # of a turn about an axis of symmetry: print of a centimetre on a radius of 10 cm is 6 deg wide
ALIKE, CLEAR = 0.3, 0.15  # least correlation of the best, and its lead on the next, that decide (guess)
HELD = 0.03  # of the score: a turned surface that loses no more lies as well as before (guess)
# [m] to either side along what shape does not hold, and steps (guess); absolute: colours tell their place by pixels,
# whatever the object's size
SLIDE, REFINED = 0.012, 12
FEWEST = 50  # pairs of points that have a say


@dataclass(frozen=True)
class Printed:
    """Colours (m, 3) of the dense points of two sides, what every point lacks of the mean of its neighbours."""

    first: Array
    second: Array


def printed(meshes: tuple[Mesh, Mesh], sides: tuple[PassSide, PassSide]) -> Printed | None:
    """The colours of two passes; None where one has none."""
    if any(mesh.colors is None for mesh in meshes):
        return None
    return Printed(*(_colors(mesh, side) for mesh, side in zip(meshes, sides, strict=True)))


def alike(shown: Printed, first: PassSide, second: PassSide, T: Array) -> float:
    """Correlation of the colours of points that lie on each other, mean of the channels; 0 where few do."""
    step = max(1, len(second.points) // 4000)
    points, normals = second.points[::step], second.normals[::step]
    index, weight, _ = pairs(first, pose.transform(T, points), normals @ T[:3, :3].T, first.noise)
    use = weight > 0
    if use.sum() < FEWEST:
        return 0.0
    a, b = shown.first[index[use]], shown.second[::step][use]
    a, b = a - a.mean(axis=0), b - b.mean(axis=0)
    spread = np.sqrt(np.sum(a**2, axis=0) * np.sum(b**2, axis=0))
    return float(np.mean(np.sum(a * b, axis=0) / np.maximum(spread, 1e-9)))


def decided(
    shown: Printed, first: PassSide, second: PassSide, rivals: list[Lying]
) -> tuple[Lying, float, float] | None:
    """The transform whose colours fit, its correlation and that of the next; None where colours do not decide.

    Args:
        shown: the colours.
        first, second: the passes.
        rivals: transforms that shape cannot tell apart, the best first.
    """
    tried = [(alike(shown, first, second, one.T), one.T) for one in [*rivals, *_between(first, second, rivals)]]
    tried.sort(key=lambda one: -one[0])
    value, T = tried[0]
    apart = 0.1 * second.size
    others = [v for v, X in tried if _moved(X, T, second) > apart]
    following = max(others, default=0.0)
    if value < ALIKE or value < following + CLEAR:
        return None
    return judged(first, second, T), value, following


def slid(shown: Printed, first: PassSide, second: PassSide, T: Array, ways: Array) -> Array:
    """The transform (4, 4) moved along the ways (m, 6) that the surfaces do not hold, to where colours fit best.

    A twist of a way moves the surface by about a metre.
    """
    for way in ways:
        steps = np.linspace(-SLIDE, SLIDE, 2 * REFINED + 1)
        values = np.array([alike(shown, first, second, pose.exp(step * way) @ T) for step in steps])
        k = int(np.argmax(values))
        if values[k] < ALIKE or k in (0, len(steps) - 1):
            continue
        left, middle, right = values[k - 1 : k + 2]  # the top of a parabola through three
        top = 0.5 * (left - right) / min(left - 2 * middle + right, -1e-9)
        T = pose.exp((steps[k] + top * (steps[1] - steps[0])) * way) @ T
    return T


def _between(first: PassSide, second: PassSide, rivals: list[Lying]) -> list[Lying]:
    """All turns about an axis about which the surface turns into itself; none where there is no such axis."""
    best = rivals[0]
    for rival in rivals[1:]:
        D = rival.T @ pose.inverse(best.T)
        axis = _axis(D)
        if axis is None:
            continue
        half = judged(first, second, pose.about_axis(*axis, pose.angle(D) * 0.37) @ best.T)
        if half.score < best.score - HELD:
            continue  # it only lies right at some angles
        turns = [pose.about_axis(*axis, angle) for angle in np.arange(0, 2 * np.pi, STEP)]
        return [Lying(turn @ one.T, one.overlap, one.through, one.rms) for one in rivals[:4] for turn in turns]
    return []


def _axis(D: Array) -> tuple[Array, Array] | None:
    """Point and direction of the line about which a motion turns; None where it hardly turns."""
    angle = pose.angle(D)
    if angle < np.deg2rad(3):
        return None
    values, vectors = np.linalg.eig(D[:3, :3])
    direction = np.real(vectors[:, int(np.argmin(np.abs(values - 1)))])
    # least squares: (I - R) p = t has no part along the axis
    point = np.linalg.lstsq(np.eye(3) - D[:3, :3], D[:3, 3], rcond=1e-6)[0]
    return np.asarray(point, float), np.asarray(direction, float)


def _moved(one: Array, other: Array, side: PassSide) -> float:
    off = pose.transform(one, side.few.points) - pose.transform(other, side.few.points)
    return float(np.sqrt(np.mean(np.sum(off**2, axis=1))))


def _colors(mesh: Mesh, side: PassSide) -> Array:
    assert mesh.colors is not None
    return np.asarray(mesh.colors[cKDTree(mesh.vertices).query(side.points)[1]], float)
