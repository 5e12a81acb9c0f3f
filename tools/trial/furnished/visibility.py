"""How well an effect can be seen over the noise, once the camera's poses have had their way with it."""

from dataclasses import dataclass

import numpy as np

from tools.trial.furnished.physics.bench import Bench, CameraRun
from tools.trial.furnished.physics.noise import by_pose, depth_sigma, edges
from tools.trial.furnished.physics.poses import Array
from tools.trial.furnished.physics.recorder import TakenFrames, record
from tools.trial.furnished.physics.sensor import Effects, any_of

AS_A_POSE = ("camera", "clock", "line_delay", "drift")  # at edges these act as a pose does


@dataclass(frozen=True)
class Visibility:
    """Attributes:
    sigma: standard deviations at which the effect shows: an own estimate of what detection could reach.
    shifts: per recording (frames or 1, h, w) [m] expected change of depth.
    """

    sigma: float
    shifts: list[Array]


@dataclass
class TileSums:
    """Normal equations of one frame's tiles: by pose (6, 6), (6,), and the squares of the shift."""

    matrix: Array
    vector: Array
    square: float


def visibility(
    bench: Bench, recordings: list[CameraRun], effects: Effects, sigma: tuple[float, float], channel: str
) -> Visibility:
    """`sigma`: [m, rad] of stated poses; `channel`: where the effect shows."""
    square = noise = 0.0
    lost, shifts = 0, []
    for one in recordings:
        without, with_ = record(bench, one, {}, False), record(bench, one, effects, False)
        change = np.array([b - a for a, b in zip(without.depth, with_.depth, strict=True)])
        pairs = zip(without.depth, with_.depth, strict=True)
        lost += sum(int((np.isfinite(a) & ~np.isfinite(b)).sum()) for a, b in pairs)
        if channel in ("noise", "quant"):
            frames = range(len(one.times))
            noise = sum((_noisier(bench, without, with_, k, effects, change[k]) for k in frames), noise)
        else:
            sums = [_sums(bench, without, k, effects, change[k]) for k in range(len(one.times))]
            if channel == "bias":
                square += _beside_poses(sums, sigma, one.static)
        shifts.append(_shortest(change, one.static))
    if channel == "dropout":
        return Visibility(float(np.sqrt(lost)), shifts)
    return Visibility(float(np.sqrt(noise if channel in ("noise", "quant") else square)), shifts)


def _shortest(change: Array, static: bool) -> Array:
    """One frame for all where they are alike."""
    alike = static and np.allclose(np.nan_to_num(change), np.nan_to_num(change[:1]))
    return (change[:1] if alike else change).astype(np.float32)


def _noisier(bench: Bench, without: TakenFrames, with_: TakenFrames, k: int, effects: Effects, change: Array) -> float:
    """Squared deviations of the noise's variance in frame k; a factor of e counts as one."""
    before = depth_sigma(bench, {}, without.hits[k], without.amplitude[k])
    after = depth_sigma(bench, effects, with_.hits[k], with_.amplitude[k])
    if "jitter" in effects:
        slope = np.abs(np.gradient(np.nan_to_num(without.depth[k]), axis=1))
        after = np.sqrt(before**2 + (effects["jitter"] * np.minimum(slope, 0.3)) ** 2)
    known = np.isfinite(change) & np.isfinite(before) & (before > 0)
    ratio = np.log(after[known] ** 2 / before[known] ** 2)
    return float((np.minimum(np.abs(ratio), 1) ** 2).sum() / 2)


def _sums(bench: Bench, without: TakenFrames, k: int, effects: Effects, change: Array) -> TileSums:
    """Of the tiles of frame k."""
    z, hits = without.depth[k], without.hits[k]
    sigma = depth_sigma(bench, {}, hits, without.amplitude[k])
    known = np.isfinite(change) & np.isfinite(sigma) & (sigma > 0)
    if any_of(effects, AS_A_POSE):
        known &= ~edges(z, 2) & (np.abs(np.nan_to_num(change)) < 0.1 * np.nan_to_num(z))
    at_edge = edges(z, 1) * 0.02 * np.nan_to_num(z)
    with np.errstate(divide="ignore"):
        weight = np.where(known, 1 / np.sqrt(sigma**2 + at_edge**2), 0)
    width = bench.camera.width
    tile = max(2, width // 20) if width > 32 else 1
    root = np.sqrt(np.maximum(_tiled(weight**2, tile), 1e-9))
    shift = (_tiled(weight**2 * np.nan_to_num(change), tile) / root).ravel()
    poses = (_tiled((weight**2)[..., None] * by_pose(hits), tile) / root[..., None]).reshape(-1, 6)
    return TileSums(poses.T @ poses, poses.T @ shift, float(shift @ shift))


def _tiled(image: Array, tile: int) -> Array:
    """Sums over tiles of (h, w, ...); what is left over at the ends is not used."""
    rows, columns = image.shape[0] // tile, image.shape[1] // tile
    cut = image[: rows * tile, : columns * tile]
    return cut.reshape(rows, tile, columns, tile, *image.shape[2:]).sum((1, 3))


def _beside_poses(sums: list[TileSums], sigma: tuple[float, float], static: bool) -> float:
    """chi2 of the shift that poses within their errors do not explain."""
    variances = np.r_[[sigma[0] ** 2] * 3, [sigma[1] ** 2] * 3]
    square = 0.0
    for one in sums:
        square += one.square
    if static:
        matrix, vector = np.zeros((6, 6)), np.zeros(6)
        for one in sums:
            matrix += one.matrix
            vector += one.vector
        return max(0.0, float(square - vector @ np.linalg.solve(matrix + np.diag(1 / variances), vector)))
    # half of the poses' variance is common to a recording, half new in each frame
    covariance = np.kron(np.eye(len(sums)) + 1, np.diag(variances) / 2)
    matrix = np.linalg.inv(covariance)
    vector = np.concatenate([one.vector for one in sums])
    for k, one in enumerate(sums):
        matrix[6 * k : 6 * k + 6, 6 * k : 6 * k + 6] += one.matrix
    return max(0.0, float(square - vector @ np.linalg.solve(matrix, vector)))
