"""Robust point-to-plane ICP of samples against one surface, from a pose that is near already."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.robust import MAD_TO_STD
from fusion.mesh.alignment.coarse import NEAR
from fusion.mesh.alignment.similarity import Array, Matches, Similarity, step, tukey
from fusion.mesh.comparison.distances import Surface
from fusion.mesh.comparison.surface_samples import SurfaceSamples

_TUKEY = 4.685  # limit in standard deviations: 95 % as efficient as least squares on Gaussian noise
_FACING = 0.25  # cosine of normals that may belong together: a plate's top is not the foot that stands on it (guess)
_STILL = (1e-8, 5e-6)  # of the size: moved so little in a step, or so little and no less than before


@dataclass(frozen=True)
class SurfaceFit:
    """ICP against one reference, of size `size` [m]."""

    surface: Surface
    size: float
    facing: bool = False  # only where the normals of both sides agree; for a pose that is nearly right

    def run(self, samples: SurfaceSamples, pose: Similarity, scale: bool, rounds: int) -> tuple[Similarity, Matches]:
        """Steps until nothing moves any more; the limit of the weights only shrinks, down to the noise."""
        limit = 3 * NEAR * self.size
        last = np.inf
        at_least = np.zeros(len(samples.points))  # distance of each point [m]: what is far for sure is not looked up
        for _ in range(rounds):
            matches, limit = self._matches(samples, pose, limit, at_least)
            pose, moved = step(pose, matches, scale)
            at_least -= np.linalg.norm(pose.apply(samples.points) - matches.points, axis=1)
            # at the end steps no longer shrink: points hop from triangle to triangle
            if moved < _STILL[0] * self.size or last <= moved < _STILL[1] * self.size:
                break
            last = moved
        return pose, self._matches(samples, pose, limit, at_least)[0]

    def _matches(
        self, samples: SurfaceSamples, pose: Similarity, limit: float, at_least: Array
    ) -> tuple[Matches, float]:
        points = pose.apply(samples.points)
        turned = None if samples.normals is None else samples.normals @ pose.rotation.T
        rows = np.flatnonzero(at_least <= limit)
        found = self.surface.closest(points[rows], None if turned is None else turned[rows])
        distance = np.abs(found.distances)
        at_least[rows] = distance
        usable = ~found.on_border  # beyond the reference's end there is nothing to lie on
        if self.facing and turned is not None:
            usable &= _alike(turned[rows], found.normals, usable & (distance < limit))
        if usable.sum() < 0.2 * len(points):
            usable = np.ones_like(usable)
        # the spread of those still counted: outliers are left behind, round by round
        core = distance[usable & (distance < limit)]
        spread = MAD_TO_STD * float(np.median(core)) if len(core) else self.size
        limit = min(limit, max(_TUKEY * spread, 1e-5 * self.size))
        targets, normals, weights = points.copy(), np.zeros_like(points), np.zeros(len(points))
        targets[rows], normals[rows], weights[rows] = found.points, found.normals, tukey(distance, limit) * usable
        return Matches(points, targets, normals, weights), limit


def _alike(here: Array, there: Array, counted: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Where normals (n, 3) of both sides agree; everywhere, if most of those counted do not: one is inside out."""
    alike = np.einsum("ij,ij->i", here, there) > _FACING
    return alike if alike[counted].sum() > 0.5 * counted.sum() else np.ones_like(alike)
