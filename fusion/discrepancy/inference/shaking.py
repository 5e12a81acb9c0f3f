"""Shaking: the camera stood elsewhere in every frame, and all that a frame shows shares the shake.

A rigid motion of six numbers per frame is told from noise that is smooth for other reasons by how much more of it there
is than of smooth fields that no motion makes.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.special import chdtrc, fdtrc

from fusion.discrepancy.decisions import FALSE_ALARM
from fusion.discrepancy.observe.frame_block import FrameBlock
from fusion.discrepancy.observe.frames import SMOOTH_PX
from fusion.geometry.camera import Camera
from fusion.sensor.effect import Effect
from fusion.sensor.effects import EFFECTS
from fusion.sensor.laws.surface import rigid_motions
from fusion.sensor.view import Image, View

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

# whose noise all pixels of an image share, of any size: a camera's motion, of sigma_m and sigma_rad
SHAKES = next(kind for kind in EFFECTS if kind().window(View(Camera(2, 2, 1.0, 1.0, 0.5, 0.5))) > 2)
DEGREE = 3  # of the fields that a motion is compared with
SEEN = 1e-3  # of a column: directions that differ less from the others are rounding
OWN = 0.1  # of a motion: what is left of it beside an offset must be that much, or it is one
FEWEST_TILES = 20
LEAST_SHARE = 0.06  # of the variance of pixels, where it is largest: below, it is a matter of the noise model
MOST_MOVED = 0.9  # quantile of the tiles that stands for the largest
STARTS = (1e-5, 1e-4, 1e-3, 1e-2)  # [m], [rad] from what no camera shows to what any hand does


@dataclass(frozen=True)
class Shaking:
    """How the camera shook."""

    # sigma_rad, sigma_m: standard deviations of a turn and of a shift, about and along each axis
    sigma_rad: float
    sigma_m: float
    # std_rad, std_m: of these
    std_rad: float
    std_m: float
    gain: float  # -2 log of the likelihood ratio of shaking to standing still
    share: float  # of what frames have in common that shaking explains
    probability: float  # that noise which is smooth alone does this

    @property
    def effect(self) -> Effect:
        sizes: dict[str, Any] = {"sigma_m": self.sigma_m, "sigma_rad": self.sigma_rad}
        return SHAKES(**sizes)


@dataclass(frozen=True)
class FrameMotion:
    """What the frames of a block say of shaking."""

    rigid: Matrix  # (frames, r) along independent motions that are seen, in one unit
    per_unit: Matrix  # (r, 6) of these per turn [rad] and shift [m]
    moving: int  # number of these that no offset, scale or disparity of whole frames imitates
    moving_power: float  # mean square along them
    smooth: float  # mean square along smooth fields that no motion makes, and their number
    fields: int
    freedom: int  # frames less one

    @property
    def chance(self) -> float:
        """Probability that noise moves frames as much as this in ways that no offset of whole frames imitates."""
        if not self.moving:
            return 1.0
        ratio = self.moving_power / self.smooth
        return float(fdtrc(self.freedom * self.moving, self.freedom * self.fields, ratio))

    def cost(self, sizes: Vector) -> float:
        """-2 log likelihood of standard deviations (2,) of turns and shifts."""
        whole = self._allowed(sizes)
        _, logarithm = np.linalg.slogdet(whole)
        return float(self.freedom * logarithm + (self.rigid.T * np.linalg.solve(whole, self.rigid.T)).sum())

    def covariance(self, sizes: Vector) -> Matrix:
        """(6, 6) covariance of the motions of the frames, as these sizes and the frames together say."""
        gain = (self.per_unit * np.repeat(sizes, 3) ** 2).T @ np.linalg.inv(self._allowed(sizes))
        motions = self.rigid @ gain.T
        return np.asarray(motions.T @ motions / self.freedom)

    def _allowed(self, sizes: Vector) -> Matrix:
        scaled = self.per_unit * np.repeat(sizes, 3)
        return np.asarray(scaled @ scaled.T + self.smooth * np.eye(len(scaled)))


def shaking_of(blocks: Sequence[FrameBlock]) -> Shaking | None:
    """The shaking that the frames of blocks show together; None where they show none."""
    told_of = [(block, own) for block in blocks if (own := motion_of(block)) is not None]
    seen = [own for _, own in told_of]
    if not seen:
        return None
    told = -2.0 * sum(float(np.log(max(own.chance, 1e-300))) for own in seen)
    probability = float(chdtrc(2 * len(seen), told))
    if probability > FALSE_ALARM:
        return None

    def cost(logarithms: Vector) -> float:
        return sum(own.cost(np.exp(logarithms)) for own in seen)

    begin = min((np.log([a, b]) for a in STARTS for b in STARTS), key=cost)
    best = minimize(cost, begin, method="Nelder-Mead", options={"xatol": 1e-3, "fatol": 1e-3})
    still = sum(own.cost(np.zeros(2)) for own in seen)
    sizes = np.exp(best.x)
    if (
        np.quantile(np.concatenate([_share_of_tiles(block, own, sizes) for block, own in told_of]), MOST_MOVED)
        < LEAST_SHARE
    ):
        return None
    spread = sizes * _spread(cost, best.x)
    chance = sum(own.smooth * own.freedom * own.rigid.shape[1] for own in seen)
    explained = 1.0 - chance / sum(float((own.rigid**2).sum()) for own in seen)
    (rad, m), (std_rad, std_m) = sizes.tolist(), spread.tolist()
    return Shaking(rad, m, std_rad, std_m, still - float(best.fun), max(explained, 0.0), probability)


def steadied(blocks: Sequence[FrameBlock], shaking: Shaking) -> list[FrameBlock]:
    """The blocks as if the camera had stood still: what all pixels of a frame shared is out of their scatter.

    The mean over the frames stays off by the mean of their shakes: `shaken` says how much of it is to be expected.
    """
    return [_steadied(block, shaking) for block in blocks]


def motion_of(block: FrameBlock) -> FrameMotion | None:
    """What the frames of a block say of shaking; None where too little is seen."""
    course, view = block.course, block.view
    if course is None or view.normals is None or view.depth is None or len(course.tiles) < FEWEST_TILES:
        return None
    with np.errstate(all="ignore"):
        noise = np.sqrt(course.tiles.mean(block.std**2))
    known = np.isfinite(noise) & (noise > 0)
    if np.count_nonzero(known) < FEWEST_TILES:
        return None
    weight = np.sqrt(course.pixels) / np.where(known, noise, np.inf)
    images = rigid_motions(view.depth, view)
    columns = np.column_stack([course.tiles.mean(image) for image in images]) * weight[:, None]
    rigid = _directions(_unit(columns), SEEN)
    whole = np.column_stack([course.tiles.mean(image) for image in _offsets(block)]) * weight[:, None]
    whole = _directions(_unit(whole), SEEN)
    moving = _directions(rigid - whole @ (whole.T @ rigid), OWN)
    smooth = _smooth(course.tiles.cell.astype(float)) * weight[:, None]
    others = _directions(_unit(smooth - rigid @ (rigid.T @ smooth)), SEEN)
    seen, freedom = course.depth * weight, len(course.depth) - 1

    def power(directions: Matrix) -> float:
        return float(((seen @ directions) ** 2).sum()) / (freedom * max(directions.shape[1], 1))

    if power(others) <= 0:
        return None
    return FrameMotion(
        seen @ rigid, rigid.T @ columns, moving.shape[1], power(moving), power(others), others.shape[1], freedom
    )


def _directions(columns: Matrix, least: float) -> Matrix:
    """(n, r) orthonormal columns along which columns (n, k) are at least so long."""
    basis, values, _ = np.linalg.svd(columns, full_matrices=False)
    return np.asarray(basis[:, values > least])


def _unit(columns: Matrix) -> Matrix:
    return np.asarray(columns / np.maximum(np.linalg.norm(columns, axis=0), 1e-300))


def _offsets(block: FrameBlock) -> list[Image]:
    """Images (h, w) of what moves a whole frame and is no motion: of depth, of range, by a share, of disparity."""
    depth = block.view.depth
    assert depth is not None
    return [np.ones_like(depth), 1.0 / block.view.stretch, depth, depth**2]


def _smooth(cell: Matrix) -> Matrix:
    """(n, k) all products of powers of row and column up to `DEGREE`."""
    y, x = ((cell - cell.mean(axis=0)) / np.maximum(np.ptp(cell, axis=0), 1.0)).T
    return np.column_stack([x**i * y**j for i in range(DEGREE + 1) for j in range(DEGREE + 1 - i)])


def _steadied(block: FrameBlock, shaking: Shaking) -> FrameBlock:
    motion = motion_of(block)
    held = None if block.held is None else _steadied(block.held, shaking)
    block = replace(block, shaken=(shaking.sigma_rad, shaking.sigma_m), held=held)
    if motion is None:
        return block
    covariance = motion.covariance(np.array([shaking.sigma_rad, shaking.sigma_m]))
    # of squares: a pixel's own scatter over a few frames is less than what is taken from it, now and then
    known, shared = np.isfinite(block.std), _shared(block, covariance)
    whole, taken = (cv2.blur(np.where(known, image, 0.0), (SMOOTH_PX, SMOOTH_PX)) for image in (block.std**2, shared))
    part = np.clip(taken / np.maximum(whole, 1e-300), 0.0, 0.99)
    usual = float(np.median(part[np.isfinite(block.std)])) if np.isfinite(block.std).any() else 0.0
    alike = block.alike
    if alike is not None:  # what all pixels share makes them alike at any distance
        alike = np.maximum(alike - usual, 0.0) / (1.0 - usual)
    # half the mean square of a change from one frame to the next is the variance of what is new in each
    succession = None if block.succession is None else block.succession * (1.0 - part)
    std = block.std * np.sqrt(1.0 - part)
    return replace(block, std=std, succession=succession, alike=alike)


def _share_of_tiles(block: FrameBlock, motion: FrameMotion, sizes: Vector) -> Vector:
    """(n,) share of the variance of the pixels of a tile over the frames that motions of these sizes make."""
    assert block.course is not None
    tiles = block.course.tiles
    whole = tiles.mean(block.std**2)
    return np.asarray(tiles.mean(_shared(block, motion.covariance(sizes))) / np.maximum(whole, 1e-300))[whole > 0]


def _shared(block: FrameBlock, covariance: Matrix) -> Image:
    """(h, w) variance [m^2] of pixels over frames that motions of a covariance (6, 6) make."""
    assert block.view.depth is not None
    images = np.stack(rigid_motions(block.view.depth, block.view))
    with np.errstate(all="ignore"):
        return np.asarray(np.einsum("ihw,ij,jhw->hw", images, covariance, images, optimize=True))


def _spread(cost: Callable[[Vector], float], at: Vector) -> Vector:
    """(2,) standard deviations of logarithms from the curvature of a cost of -2 log likelihood."""
    step, out = 0.05, np.zeros(2)
    for i, unit in enumerate(np.eye(2)):
        bend = (cost(at + step * unit) - 2 * cost(at) + cost(at - step * unit)) / step**2
        out[i] = np.sqrt(2.0 / bend) if bend > 0 else 1.0
    return np.minimum(out, 1.0)
