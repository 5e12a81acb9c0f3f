"""Sizes: how much a claim changes of what one sees: millimetres of depth, of its noise, or the share of lost values."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.channels.channel_step import ChannelStep
from fusion.discrepancy.compared import depth_per_native
from fusion.discrepancy.explain import Explanation
from fusion.discrepancy.observe.patch import Patch
from fusion.discrepancy.verdict.claim import Size
from fusion.sensor.sensor import Sensor

Vector = NDArray[np.float64]

MOST = 95.0  # percentile of the tiles that stands for the most: the very most is one tile's noise
ACTS = 1e-6  # [m] by which a tile must change to count as one where an effect acts


def size_in_depth(found: Explanation, native: Vector) -> Size:
    """Root mean square and largest change of the depth [m] by a law (n,) in native units, where it acts."""
    return _of(np.abs(native * depth_per_native(found.before)))


def size_of_step(found: Explanation, step: ChannelStep) -> Size:
    """What a finding beside the mean changes; nothing of the light alone, or where no effect stands for it."""
    if (step.effect is None and step.added is None) or step.channel == "amplitude":
        return Size()
    patches, given = found.before.patches, found.before.sensor
    better = step.added_to(given)
    if step.channel == "noise":
        if not step.std:  # of another form than any effect has: nothing stands for it
            return Size()
        before, after = (_noise(patches, sensor) for sensor in (given, better))
        return Size(noise_before_m=before, noise_after_m=after)
    if step.channel == "dropout":
        lost, more = (_missing(patches, sensor) for sensor in (given, better))
        return Size(missing_before=lost, missing_after=more)
    if step.channel == "edges":
        seen = [[p.under(sensor).predicted for sensor in (given, better)] for p in patches]
        return _of(np.concatenate([np.abs(after - before)[np.isfinite(after - before)] for before, after in seen]))
    effect = step.effect
    assert effect is not None
    # what the recordings told before any law: its law; but what errs by a spread and repeats, as rounding does
    told = given.effect(effect.name) is effect and not effect.lattice
    law = effect.bias if told else effect.noise
    with np.errstate(all="ignore"):
        parts = [p.tiles.mean(np.broadcast_to(law(p.depth, p.view), p.depth.shape)) for p in patches]
    return _of(np.abs(np.concatenate(parts)))


def _of(metres: Vector) -> Size:
    acting = metres[metres > ACTS]
    if not acting.size:
        return Size(rms_m=0.0, peak_m=0.0)
    rms, most = float(np.sqrt(np.mean(acting**2))), float(np.percentile(acting, MOST))
    # fewer than one in twenty may be all of it
    return Size(rms_m=rms, peak_m=most if most >= rms else float(acting.max()))


def _noise(patches: Sequence[Patch], sensor: Sensor) -> float:
    """Root mean square [m] over the tiles of the spread of repeated frames."""
    with np.errstate(all="ignore"):
        parts = [p.tiles.mean(np.square(sensor.repeated(p.depth, p.block.view)[1])) for p in patches]
    every = np.concatenate(parts)
    return float(np.sqrt(np.mean(every[np.isfinite(every)])))


def _missing(patches: Sequence[Patch], sensor: Sensor) -> float:
    """Mean share of missing values where a surface is seen, in the light of the projector that the model has."""
    views = [replace(p.block.view, lit=None) for p in patches]
    seen = [sensor.dropout(p.depth, view)[np.isfinite(p.depth)] for p, view in zip(patches, views, strict=True)]
    return float(np.mean(np.concatenate(seen)))
