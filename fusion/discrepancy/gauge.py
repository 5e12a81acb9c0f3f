"""The gauge: how far every tile may be off for known reasons, and residuals measured in it."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cholesky, solve_triangular

from fusion.discrepancy.covariance import bow, grain
from fusion.discrepancy.observations import Observations, Patch
from fusion.sensor.effects.readout.axial_noise import AxialNoise
from fusion.sensor.effects.triangulation.speckle_noise import SpeckleNoise
from fusion.sensor.parameter import parameters
from fusion.sensor.surface import moved_rigidly, towards

Vector = NDArray[np.float64]

# what the model of a tile leaves open, in native units: guess, a hundredth of usual noise
FLOOR = {True: 2e-5, False: 7e-4}  # [m] time of flight, [px] triangulation
TWIST = 1e-3  # [rad], [m] small enough to be linear


@dataclass(frozen=True)
class Gauge:
    """Covariance of the tiles when nothing is missing: noise, speckle, poses, the target's shape, known parameters.

    Attributes:
        root: (n, n) lower Cholesky factor of the covariance.
        bare: the same without poses and known parameters: what a perfect setting would leave.
    """

    root: NDArray[np.float64]
    bare: NDArray[np.float64]

    def whiten(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Vectors (n,) or (n, k) as independent numbers of unit spread."""
        return np.asarray(solve_triangular(self.root, values, lower=True, check_finite=False))

    def visible(self, values: NDArray[np.float64]) -> float:
        """Share of the norm of a vector (n,) that poses and known parameters leave to be seen."""
        free = solve_triangular(self.bare, values, lower=True, check_finite=False)
        return float(np.linalg.norm(self.whiten(values))) / max(float(np.linalg.norm(free)), 1e-300)


def gauge_of(observations: Observations) -> Gauge:
    """The gauge of observations: their frame noise averaged, frozen and common errors as covariance."""
    n = len(observations.residual)
    total = np.zeros((n, n))
    speckle = observations.sensor.effect("speckle_noise")
    for rows, patch in observations.rows():
        total[rows, rows] += _noise(observations, patch)
        if isinstance(speckle, SpeckleNoise):
            for others, other in observations.rows():
                if other.look.place == patch.look.place:
                    alike = grain(patch.tiles.cell, other.tiles.cell, patch.tiles.side, float(speckle.correlation_px))
                    total[rows, others] += float(np.mean(speckle.sigma_px)) ** 2 * alike
    _add_shape(observations, total)
    bare = cholesky(total, lower=True, check_finite=False)
    common = np.column_stack([*_poses(observations), *_known(observations)])
    total += common @ common.T
    return Gauge(cholesky(total, lower=True, overwrite_a=True, check_finite=False), bare)


def _noise(observations: Observations, patch: Patch) -> NDArray[np.float64]:
    """Covariance (n, n) of the mean over frames, and a floor."""
    tiles, frames = patch.tiles, len(patch.look.frames)
    variance = tiles.mean((patch.sigma * patch.native) ** 2)
    axial = observations.sensor.effect("axial_noise")
    shared = np.zeros(len(tiles))
    window = 0.0
    if isinstance(axial, AxialNoise) and np.any(axial.sigma_px) and not patch.view.time_of_flight:
        window = float(np.mean(axial.correlation_px))
        shared = np.minimum(np.sqrt(variance), float(np.mean(axial.sigma_px))) if window > 1 else shared
    # a tile with fewer pixels averages less
    shared = shared * np.sqrt(tiles.side**2 / tiles.pixels)
    own = (variance - np.minimum(variance, shared**2 * tiles.pixels / tiles.side**2)) / tiles.pixels
    spread = grain(tiles.cell, tiles.cell, tiles.side, window) * np.outer(shared, shared)
    floor = FLOOR[patch.view.time_of_flight] ** 2
    return spread / frames + np.diag(own / frames + floor)


def _add_shape(observations: Observations, total: NDArray[np.float64]) -> None:
    """Add the covariance of a target that is not quite its mesh: one shape in all recordings of that mesh."""
    known = []
    for rows, patch in observations.rows():
        if patch.look.stage.mesh_sigma_m:
            seen = patch.view.camera.points(patch.depth)
            at = np.column_stack([patch.tiles.mean(seen[..., axis]) for axis in range(3)])
            T = patch.look.T_world_camera
            lever = patch.tiles.mean(patch.native / towards(patch.view)) * patch.look.stage.mesh_sigma_m
            known.append((rows, patch.look.stage.shape, at @ T[:3, :3].T + T[:3, 3], lever))
    for rows, shape, points, lever in known:
        for others, other_shape, other_points, other_lever in known:
            if shape == other_shape:
                total[rows, others] += bow(points, other_points, 1.0) * np.outer(lever, other_lever)


def _poses(observations: Observations) -> list[Vector]:
    """A column (n,) per recording and direction: one standard deviation of its common pose error."""
    columns = []
    for place in np.unique(observations.place):
        for axis in range(6):
            column = np.zeros(len(observations.residual))
            for rows, patch in observations.rows():
                if patch.look.place == place:
                    stage = patch.look.stage
                    size = stage.sigma_rad if axis < 3 else stage.sigma_m
                    motion = TWIST * np.eye(6)[axis]
                    change = moved_rigidly(patch.depth, motion, patch.view) * patch.native
                    column[rows] = patch.tiles.mean(change) * size / TWIST
            columns.append(column)
    return columns


def _known(observations: Observations) -> list[Vector]:
    """A column (n,) per parameter of the sensor model whose value is known with a standard deviation only."""
    columns = []
    sensor = observations.sensor
    for effect in sensor.effects:
        for name, about in parameters(effect).items():
            std = float(np.max(sensor.std.get((effect.name, name), 0.0)))
            value = getattr(effect, name)
            if not effect.changes("bias") or effect.frozen or std <= 0 or np.ndim(value):
                continue
            step = std if value + std <= about.high else -std
            other = replace(effect, **{name: float(value) + step})
            column = observations.columns([other])[:, 0] - observations.columns([effect])[:, 0]
            if np.any(column):
                columns.append(column)
    return columns
