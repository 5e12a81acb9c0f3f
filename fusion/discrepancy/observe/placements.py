"""Placements: recordings of one scene from one place are one measurement repeated, however many folders they fill."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.inference.covariance import neighbours
from fusion.discrepancy.observe.frame_block import FrameBlock
from fusion.discrepancy.observe.tiles import usual_side
from fusion.geometry.pose import Array, angle, inverse
from fusion.sensor.view import Image

TURNED, MOVED = 0.1, 0.1  # [rad], [m] guess: another side of a thing, beyond what a pose is off
SAME_POSE = 1e-6  # [m], [rad] rounding of text files
FLOOR_M = 2e-5  # a hundredth of usual noise (guess): where counts never change, rounding does
# chi2 per square up to which recordings differ by the noise of their frames, of mean or median (a few squares that
# something moved do not count in the median): 1 where they do, and what chance adds to so few, in standard deviations
ALIKE, CHANCE = 1.5, 3.0
MEDIAN = 0.4549  # of chi2 with one freedom
FEWEST = 12  # squares that both must show


def joined(blocks: Sequence[FrameBlock]) -> list[FrameBlock]:
    """The same blocks, where those of one placement have one place.

    A camera that was put up again stands a little elsewhere, and what is frozen while it stands is drawn anew; both
    show in the difference of the mean images. Series, whose blocks warm up, are left alone.
    """
    places = sorted({block.place for block in blocks})
    single = {g: own[0] for g in places if len(own := [block for block in blocks if block.place == g]) == 1}
    first: dict[int, int] = {}
    for g in places:
        same = [h for h in places if h < g and first[h] == h and h in single and g in single]
        first[g] = next((h for h in same if _one_placement(single[h], single[g])), g)
    number = {g: k for k, g in enumerate(sorted(set(first.values())))}
    if len(number) == len(places):
        return list(blocks)
    shapes = {block.place: block.stage.shape for block in blocks}
    return [_at(block, number[first[block.place]], shapes[first[block.place]]) for block in blocks]


def repeats_of(blocks: Sequence[FrameBlock]) -> list[list[str]]:
    """Names of the recordings of each placement that was recorded more than once."""
    names: dict[int, dict[str, None]] = {}
    for block in blocks:
        names.setdefault(block.place, {})[block.stage.recording.path.name] = None
    return [list(own) for own in names.values() if len(own) > 1]


def _at(block: FrameBlock, place: int, shape: str) -> FrameBlock:
    held = block.held and replace(block.held, stage=replace(block.held.stage, place=place, shape=shape))
    return replace(block, stage=replace(block.stage, place=place, shape=shape), held=held)


def _one_placement(one: FrameBlock, other: FrameBlock) -> bool:
    """True when two blocks differ by the noise of their frames alone."""
    if one.mean.shape != other.mean.shape or not np.allclose(one.T_world_camera, other.T_world_camera, atol=SAME_POSE):
        return False
    apart = one.mean - other.mean
    noise = _variance(one) + _variance(other)
    seen = np.isfinite(apart) & np.isfinite(noise)
    count, squares, variance = (_squares(np.where(seen, image, 0.0)) for image in (np.ones(seen.shape), apart, noise))
    full = count > usual_side(one.mean.shape) ** 2 / 2
    if np.count_nonzero(full) < FEWEST:
        return False
    chi2 = (squares[full] / count[full]) ** 2 / (variance[full] / count[full] ** 2 + FLOOR_M**2)
    most = max(ALIKE, 1 + CHANCE * np.sqrt(2 / len(chi2)))
    return bool(min(np.median(chi2) / MEDIAN, np.mean(chi2)) < most)


def _variance(block: FrameBlock) -> Image:
    """(h, w) [m^2] of the mean over frames; pixels that never changed as their neighbours do."""
    known = block.std[np.isfinite(block.std)]
    usual = float(np.mean(known**2)) if len(known) else 0.0
    with np.errstate(all="ignore"):
        shared = 1.0 if block.alike is None else neighbours(block.alike, usual_side(block.mean.shape))
        return np.asarray(shared * np.where(block.std > 0, block.std**2, usual) / np.maximum(block.count, 1))


def _squares(image: NDArray[np.float64]) -> NDArray[np.float64]:
    """(k,) sums over squares of the image."""
    side = usual_side(image.shape)
    h, w = (size // side * side for size in image.shape)
    return np.asarray(image[:h, :w].reshape(h // side, side, -1, side).sum(axis=(1, 3)).ravel())


def views_of(poses: Sequence[Array]) -> list[int]:
    """Number of the view of each pose T_world_camera (4, 4); near ones share the number of the first."""
    firsts: list[Array] = []
    numbers = []
    for pose in poses:
        number = next((k for k, first in enumerate(firsts) if _near(first, pose)), len(firsts))
        if number == len(firsts):
            firsts.append(pose)
        numbers.append(number)
    return numbers


def _near(one: Array, other: Array) -> bool:
    between = inverse(one) @ other
    return bool(angle(between) < TURNED and np.linalg.norm(between[:3, 3]) < MOVED)
