"""Two surfaces laid on each other by point-to-plane steps, in both directions, and how well they lie."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.geometry import pose
from fusion.geometry.robust import tukey
from fusion.mesh.comparison.surface_samples import SurfaceSamples
from fusion.passes.poses.sides import REACHED, PassSide

Array = NDArray[np.float64]
CHARGE = 5.0  # of surface that the other pass looked through, against 1 for surface that lies on the other (guess)
ALIKE = 0.5  # least cosine between normals of two surfaces that may be the same


@dataclass(frozen=True)
class Lying:
    """How two passes lie on each other under a transform; shares of the samples of both surfaces."""

    T: Array  # (4, 4) takes the second's points to the first's frame
    overlap: float  # surface that lies on the other within the noise
    through: float  # surface where the other pass looked through, or had its plate
    rms: float  # distance of the overlapping surfaces [m]

    @property
    def score(self) -> float:
        """What speaks for it less what speaks against it; at most 1.

        Free space is charged for: what both passes see best, the top, lies best on itself where it does not belong.
        """
        return self.overlap - CHARGE * self.through

    @property
    def agreement(self) -> float:
        """Of the surface of which the other pass says something, the share that it confirms."""
        return self.overlap / max(self.overlap + self.through, 1e-9)


def judged(first: PassSide, second: PassSide, T: Array) -> Lying:
    """How two passes lie under a transform."""
    back = pose.inverse(T)
    shares = [_one_way(first, second, T), _one_way(second, first, back)]
    overlap, through, square = np.mean(shares, axis=0)
    return Lying(T, float(overlap), float(through), float(np.sqrt(square / max(overlap, 1e-9))))


def _one_way(onto: PassSide, of: PassSide, T: Array) -> tuple[float, float, float]:
    """Shares of one surface that lie on the other and that it looked through, and its sum of squares [m^2]."""
    points, normals = pose.transform(T, of.few.points), _turned(T, of.few)
    within = max(onto.noise, of.noise)
    index, known = onto.nearest(points, within + REACHED * onto.spacing)
    off = np.einsum("ij,ij->i", points - onto.points[index], onto.normals[index])
    same = np.einsum("ij,ij->i", normals, onto.normals[index]) > ALIKE
    on = known & same & (np.abs(off) <= within)
    rest = np.flatnonzero(~on)
    through = onto.empty(points[rest], normals[rest])
    return float(on.mean()), float(through.sum() / len(on)), float(np.sum(off[on] ** 2) / len(on))


def laid(first: PassSide, second: PassSide, T: Array, reaches: Array, points: int) -> Array:
    """The transform (4, 4) after point-to-plane steps, one for each reach [m], from the widest to the finest.

    Args:
        first, second: both surfaces have a say, so that neither pulls where it ends.
        T: from where to begin.
        reaches: (k,) distance of pairs that count.
        points: of each surface, at most.
    """
    some = [_thinned(side.few, points) for side in (second, first)]
    for reach in reaches:
        H, g = np.zeros((6, 6)), np.zeros(6)
        add_equations((H, g), first, (pose.transform(T, some[0].points), _turned(T, some[0])), (float(reach), 1.0))
        back = pose.inverse(T)
        # the first's points seen from the second: the pair's normal and place in the first's frame
        here = pose.transform(back, some[1].points), _turned(back, some[1])
        index, weight, off = pairs(second, *here, float(reach))
        at = pose.transform(T, second.points[index])
        normal = second.normals[index] @ T[:3, :3].T
        _accumulate((H, g), at, normal, -off, weight)
        step = -np.linalg.solve(H + 1e-9 * np.trace(H) * np.eye(6) + 1e-12 * np.eye(6), g)
        T = pose.exp(step) @ T
    return T


def pairs(onto: PassSide, points: Array, normals: Array, reach: float) -> tuple[NDArray[np.intp], Array, Array]:
    """The nearest of a surface to points (n, 3): index (n,), weight (n,), distance along its normal (n,) [m]."""
    index, known = onto.nearest(points, reach + REACHED * onto.spacing)
    off = np.einsum("ij,ij->i", points - onto.points[index], onto.normals[index])
    same = np.einsum("ij,ij->i", normals, onto.normals[index])
    weight = tukey(off / reach, cut=1.0) * known * (same > ALIKE)
    return index, np.asarray(weight, float), off


def add_equations(
    system: tuple[Array, Array], onto: PassSide, what: tuple[Array, Array], how: tuple[float, float]
) -> None:
    """Add pairs of points and normals (n, 3), (n, 3) with a surface; `how`: reach [m], weight of all."""
    index, weight, off = pairs(onto, *what, how[0])
    _accumulate(system, what[0], onto.normals[index], off, how[1] * weight)


def _accumulate(system: tuple[Array, Array], points: Array, normals: Array, off: Array, weight: Array) -> None:
    """Normal equations of a twist (rotation, translation) on the left of points, added in place."""
    J = np.hstack([np.cross(points, normals), normals])
    system[0][:] += (J * weight[:, None]).T @ J
    system[1][:] += J.T @ (weight * off)


def _turned(T: Array, samples: SurfaceSamples) -> Array:
    assert samples.normals is not None
    return np.asarray(samples.normals @ T[:3, :3].T)


def _thinned(samples: SurfaceSamples, most: int) -> SurfaceSamples:
    assert samples.normals is not None
    step = max(1, len(samples.points) // most)
    return SurfaceSamples(samples.points[::step], samples.normals[::step])
