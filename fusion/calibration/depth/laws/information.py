"""What each wall says about the terms, with everything taken out that the wall itself may explain."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.calibration.depth.laws.terms import LawTerm
from fusion.calibration.depth.walls.board_patches import tiles_of_patches
from fusion.calibration.depth.walls.samples import WallSamples, samples_of
from fusion.calibration.depth.walls.tiles import TileGrid, tiles_of
from fusion.calibration.depth.walls.wall import Wall
from fusion.geometry.camera import Camera
from fusion.sensor.sensor import Sensor

LEAST = 2e-5  # [m] standard deviation of a tile's mean is never taken smaller
Array = NDArray[np.floating]


@dataclass(frozen=True)
class WallEvidence:
    """A wall as a linear problem: rest = terms @ numbers + nuisances + noise, a row per tile (t)."""

    # wall, tiles: where it comes from
    wall: Wall
    tiles: TileGrid
    samples: WallSamples  # where the terms are computed
    rest: Array  # (t,) depth less the wall's depth at its stated distance [m]
    terms: Array  # (t, k) change of the depth per unit of each term
    nuisances: Array  # (t, 3) change of the depth per unit of tilt about both axes, and of distance
    variance: Array  # (t,) [m^2] of a tile, correlation with its neighbours counted in
    distance_std: float  # [m], inf where the distance is not known; the tilts' own stands in the wall

    def projected(self, other: Array) -> Array:
        """W other - what the nuisances take of it: `a @ projected(b)` is the product after them; other (t, ...)."""
        w = 1 / self.variance
        WG = self.nuisances * w[:, None]
        inner = self.nuisances.T @ WG
        tilt = self.wall.tilt_std
        inner += np.diag(1 / np.array([tilt, tilt, self.distance_std]) ** 2)
        weighted = (other.T * w).T
        return weighted - WG @ np.linalg.solve(inner, WG.T @ other)


@dataclass(frozen=True)
class Information:
    """Sums over the tiles of walls after the nuisances."""

    # M, b, c: (k, k), (k,) and the weighted square of the rest
    M: Array
    b: Array
    c: float
    raw: Array  # (k,) norms of the terms before the nuisances
    prior: Array  # (k,) 1 / variance of the numbers before any wall is seen; 0 where all is possible

    def __add__(self, other: "Information") -> "Information":
        return Information(self.M + other.M, self.b + other.b, self.c + other.c, self.raw + other.raw, self.prior)

    @property
    def penalised(self) -> Array:
        """(k, k) M with the prior."""
        return self.M + np.diag(self.prior)

    def chi2(self, chosen: list[int], numbers: Array) -> float:
        """Weighted square of what these numbers leave over."""
        return float(self.c - 2 * numbers @ self.b[chosen] + numbers @ self.M[np.ix_(chosen, chosen)] @ numbers)

    def fit(self, chosen: list[int]) -> Array:
        """The numbers (n,) of the chosen terms."""
        if not chosen:
            return np.zeros(0)
        M, scale = self._scaled(chosen)
        return np.linalg.lstsq(M, self.b[chosen] / scale, rcond=1e-10)[0] / scale

    def covariance(self, chosen: list[int]) -> Array:
        """(n, n) of the fitted numbers."""
        M, scale = self._scaled(chosen)
        return np.linalg.pinv(M, rcond=1e-10, hermitian=True) / np.outer(scale, scale)

    def _scaled(self, chosen: list[int]) -> tuple[Array, Array]:
        scale = np.sqrt(np.maximum(self.raw[chosen] + self.prior[chosen], 1e-300))
        M = self.M[np.ix_(chosen, chosen)] + np.diag(self.prior[chosen])
        return M / np.outer(scale, scale), scale


def evidence_of(wall: Wall, camera: Camera, sensor: Sensor, terms: list[LawTerm]) -> WallEvidence:
    """The linear problem of a wall; the variance is a first one, from the noise of the frames."""
    mask = wall.mask & np.isfinite(wall.depth)
    tiles = tiles_of(mask) if wall.squares is None else tiles_of_patches(wall.squares, mask)
    samples = samples_of(wall, camera, sensor, tiles)
    noise = np.nan_to_num(wall.std, nan=0.0) ** 2 / wall.frames
    return WallEvidence(
        wall,
        tiles,
        samples,
        tiles.mean(np.where(wall.mask, wall.depth - wall.true_plane.depth(camera), 0.0)),
        terms_of(samples, terms),
        _nuisances(wall, camera, tiles),
        tiles.mean(noise) / tiles.count + LEAST**2,
        wall.distance_std if np.isfinite(wall.distance) else np.inf,
    )


def terms_of(samples: WallSamples, terms: list[LawTerm]) -> Array:
    """(t, k) change of the depth per unit of each term, as means over the tiles."""
    columns = [samples.tile_means(term.change(samples)) for term in terms]
    return np.column_stack(columns) if columns else np.zeros((len(np.unique(samples.label)), 0))


def _nuisances(wall: Wall, camera: Camera, tiles: TileGrid) -> Array:
    """(t, 3) change of z = D (1 + a x0 + b y0) / (1 + a x + b y) with a, b and D, the depth at the centre (x0, y0)."""
    plane, rays = wall.true_plane, camera.rays().astype(float)
    depth = plane.depth(camera)
    x0, y0 = wall.centre
    at_centre = plane.inverse_at(x0, y0)
    turned = -(depth**2) / plane.distance
    columns = (
        turned * rays[..., 0] + depth * x0 / at_centre,
        turned * rays[..., 1] + depth * y0 / at_centre,
        depth * at_centre / plane.distance,
    )
    return np.column_stack([tiles.mean(np.nan_to_num(column)) for column in columns])


def information_of(evidence: WallEvidence, terms: list[LawTerm]) -> Information:
    """The sums of one wall."""
    A, y = evidence.terms, evidence.rest
    PA, Py = evidence.projected(A), evidence.projected(y)
    prior = np.array([term.prior for term in terms])
    return Information(A.T @ PA, A.T @ Py, float(y @ Py), ((A**2).T / evidence.variance).sum(axis=1), prior)
