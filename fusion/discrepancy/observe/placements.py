"""Placements: recordings of one scene from one place are one measurement repeated, however many folders they fill."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.inference.covariance import neighbours
from fusion.discrepancy.observe.look import FrameBlock
from fusion.sensor.view import Image

SAME_POSE = 1e-6  # [m], [rad] rounding of text files
SIDE_PX = 16  # of the squares whose means are compared
FLOOR_M = 2e-5  # a hundredth of usual noise (guess): where counts never change, rounding does
ALIKE = 1.5  # chi2 per square up to which recordings differ by the noise of their frames: 1 +- 0.2 where they do
MEDIAN = 0.4549  # of chi2 with one freedom: a few squares that something moved do not count
FEWEST = 12  # squares that both must show


def joined(looks: Sequence[FrameBlock]) -> list[FrameBlock]:
    """The same looks, where those of one placement have one place.

    A camera that was put up again stands a little elsewhere, and what is frozen while it stands is drawn anew; both
    show in the difference of the mean images. Series, whose looks warm up, are left alone.
    """
    places = sorted({look.place for look in looks})
    single = {g: own[0] for g in places if len(own := [look for look in looks if look.place == g]) == 1}
    first: dict[int, int] = {}
    for g in places:
        same = [h for h in places if h < g and first[h] == h and h in single and g in single]
        first[g] = next((h for h in same if _one_placement(single[h], single[g])), g)
    number = {g: k for k, g in enumerate(sorted(set(first.values())))}
    if len(number) == len(places):
        return list(looks)
    shapes = {look.place: look.stage.shape for look in looks}
    return [_at(look, number[first[look.place]], shapes[first[look.place]]) for look in looks]


def repeats_of(looks: Sequence[FrameBlock]) -> list[list[str]]:
    """Names of the recordings of each placement that was recorded more than once."""
    names: dict[int, dict[str, None]] = {}
    for look in looks:
        names.setdefault(look.place, {})[look.stage.recording.path.name] = None
    return [list(own) for own in names.values() if len(own) > 1]


def _at(look: FrameBlock, place: int, shape: str) -> FrameBlock:
    held = look.held and replace(look.held, stage=replace(look.held.stage, place=place, shape=shape))
    return replace(look, stage=replace(look.stage, place=place, shape=shape), held=held)


def _one_placement(one: FrameBlock, other: FrameBlock) -> bool:
    """True when two looks differ by the noise of their frames alone."""
    if one.mean.shape != other.mean.shape or not np.allclose(one.T_world_camera, other.T_world_camera, atol=SAME_POSE):
        return False
    apart = one.mean - other.mean
    noise = _variance(one) + _variance(other)
    seen = np.isfinite(apart) & np.isfinite(noise)
    count, squares, variance = (_squares(np.where(seen, image, 0.0)) for image in (np.ones(seen.shape), apart, noise))
    full = count > SIDE_PX**2 / 2
    if np.count_nonzero(full) < FEWEST:
        return False
    chi2 = (squares[full] / count[full]) ** 2 / (variance[full] / count[full] ** 2 + FLOOR_M**2)
    return bool(np.median(chi2) < ALIKE * MEDIAN)


def _variance(look: FrameBlock) -> Image:
    """(h, w) [m^2] of the mean over frames; pixels that never changed as their neighbours do."""
    known = look.std[np.isfinite(look.std)]
    usual = float(np.mean(known**2)) if len(known) else 0.0
    with np.errstate(all="ignore"):
        shared = 1.0 if look.alike is None else neighbours(look.alike, SIDE_PX)
        return np.asarray(shared * np.where(look.std > 0, look.std**2, usual) / np.maximum(look.count, 1))


def _squares(image: NDArray[np.float64]) -> NDArray[np.float64]:
    """(k,) sums over squares of the image."""
    h, w = (size // SIDE_PX * SIDE_PX for size in image.shape)
    return np.asarray(image[:h, :w].reshape(h // SIDE_PX, SIDE_PX, -1, SIDE_PX).sum(axis=(1, 3)).ravel())
