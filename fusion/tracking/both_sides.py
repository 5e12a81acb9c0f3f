"""What both sides of an alignment show: shape, and not the noise of normals, which each side has for itself.

A wall resists sliding along itself only by the noise of its normals. Noise in both factors of a product adds up to a
false information; the normals of two views err independently, so products of one's with the other's have no such part.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.geometry import pose
from fusion.geometry.depth import PointMap
from fusion.geometry.robust import CUT, robust_std, tukey
from fusion.tracking.equations import Points, thinned

Array = NDArray[np.float64]
SOME = 1000  # pairs that tell mean squares to a twentieth
FEWEST = 100
NONE = 1e-9  # of the largest information: rounding
LEAST = 1e-6  # [m] a depth without a stated noise


@dataclass(frozen=True)
class Pairs:
    """Points of a source, and what a model shows in their pixels within a reach."""

    arm: Array  # (n, 3) from the source's centroid, in the model's camera [m]
    normals: Array  # (n, 3) of the source
    facing: Array  # (n, 3) of the model
    apart: Array  # (n,) along the model's normal [m]
    sigma: Array  # (n,) of that [m]

    def resist(self, scale: float = 1.0) -> tuple[Array, Array]:
        """(n, 6) how each resists turns about the centroid and shifts, as its source and as the model sees it.

        Args:
            scale: divides arms [m].
        """
        arm = self.arm / scale
        mine, its = (np.hstack([np.cross(arm, n), n]) for n in (self.normals, self.facing))
        return mine, its


def paired(source: Points, T_model_source: Array, model: PointMap, reach: float) -> Pairs:
    """Those of a source's points that lie within a reach [m] of what the model shows at a pose (4, 4)."""
    rows = np.asarray(np.moveaxis(source.lanes, 1, 0), np.float64).reshape(7, -1)
    rows = rows[:, rows[6] >= 0].T
    points = pose.transform(T_model_source, rows[:, :3])
    normals = rows[:, 3:6] @ T_model_source[:3, :3].T
    camera = model.camera
    pixels = np.rint(camera.project(points))
    inside = np.isfinite(pixels).all(axis=1) & (points[:, 2] > 0) & (pixels >= 0).all(axis=1)
    inside &= (pixels < (camera.width, camera.height)).all(axis=1)
    u, v = pixels[inside].astype(int).T
    points, normals, sigma = points[inside], normals[inside], rows[inside, 6]
    there, facing = model.points[v, u].astype(float), model.normals[v, u].astype(float)
    apart = np.einsum("ij,ij->i", points - there, facing)
    met = np.linalg.norm(points - there, axis=1) < 2 * reach  # beside each other along the surface, too
    met &= np.isfinite(apart) & (np.abs(apart) < reach)
    spread = np.maximum(np.hypot(sigma, model.sigma[v, u])[met], LEAST)
    centre = pose.transform(T_model_source, source.centre)
    return Pairs(points[met] - centre, normals[met], facing[met], apart[met], spread)


def shape_seen(source: Points, T_model_source: Array, model: PointMap, reach: float, min_cosine: float) -> Array | None:
    """(6, 6) mean products of how both sides of pairs resist small motions, turns times the points' spread.

    None of too few pairs.

    Args:
        source: to be placed.
        T_model_source: about where (4, 4).
        model: in its camera.
        reach: largest distance of a pair [m].
        min_cosine: smallest cosine between the normals of a pair.
    """
    pairs = paired(thinned(source, SOME), T_model_source, model, reach)
    use = np.sum(pairs.facing * pairs.normals, axis=1) > min_cosine
    if use.sum() < FEWEST:
        return None
    mine, its = pairs.resist(max(source.radius, 1e-6))
    both = mine[use].T @ its[use] / use.sum()
    return np.asarray((both + both.T) / 2)


def by_relief(information: Array, source: Points, model: PointMap, T_model_source: Array, reach: float) -> Array:
    """The information (6, 6) of an alignment that both surfaces' normals bear out; no direction has less than none.

    Args:
        information: (6, 6) as the alignment gives it, by the model's normals alone; where it has none, it stood still.
        T_model_source: (4, 4) as aligned.
        reach: largest distance of a pair [m].
    """
    pairs = paired(source, T_model_source, model, reach)
    if not len(pairs.apart):
        return np.zeros((6, 6))
    scale = max(robust_std(pairs.apart / pairs.sigma), 1.0)
    weight = tukey(pairs.apart / (scale * pairs.sigma), CUT) / pairs.sigma**2
    mine, its = pairs.resist()
    both, alone = mine.T @ (weight[:, None] * its), its.T @ (weight[:, None] * its)
    unit = np.repeat([1 / max(source.radius, 1e-6), 1.0], 3)
    units = np.outer(unit, unit)
    held, axes = np.linalg.eigh(information * units)
    axes = axes[:, held > NONE * held[-1]]
    seen = axes.T @ (units * (both + both.T) / 2 * np.trace(information) / np.trace(alone)) @ axes
    values, vectors = np.linalg.eigh(seen)
    axes = axes @ vectors
    return np.asarray((axes * np.maximum(values, 0.0)) @ axes.T / units)
