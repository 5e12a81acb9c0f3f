"""What of a hand that touches the object is left: patches of a frame that stand before the surface of all.

A hand is taken out where more frames look through it than show it (finding/passing.py). A fingertip on the object is
shown by as many, where the hand goes with it, and few frames look along its sides. The surface that all frames made is
not there: as such a frame sees it, the finger stands before it, and hangs together with what was taken out.
"""

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.geometry.pose import Array
from fusion.turntable.turning.visitors import APART
from fusion.volume.beside import STEEPEST, beside
from fusion.volume.prepared import Prepared, fused
from fusion.volume.settings import VolumeSettings
from fusion.volume.volume import Volume

Mask = NDArray[np.bool_]
HANDS = 3  # times that hands are looked for: without one finger the surface tells of another behind it (guess)
FIRST = 8  # frames of the largest hands: where none of them has more of it, none has (guess)
REACH = np.ones((5, 5), np.uint8)  # pixels across which a finger and its hand hang together, and its rim (guess)
# [m] and [px] as wide is a patch at least: half a finger; rims of the object are narrower, where its place is not exact
FINGER, LEAST = 0.005, 3
MOST = 0.25  # of what a frame shows of the object: more than that is no hand, but a frame at a wrong place (guess)


def fused_untouched(settings: VolumeSettings, frames: Sequence[Prepared | None], poses: Array) -> Volume:
    """A volume of all frames, without what of a hand is left on the object in them.

    Args:
        settings: of the volume.
        frames: n of them, of which what passes was taken out.
        poses: (n, 4, 4) `T_object_camera`, NaN where a frame has none.
    """
    volume = fused(settings, frames, poses)
    for _ in range(HANDS):
        left = without_touching(volume, frames, poses)
        if left is None:
            break
        frames, volume = left, fused(settings, left, poses)
    return volume


def without_touching(volume: Volume, frames: Sequence[Prepared | None], poses: Array) -> list[Prepared | None] | None:
    """The frames that a volume was made of without what stands before its surface beside a hand; None: nothing does."""
    hands = {k: f.passing.sum() for k, f in enumerate(frames) if f is not None and f.passing is not None}
    largest = sorted(hands, key=lambda k: -hands[k])
    found, had = list(frames), False
    for count, k in enumerate([*largest, *(k for k in range(len(frames)) if k not in hands)]):
        frame = frames[k]
        if frame is None or not np.isfinite(poses[k]).all() or not np.isfinite(frame.depth).any():
            continue
        if not had and count >= min(FIRST, len(largest)):
            break
        touching = _touching(volume, frame, poses[k]) & np.isfinite(frame.depth)
        if touching.any():
            found[k], had = frame.masked(~touching), True
    return found if had else None


def _touching(volume: Volume, frame: Prepared, T: Array) -> Mask:
    """(h, w) patches before the surface that hang together with what was taken out, their rims included."""
    there = beside(volume, frame, T)
    off = np.nan_to_num(there.off)
    shown = np.isfinite(there.off) & (there.facing > np.cos(STEEPEST))
    wide = np.ones((max(LEAST, int(FINGER * _pixels_per_metre(frame))),) * 2, np.uint8)
    before = cv2.morphologyEx((shown & (off < -there.limit)).astype(np.uint8), cv2.MORPH_OPEN, wide)
    labels = cv2.connectedComponents(before)[1]
    far = np.unique(labels[off < -volume.settings.truncation])  # else the object itself, at a place that is not exact
    both = np.intersect1d(far, np.unique(labels[_near_what_was_taken_out(frame)]))
    patches = np.isin(labels, both[both > 0])
    whole = cv2.dilate(patches.astype(np.uint8), REACH) > 0
    return whole if patches.sum() < MOST * shown.sum() else np.zeros_like(whole)


def _near_what_was_taken_out(frame: Prepared) -> Mask:
    """(h, w) pixels that lie within a hand's width of some that the frame shows no more."""
    z, shown = frame.surface.points[..., 2], np.isfinite(frame.depth)
    radius = int(np.ceil(APART * _pixels_per_metre(frame)))
    around = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * radius + 1, 2 * radius + 1))
    out = np.isfinite(z) & ~shown
    nearest = cv2.erode(np.where(out, z, np.inf).astype(np.float32), around)
    with np.errstate(invalid="ignore"):
        return np.asarray(np.abs(nearest - z) < APART)


def _pixels_per_metre(frame: Prepared) -> float:
    """At the distance of what a frame shows."""
    shown = np.isfinite(frame.depth)
    return float(frame.surface.camera.fx / np.median(frame.surface.points[..., 2][shown]))
