"""The standard deviation of every vertex along its normal, put together from what each cause does there."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from fusion.certainty.bend import bend, moved_by_blur
from fusion.certainty.common import Common
from fusion.certainty.looks import Looks
from fusion.certainty.shared import Shared
from fusion.mesh.mesh import Mesh

Array = NDArray[np.float64]
AROUND = 12  # vertices nearby that are taken for one place: their views differ alike (guess)
LEAST_PLACES = 7  # as many as a motion and a size have numbers
WORTH = 8.0  # looks that the scan's own mean counts for beside a place's (guess)


@dataclass(frozen=True)
class SigmaFigures:
    """`sigma` of the vertices in three numbers [m], its causes, and what all vertices share."""

    sigma_median_m: float
    sigma_p5_m: float
    sigma_p95_m: float
    parts_rms_m: dict[str, float | None]
    unknown: tuple[str, ...]
    views_share: dict[str, float | None]
    common: dict[str, float | str | None]
    unseen_share: float


@dataclass(frozen=True)
class Sure:
    """How sure a surface is."""

    sigma: NDArray[np.float32]  # (n,) standard deviation of each vertex along its normal [m], all causes together
    parts: dict[str, float | None]  # root mean square over the vertices of each cause [m]; None where nothing tells it
    unknown: tuple[str, ...]  # what nothing tells, and is therefore not in `sigma`
    shared: Shared  # how much of their errors views share
    common: Common  # what calibration leaves open; a part of `sigma`
    unseen: float  # share of the vertices that no sampled frame shows

    @property
    def own(self) -> float:
        """Root mean square of what poses and calibration have no part in [m]."""
        return float(np.hypot.reduce([self.parts.get(name) or 0.0 for name in ("noise", "model", "bends")]))

    def values(self) -> SigmaFigures:
        """In few numbers."""
        known = self.sigma[np.isfinite(self.sigma)]
        low, middle, high = np.percentile(known, [5, 50, 95]).tolist() if len(known) else [float("nan")] * 3
        shared, common = self.shared.values(), self.common.values()
        return SigmaFigures(middle, low, high, self.parts, self.unknown, shared, common, self.unseen)

    def onto(self, mesh: Mesh) -> Mesh:
        """The mesh with the scalar `sigma` [m], and a word on what is not in it."""
        said = (f"sigma: {without_words(self.unknown)}",) if self.unknown else ()
        return replace(mesh, scalars=mesh.scalars | {"sigma": self.sigma}, notes=(*mesh.notes, *said))


@dataclass(frozen=True)
class Causes:
    """What the frames themselves do not tell."""

    frames: int  # how many were fused; those looked at stand for them
    blur_px: float  # standard deviation of what a pixel mixes sideways [px]
    voxel: float  # [m]
    common: Common  # what calibration leaves open
    # standard deviation (m,) [m] along the normals (m, 3) of points (m, 3) of what all poses are wrong by together, and
    # what was looked at; None where nothing tells it
    pose: Callable[[Array, Array, Looks], Array] | None = None


def put_together(mesh: Mesh, some: NDArray[np.intp], looks: Looks, shared: Shared, causes: Causes) -> Sure:
    """Variances added up.

    Args:
        mesh: with normals.
        some: (m,) its vertices that were looked at; the others take what is near.
        shared: what neighbouring views share.
    """
    assert mesh.normals is not None
    points, normals = mesh.vertices[some], mesh.normals[some].astype(float)
    seen = np.asarray(looks.seen.any(axis=1))
    near = _nearby(points, seen)
    noise = _spread(looks, near) * _shrunk(looks, shared, causes.frames)
    mean = np.where(seen, np.einsum("mk,mk->m", looks.share(), looks.off), 0)
    # what all views around say together, less than noise explains: the volume stands beside what was measured
    beside = np.maximum(_around(mean, near) ** 2 - noise / AROUND, 0)
    size = np.hypot(causes.blur_px * looks.pixel, causes.voxel / np.sqrt(12))
    bent = _around(bend(mesh)[some], near)
    blurred = moved_by_blur(bent, size)
    posed = np.zeros(len(some)) if causes.pose is None else causes.pose(points, normals, looks)
    common = causes.common.along(points, normals)
    whole = replace(causes.common, blur=_grown(points[seen], normals[seen], -np.sign(bent[seen]) * blurred[seen]))
    variances = {"noise": noise, "model": beside, "bends": blurred**2, "poses": posed**2, "calibration": common**2}
    total = np.sqrt(np.sum(list(variances.values()), axis=0))
    parts: dict[str, float | None] = {name: _rms(value[seen]) for name, value in variances.items()}
    unknown = causes.common.unknown
    if not causes.common.calibrated:
        parts["calibration"] = None
    if causes.pose is None:
        parts["poses"], unknown = None, (*unknown, "poses")
    sigma = _everywhere(mesh.vertices, points[seen], total[seen])
    return Sure(sigma, parts, unknown, shared, whole, float(np.mean(~seen)) if len(seen) else 1.0)


def _grown(points: Array, normals: Array, shifts: Array) -> float:
    """By how much, relative, shifts (n,) [m] along normals of points (n, 3) change the size, beside a rigid motion."""
    if len(points) < LEAST_PLACES:
        return 0.0
    arm = points - points.mean(axis=0)
    columns = np.column_stack([np.cross(arm, normals), normals, np.sum(arm * normals, axis=1)])
    return abs(float(np.linalg.lstsq(columns, shifts, rcond=None)[0][-1]))


def without_words(unknown: tuple[str, ...]) -> str:
    """ "without what focal length and depth may be wrong by, which nothing tells"."""
    listed = " and ".join(", ".join(unknown).rsplit(", ", 1))
    return f"without what {listed} may be wrong by, which nothing tells"


def _shrunk(looks: Looks, shared: Shared, frames: int) -> Array:
    """(m,) variance of the weighted mean of all frames over that of one; those looked at are a sample of them."""
    each = max(1.0, frames / max(looks.off.shape[1], 1))  # frames that one stands for
    part = looks.share().astype(float)
    near = looks.apart + np.where(np.eye(len(looks.apart), dtype=bool), np.inf, 0)
    step = float(np.median(near.min(axis=1))) / each if len(near) > 1 else 0.0
    alike = np.exp(-looks.apart / shared.reach)
    lags = np.abs(np.subtract.outer(np.arange(int(each)), np.arange(int(each)))) * step
    np.fill_diagonal(alike, float(np.exp(-lags / shared.reach).mean()))
    together = np.einsum("mk,mk->m", part @ alike, part)
    return np.asarray((1 - shared.share) * np.sum(part**2, axis=1) / each + shared.share * together)


def _spread(looks: Looks, near: NDArray[np.intp]) -> Array:
    """(m,) variance [m^2] of a view at a place: as seen between the views of all vertices nearby.

    Where few views tell it, what the sensor's model says counts too, scaled as the whole scan asks for.
    """
    share, off = looks.share().astype(float), looks.off.astype(float)
    mean = np.sum(share * off, axis=1, keepdims=True)
    seen = np.sum(share * (off - mean) ** 2, axis=1)
    modelled = np.sum(share * looks.spread.astype(float) ** 2, axis=1)
    views = 1 / np.maximum(np.sum(share**2, axis=1), 1e-12) * (share.sum(axis=1) > 0)  # Kish 1965: as many alike ones
    free = np.maximum(views - 1, 0)
    # a mean over n views hides a share of 1 / n of the variance
    squares = free * seen / np.maximum(1 - 1 / np.maximum(views, 1 + 1e-9), 1e-9)
    expected = free * modelled
    # a single view of everything tells nothing of itself: then the model is all that is known
    usual = float(squares.sum() / expected.sum()) if expected.sum() > 0 else 1.0
    ratio = (_around(squares, near) + WORTH * usual * _around(modelled, near)) / np.maximum(
        _around(expected, near) + WORTH * _around(modelled, near), 1e-30
    )
    return np.asarray(ratio * _around(modelled, near))


def _nearby(points: Array, seen: NDArray[np.bool_]) -> NDArray[np.intp]:
    """(m, k) the nearest of the points that were seen."""
    known = np.flatnonzero(seen)
    if not len(known):
        return np.arange(len(points))[:, None]
    _, index = cKDTree(points[known]).query(points, k=min(AROUND, len(known)), workers=-1)
    return known[np.asarray(index).reshape(len(points), -1)]


def _around(values: Array, near: NDArray[np.intp]) -> Array:
    return np.asarray(values[near].mean(axis=1))


def _everywhere(vertices: Array, points: Array, sigma: Array) -> NDArray[np.float32]:
    """(n,) of all vertices, from what is nearest; where nobody looked, wider by half the way to there (guess)."""
    if not len(points):
        return np.full(len(vertices), np.nan, np.float32)
    far, index = cKDTree(points).query(vertices, k=min(3, len(points)), workers=-1)
    far, index = (np.asarray(x).reshape(len(vertices), -1) for x in (far, index))
    usual = np.median(far[:, 0][far[:, 0] > 0]) if (far[:, 0] > 0).any() else 0.0
    beyond = np.maximum(far[:, 0] - 4 * usual, 0)
    own = np.where(far[:, 0] == 0, sigma[index[:, 0]], sigma[index].mean(axis=1))
    return np.hypot(own, beyond / 2).astype(np.float32)


def _rms(variance: Array) -> float:
    return float(np.sqrt(variance.mean())) if len(variance) else float("nan")
