"""All passes laid on each other at once: one rigid transform for each but the first, every pair that overlaps counts.

A model that all passes make together, its surface an unknown of its own at every place, and each pass laid on it, ends
in the same equations: what is left when the surface is eliminated are the differences between the passes.
"""

from collections.abc import Sequence
from itertools import permutations

import numpy as np
from numpy.typing import NDArray

from fusion.geometry import pose
from fusion.mesh.comparison.surface_samples import SurfaceSamples
from fusion.passes.poses.lying import pairs
from fusion.passes.poses.sides import PassSide

Array = NDArray[np.float64]
POINTS = 7000  # of each pass
ROUNDS = 12
FOOT = (0.1, 0.5, 2.0)  # percentiles of heights: the lowest, the foot, and what a flat foot still holds (guess)
# [m] spread of a flat foot; height above the plate at which it is not the foot (guess); absolute: of cameras' noise
FLAT, UNSEEN = 0.001, 0.005
DOWN = 0.9  # cosine between the plate's normal and that of a face that lies on it (guess)
STANDING = 1500.0  # points of a surface that the foot on the plate counts for: as surely known as a face of it (guess)
# The same share below which colour is asked too. At 0.019 to 0.04 (five pairs of a Kinect v2, tools/sets/passes, seed
# 411) shape alone missed by 0.05 to 0.21 mm; colours, as fine as pixels of 2 mm, made it 0.06 to 0.30 mm.
LOOSE = 0.005
WEAK = 1e-3  # share of the largest stiffness below which a direction is not held by the surfaces: it stays (guess)


def refined(sides: Sequence[PassSide], T: Array) -> Array:
    """The transforms (k, 4, 4) to the first pass's frame, refined together; that of the first stays.

    Directions that the surfaces do not hold, such as the turn of a cylinder, stay as they are.
    """
    T = T.copy()
    thinned = [_thinned(side) for side in sides]
    noise = max(side.noise for side in sides)
    for reach in np.geomspace(2 * noise, noise, ROUNDS):
        count = 6 * len(sides)
        H, g = np.zeros((count, count)), np.zeros(count)
        for i, j in permutations(range(len(sides)), 2):
            J, off, weight = _between(thinned[i], sides[j], T[i], T[j], float(reach))
            own, other = slice(6 * i, 6 * i + 6), slice(6 * j, 6 * j + 6)
            A, b = (J * weight[:, None]).T @ J, J.T @ (weight * off)
            H[own, own] += A
            H[other, other] += A
            H[own, other] -= A
            H[other, own] -= A
            g[own] += b
            g[other] -= b
            _stand((H, g), sides[j], T[j], _moved(T[i], thinned[i]), (own, other))
        step = np.append(np.zeros(6), _solved(H[6:, 6:], g[6:]))
        for i in range(1, len(sides)):
            T[i] = pose.exp(step[6 * i : 6 * i + 6]) @ T[i]
    return T


def _stand(
    system: tuple[Array, Array], side: PassSide, T: Array, surface: tuple[Array, Array], which: tuple[slice, slice]
) -> None:
    """The lowest of a pass's surface, points and normals (n, 3) in the common frame, stands on another pass's plate.

    It tells how high an object lies of which the passes share hardly more than the sides. A flat foot lies on the
    plate; of another one the lowest point may be unseen, or rounded by the sensor: it may only not be below.
    """
    (points, normals), up = surface, T[:3, 2]
    height = pose.transform(pose.inverse(T), points)[:, 2]
    least, lowest, above = np.percentile(height, FOOT)
    if not side.plate or lowest > UNSEEN:  # what it stands on was not seen by the other
        return
    # the lowest points of a face are those that noise has put there: all of it that looks down tells where it is
    face = height[(height <= lowest + 2 * FLAT) & (normals @ up < -DOWN)] if above - least < FLAT else height[:0]
    off = float(np.median(face)) if len(face) else min(lowest, 0.0)
    if not off:
        return
    at, normal = points[height <= lowest].mean(axis=0), up
    J = np.concatenate([np.cross(at, normal), normal])
    A, b = STANDING * np.outer(J, J), STANDING * off * J
    for one, sign in zip(which, (1, -1), strict=True):
        system[0][one, one] += A
        system[1][one] += sign * b
    system[0][which[0], which[1]] -= A
    system[0][which[1], which[0]] -= A


def _moved(T: Array, surface: SurfaceSamples) -> tuple[Array, Array]:
    """Points and normals under T (4, 4)."""
    assert surface.normals is not None
    return pose.transform(T, surface.points), np.asarray(surface.normals @ T[:3, :3].T)


def _between(
    of: SurfaceSamples, onto: PassSide, T_of: Array, T_onto: Array, reach: float
) -> tuple[Array, Array, Array]:
    """Derivatives (n, 6) in a twist of the first, distances (n,) [m] and weights (n,) of one pass on another."""
    assert of.normals is not None
    T = pose.inverse(T_onto) @ T_of
    index, weight, off = pairs(onto, pose.transform(T, of.points), of.normals @ T[:3, :3].T, reach)
    use = weight > 0
    at, normal = pose.transform(T_of, of.points[use]), onto.normals[index[use]] @ T_onto[:3, :3].T
    return np.hstack([np.cross(at, normal), normal]), off[use], weight[use]


def _solved(H: Array, g: Array) -> Array:
    """The step; rotations count by what they move at a decimetre, so that all directions are lengths."""
    lengths = np.tile([10.0, 10.0, 10.0, 1.0, 1.0, 1.0], len(g) // 6)
    values, vectors = np.linalg.eigh(H * np.outer(lengths, lengths))
    held = values > WEAK * max(float(values[-1]), 1e-12)
    inverse = np.where(held, 1 / np.where(held, values, 1), 0)
    return np.asarray(-lengths * (vectors @ (inverse * (vectors.T @ (lengths * g)))))


def _thinned(side: PassSide) -> SurfaceSamples:
    step = max(1, len(side.points) // POINTS)
    return SurfaceSamples(side.points[::step], side.normals[::step])


def loose(first: PassSide, second: PassSide, T: Array) -> Array:
    """Twists (m, 6), each of about a metre's motion, that hardly change how the second lies on the first under T."""
    thinned, lengths = _thinned(second), np.array([10.0, 10.0, 10.0, 1.0, 1.0, 1.0])
    J, _, weight = _between(thinned, first, T, np.eye(4), first.noise)
    values, vectors = np.linalg.eigh((J * weight[:, None]).T @ J * np.outer(lengths, lengths))
    return np.asarray((vectors[:, values < LOOSE * max(float(values[-1]), 1e-12)] * lengths[:, None]).T)
