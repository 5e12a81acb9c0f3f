"""The covariance: how far every tile may be off for known reasons, and residuals measured in it."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cholesky, solve_triangular
from scipy.linalg.lapack import dpotri

from fusion.discrepancy.inference.camera_file import camera_columns
from fusion.discrepancy.inference.covariance import drifting, grain, neighbours
from fusion.discrepancy.inference.own_pattern import own_patterns
from fusion.discrepancy.inference.rounding import DOUBT, rounding_covariance
from fusion.discrepancy.inference.shapes import mesh_columns, shape_covariance
from fusion.discrepancy.inference.surroundings import surroundings_columns
from fusion.discrepancy.observe.observations import Observations
from fusion.discrepancy.observe.patch import Patch
from fusion.discrepancy.observe.placements import FLOOR_M
from fusion.sensor.effect import Effect
from fusion.sensor.parameter import parameters

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

# what the model of a tile leaves open, in native units, as that of a square
FLOOR = {True: FLOOR_M, False: 7e-4}  # [m] time of flight, [px] triangulation


@dataclass(frozen=True)
class TileCovariance:
    """Covariance of the tiles when nothing is missing: noise, speckle, poses, the target's shape, known parameters."""

    root: NDArray[np.float64]  # (n, n) lower Cholesky factor of the covariance
    # (n, n) covariance without poses and known parameters: what a perfect setting would leave
    free: NDArray[np.float64]
    # (n, k) change per standard deviation of each known parameter, in native units: common to all recordings
    known: NDArray[np.float64]

    def whiten(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Vectors (n,) or (n, k) as independent numbers of unit spread."""
        return np.asarray(solve_triangular(self.root, values, lower=True, check_finite=False))

    @cached_property
    def bare(self) -> NDArray[np.float64]:
        """(n, n) lower Cholesky factor of `free`."""
        return np.asarray(cholesky(self.free, lower=True, check_finite=False))

    @cached_property
    def inverse(self) -> NDArray[np.float64]:
        """(n, n) inverse of the covariance."""
        lower, _ = dpotri(self.root, lower=1)  # above the diagonal it holds nothing, as the factor does
        return np.asarray(lower + lower.T - np.diag(np.diag(lower)))

    def pulled(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Whitened vectors (n,) or (n, k) as the weights of the tiles that they are products with."""
        return np.asarray(solve_triangular(self.root, values, lower=True, trans="T", check_finite=False))

    def visible(self, values: NDArray[np.float64]) -> float:
        """Share of the norm of vectors (n,) or (n, k) that poses and known parameters leave to be seen."""
        free = solve_triangular(self.bare, values, lower=True, check_finite=False)
        return float(np.linalg.norm(self.whiten(values))) / max(float(np.linalg.norm(free)), 1e-300)


class MeasuredTiles(NamedTuple):
    """Tiles, and how far they may be off."""

    observations: Observations
    covariance: TileCovariance


def covariance_of(observations: Observations) -> TileCovariance:
    """The covariance of observations: their frame noise averaged, frozen and common errors as covariance."""
    n = len(observations.residual)
    total, noise = np.zeros((2, n, n))
    for rows, patch in observations.rows():
        noise[rows, rows] += _noise(patch)
    for effect in observations.sensor.effects:
        if effect.frozen == "scene":
            _add_grain(observations, effect, total)
            if any(_simulated(patch).any() for patch in observations.patches):
                _add_grain(observations, effect, total)  # of the simulation, which has its own
    total += shape_covariance(observations)
    total[np.diag_indices(n)] += (observations.loose.scatter * observations.looseness) ** 2
    if observations.loose.drift:
        drift = drift_columns(observations)
        total += observations.loose.drift**2 * (drift @ drift.T)
    shaken = np.column_stack([np.zeros((n, 0)), *_shake_columns(observations)])
    total += shaken @ shaken.T
    around = surroundings_columns(observations)
    total[np.diag_indices(n)] += around[:, 1] ** 2  # of a filter that keeps edges some tiles show less
    free = total + noise
    known = np.column_stack([np.zeros((n, 0)), *_known(observations)])
    loose, none = observations.loose, np.zeros((n, 0))
    wrong = loose.mesh * mesh_columns(observations) if loose.mesh else none
    other = loose.camera * camera_columns(observations) if loose.camera else none
    frames = loose.frames * frame_columns(observations) if loose.frames else none
    patterns = own_patterns(observations)
    total += patterns
    common = np.column_stack([*pose_columns(observations), frames, wrong, other, known, around])
    total += common @ common.T
    # as far as tiles are off at all: of the tiles near a step as many change to the next as a law moves its edge
    law = float(np.mean(np.abs(observations.residual)))
    total += noise + rounding_covariance(observations, total, patterns, law, DOUBT)
    return TileCovariance(cholesky(total, lower=True, overwrite_a=True, check_finite=False), free, known)


def drift_columns(observations: Observations) -> NDArray[np.float64]:
    """(n, k) columns of which the products sum up to the covariance of a drift of unit standard deviation, usually."""
    place, width = observations.place, observations.patches[0].view.camera.width
    at = np.concatenate([(patch.tiles.cell + 0.5) * patch.tiles.side for patch in observations.patches])
    side = max(patch.tiles.side for patch in observations.patches)
    blocks = []
    for g in np.unique(place):
        own = drifting(at[place == g], side, width)
        block = np.zeros((len(place), own.shape[1]))
        block[place == g] = own
        blocks.append(block)
    return np.asarray(np.concatenate(blocks, axis=1) * observations.looseness[:, None])


def _noise(patch: Patch) -> NDArray[np.float64]:
    """Covariance (n, n) of the mean over frames, and a floor."""
    tiles, frames = patch.tiles, len(patch.block.frames)
    variance = tiles.mean((patch.sigma * patch.native) ** 2)
    # what is measured: a model whose noise is too small would make laws of the rest
    variance = np.fmax(variance, tiles.mean((patch.block.std * patch.native) ** 2))
    window, shared = 1.0, np.zeros(len(tiles))
    for effect in patch.sensor.effects:
        if not effect.frozen and effect.window(patch.view) > 1:
            window = max(window, effect.window(patch.view))
            shared = np.hypot(shared, _size(patch, effect))
    # a tile with fewer pixels averages less
    shared = np.minimum(np.sqrt(variance), shared) * np.sqrt(tiles.side**2 / tiles.pixels)
    own = (variance - np.minimum(variance, shared**2 * tiles.pixels / tiles.side**2)) / tiles.pixels
    spread = grain(tiles.cell, tiles.cell, tiles.side, window) * np.outer(shared, shared)
    if patch.alike is not None:
        # neighbours that share their noise without the model's knowing: frames show it
        own = np.maximum(own, neighbours(patch.alike, tiles.side) * variance / tiles.pixels - np.diag(spread))
    floor = FLOOR[patch.view.time_of_flight] ** 2
    # noise of a simulation that stands for the prediction comes on top
    more = 1.0 + _simulated(patch) * frames / np.maximum(variance, 1e-300)
    spread = spread * np.sqrt(np.outer(more, more))
    return spread / frames + np.diag(own * more / frames + floor)


def _simulated(patch: Patch) -> Vector:
    """(n,) variance of the mean that a simulation predicts, from its own noise."""
    given = patch.block.given
    return np.zeros(len(patch.tiles)) if given is None else patch.tiles.mean((given.doubt * patch.native) ** 2)


def _add_grain(observations: Observations, effect: Effect, total: NDArray[np.float64]) -> None:
    """Add the covariance of an error that is frozen while the scene stands still, and drawn anew when it moves."""
    for rows, patch in observations.rows():
        for others, other in observations.rows():
            if other.block.place == patch.block.place and _still(patch, other):
                alike = grain(patch.tiles.cell, other.tiles.cell, patch.tiles.side, effect.window(patch.view))
                total[rows, others] += alike * np.outer(_size(patch, effect), _size(other, effect))


def _still(patch: Patch, other: Patch) -> bool:
    """True when the camera sees the scene from the same place."""
    return bool(np.allclose(patch.block.T_world_camera, other.block.T_world_camera, atol=1e-6))


def _size(patch: Patch, effect: Effect) -> Vector:
    """(n,) spread of a pixel by one effect, in native units."""
    with np.errstate(all="ignore"):
        return np.sqrt(patch.tiles.mean((effect.noise(patch.depth, patch.view) * patch.native) ** 2))


def pose_columns(observations: Observations) -> list[Vector]:
    """A column (n,) per recording and direction: one standard deviation of its common pose error, as it is."""
    columns = []
    for place in np.unique(observations.place):
        own = [(rows, patch) for rows, patch in observations.rows() if patch.block.place == place]
        stage = own[0][1].block.stage
        sizes = observations.loose.pose * np.repeat([stage.sigma_rad, stage.sigma_m], 3)
        columns += [size * column for size, column in zip(sizes, _moved(own, len(observations.residual)), strict=True)]
    return columns


def _shake_columns(observations: Observations) -> Iterator[Vector]:
    """A column (n,) per block and direction: what is left of the shakes of its frames in their mean."""
    for rows, patch in observations.rows():
        if patch.block.shaken:
            sizes = np.repeat(patch.block.shaken, 3) / np.sqrt(len(patch.block.frames))
            columns = _moved([(rows, patch)], len(observations.residual))
            yield from (size * column for size, column in zip(sizes, columns, strict=True))


def frame_columns(observations: Observations) -> Matrix:
    """(n, k) a column per view of a moving camera and direction: one standard deviation of an error of that pose alone;
    none of cameras that stood still."""
    views: dict[int, dict[bytes, list[tuple[slice, Patch]]]] = {}
    for rows, patch in observations.rows():
        pose = patch.block.T_world_camera.round(6).tobytes()
        views.setdefault(patch.block.place, {}).setdefault(pose, []).append((rows, patch))
    columns = [np.zeros((len(observations.residual), 0))]
    for view in (view for own in views.values() if len(own) > 1 for view in own.values()):
        stage, moved = view[0][1].block.stage, _moved(view, len(observations.residual))
        columns.append(np.column_stack(moved) * np.repeat([stage.sigma_rad, stage.sigma_m], 3))
    return np.concatenate(columns, axis=1)


def _moved(patches: Sequence[tuple[slice, Patch]], n: int) -> list[Vector]:
    """Six columns (n,): all that patches show turned about each axis by a radian, and shifted along it by a metre."""
    columns = [np.zeros(n) for _ in range(6)]
    for rows, patch in patches:
        for column, change in zip(columns, patch.motions, strict=True):
            column[rows] = change
    return columns


def _known(observations: Observations) -> list[Vector]:
    """A column (n,) per parameter of the sensor model whose value is known with a standard deviation only."""
    columns = []
    sensor = observations.sensor
    for effect in sensor.effects:
        if not effect.changes("bias") or effect.frozen:
            continue
        others = []
        for name, about in parameters(effect).items():
            std, value = float(np.max(sensor.std.get((effect.name, name), 0.0))), getattr(effect, name)
            if std > 0 and not np.ndim(value):
                step: dict[str, Any] = {name: float(value) + (std if value + std <= about.high else -std)}
                others.append(replace(effect, **step))
        if others:
            own, *moved = observations.columns([effect, *others]).T
            columns += [other - own for other in moved if np.any(other != own)]
    return columns
