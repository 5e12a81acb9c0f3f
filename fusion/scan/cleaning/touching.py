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
FEW = 20  # pixels that were taken out of a frame: noise and edges (guess)
REACH = np.ones((5, 5), np.uint8)  # pixels across which a finger and its hand hang together, and its rim (guess)
WIDE = np.ones((3, 3), np.uint8)  # pixels that are wide: lines alone may be rims of the object
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
    found, had = list(frames), False
    for k, (frame, T) in enumerate(zip(frames, poses, strict=True)):
        if frame is None or not np.isfinite(T).all():
            continue
        hand = _taken_out(frame)
        if hand.sum() <= FEW or not np.isfinite(frame.depth).any():
            continue
        touching = _touching(volume, frame, T, hand) & np.isfinite(frame.depth)
        if touching.any():
            found[k], had = frame.masked(~touching), True
    return found if had else None


def _taken_out(frame: Prepared) -> Mask:
    """(h, w) what a camera measured and the frame shows no more."""
    return np.asarray(np.isfinite(frame.surface.points[..., 2]) & ~np.isfinite(frame.depth))


def _touching(volume: Volume, frame: Prepared, T: Array, hand: Mask) -> Mask:
    """(h, w) patches before the surface that hang together with a hand, their rims included."""
    there = beside(volume, frame, T)
    off = np.nan_to_num(there.off)
    shown = np.isfinite(there.off) & (there.facing > np.cos(STEEPEST))
    before = cv2.morphologyEx((shown & (off < -there.limit)).astype(np.uint8), cv2.MORPH_OPEN, WIDE)
    z = frame.surface.points[..., 2]
    distance = float(np.nanmedian(np.where(np.isfinite(frame.depth), z, np.nan)))
    radius = int(np.ceil(APART * frame.surface.camera.fx / distance))
    around = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * radius + 1, 2 * radius + 1))
    nearest = cv2.erode(np.where(hand, z, np.inf).astype(np.float32), around)
    with np.errstate(invalid="ignore"):
        beside_hand = np.abs(nearest - z) < APART
    labels = cv2.connectedComponents(before)[1]
    far = np.unique(labels[off < -volume.settings.truncation])  # else the object itself, at a place that is not exact
    both = np.intersect1d(far, np.unique(labels[beside_hand]))
    patches = np.isin(labels, both[both > 0])
    whole = cv2.dilate(patches.astype(np.uint8), REACH) > 0
    return whole if patches.sum() < MOST * shown.sum() else np.zeros_like(whole)
