"""The oracle: how significant an effect is to someone who knows its form, and which other effects look alike here."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cholesky, solve_triangular

from tools.trial.concealed.decks import SIGMA_M, SIGMA_RAD
from tools.trial.concealed.laws.flight import Flight
from tools.trial.concealed.laws.law import Law
from tools.trial.concealed.laws.matching import BASELINE, Matching
from tools.trial.concealed.shot import Shot

Array = NDArray[np.float64]

SIDE = 16
FAR = 0.05  # [m] another surface
FLOOR = {True: 2e-5, False: 5e-4}  # [m], [px]: what rounding leaves


@dataclass(frozen=True)
class Oracle:
    """Attributes:
    tiles: per shot and moment, the labels (h, w) of its tiles and the native units per metre of depth (h, w).
    root: (n, n) Cholesky factor of the covariance that the case really has.
    """

    device: Flight | Matching
    moments: list[tuple[Shot, int, NDArray[np.intp], Array]]
    root: Array

    def field(self, laws: Sequence[Law], known: Sequence[Law]) -> Array:
        """(n,) whitened: what `laws` change of the tiles."""
        parts = []
        for shot, frame, label, native in self.moments:
            change = self.device.clean(shot, [*known, *laws], frame) - self.device.clean(shot, known, frame)
            parts.append(_mean(change * native, label))
        return self.white(np.concatenate(parts))

    def moved(self, shots: Sequence[Shot]) -> Array:
        """(n,) whitened: what other poses of the same moments change of the tiles."""
        parts = []
        for (shot, frame, label, native), other in zip(self.moments, shots, strict=True):
            change = self.device.clean(other, [], frame) - self.device.clean(shot, [], frame)
            parts.append(_mean(np.where(np.abs(change) < FAR, change, 0.0) * native, label))
        return self.white(np.concatenate(parts))

    def measured(self, depth: Sequence[Array], predicted: Sequence[Array]) -> Array:
        """(n,) whitened: measured less predicted, (h, w) [m] each; where one is missing, nothing."""
        parts = []
        for (_, _, label, native), z, own in zip(self.moments, depth, predicted, strict=True):
            parts.append(_mean(np.where(np.isfinite(z), z - own, 0.0) * native, label))
        return self.white(np.concatenate(parts))

    def white(self, values: Array) -> Array:
        return np.asarray(solve_triangular(self.root, values, lower=True))


def oracle_of(device: Flight | Matching, shots: Sequence[Shot], known: Array, bow_m: float) -> Oracle:
    """`known` (k, 2): standard deviations of an offset and of a slope with depth that the sensor leaves open."""
    moments, blocks, commons = [], [], []
    flight = isinstance(device, Flight)
    for shot in shots:
        native = shot.stretch if flight else -shot.camera.f * BASELINE / shot.hits.z**2
        label = _tiles(shot.interior)
        for frame in range(0, len(shot.times), 2) if shot.long else [0]:
            frames = 2 if shot.long else len(shot.times)
            moments.append((shot, frame, label, native))
            pixels = np.bincount(label[label >= 0])
            pixels = pixels[pixels > 0]
            noise = _mean((device.sigma(shot) * native) ** 2, label) / pixels / frames
            noise = noise * (1.0 if flight else 4.0) + FLOOR[flight] ** 2
            blocks.append(noise)
            recording = id(shot) if shot.series is None else shot.series
            commons.append(("pose", recording, len(moments) - 1, _poses(shot, label, native)))
            commons.append(("frozen", id(shot), len(moments) - 1, _frozen(device, shot, label, native, bow_m)))
    ends = np.cumsum([0, *(len(b) for b in blocks)])
    total = np.diag(np.concatenate(blocks))
    columns: dict[tuple[str, int], list[tuple[slice, Array]]] = {}
    for kind, owner, i, common in commons:
        columns.setdefault((kind, owner), []).append((slice(ends[i], ends[i + 1]), common))
    for parts in columns.values():
        for rows, own in parts:
            for others, other in parts:
                total[rows, others] += own @ other.T
    for sizes in known:
        column = np.concatenate([sizes[0] + sizes[1] * _mean(m[0].hits.z, m[2]) for m in moments])
        total += np.outer(column, column)
    return Oracle(device, moments, cholesky(total, lower=True))


def _tiles(usable: NDArray[np.bool_]) -> NDArray[np.intp]:
    h, w = usable.shape
    label = (np.arange(h) // SIDE)[:, None] * (-(-w // SIDE)) + (np.arange(w) // SIDE)[None]
    counts = np.bincount(label[usable], minlength=int(np.max(label)) + 1)
    number = np.where(counts >= 80, np.cumsum(counts >= 80) - 1, -1)
    return np.where(usable, number[label], -1)


def _mean(image: Array, label: NDArray[np.intp]) -> Array:
    used = label >= 0
    return np.bincount(label[used], np.nan_to_num(image[used])) / np.bincount(label[used])


def _poses(shot: Shot, label: NDArray[np.intp], native: Array) -> Array:
    """(n, 6) errors that all moments of a recording share."""
    rays, z = shot.camera.rays(), np.nan_to_num(shot.hits.z)
    normals = np.array([panel.normal for panel in shot.panels])[shot.hits.panel] @ shot.T[:3, :3]
    facing = (normals * rays).sum(axis=-1)
    facing = np.where(np.abs(facing) < 1e-3, np.inf, facing)
    columns = []
    for axis in range(6):
        # the camera moves one way, what it sees the other
        way = np.eye(3)[axis % 3]
        motion = -np.cross(way, rays * z[..., None]) if axis < 3 else -np.broadcast_to(way, rays.shape)
        change = (normals * motion).sum(axis=-1) / facing
        columns.append(_mean(change * native, label) * shot.sigma * (SIGMA_RAD if axis < 3 else SIGMA_M))
    return np.column_stack(columns)


def _frozen(device: Flight | Matching, shot: Shot, label: NDArray[np.intp], native: Array, bow_m: float) -> Array:
    """(n, k) errors that last while the scene stands still: speckle, shape of the wall."""
    out = [np.zeros((int(np.max(label)) + 1, 1))]
    if isinstance(device, Matching):
        pixels = np.bincount(label[label >= 0])
        out.append(np.diag(device.speckle * device.speckle_window / np.sqrt(pixels)))
    if bow_m:
        at = np.column_stack([_mean(shot.hits.points[..., k], label) for k in (0, 2)])
        near = np.exp(-0.5 * ((at[:, None] - at[None]) ** 2).sum(-1) / 0.3**2)
        values, vectors = np.linalg.eigh(near)
        lever = _mean(native, label)
        out.append(lever[:, None] * bow_m * vectors * np.sqrt(np.maximum(values, 0)))
    return np.concatenate(out, axis=1)
