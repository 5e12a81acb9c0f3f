"""Outliers: what is in a recording and not in its mesh, such as a thing before the wall; it takes no part."""

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation, binary_opening, binary_propagation

from fusion.discrepancy import decisions
from fusion.discrepancy.observe.interior import reach
from fusion.discrepancy.observe.things import RIM_PX, things
from fusion.geometry.robust import MAD_TO_STD, robust_std
from fusion.sensor.view import Image

if TYPE_CHECKING:
    from fusion.discrepancy.observe.observations import Observations

FAR = 0.05  # of the depth beside the rest of the image: effects at their usual size stay below it (guess)
AWAY = 0.75  # of the frames may show what passes: the scene is what is farther, and seen in the others


@dataclass(frozen=True)
class OutlyingRecording:
    """A recording with something that is not in its mesh, or without depth, and what is seen of that in a sentence."""

    recording: str
    text: str
    empty: bool = False  # no pixel of it has a depth


def foreign(
    measured: Image, predicted: Image, depth: Image | None = None, least: Image | float = 0.0
) -> NDArray[np.bool_]:
    """(h, w) pixels that see something else than the prediction: far from it in one piece, beside an image that agrees.

    Args:
        measured, predicted: (h, w) depth [m], NaN where there is none.
        depth: (h, w) [m] of what stands there, where it is not what is predicted: a range that wraps is short.
        least: (h, w) [m] by which pixels must be off: what a rounding does to them.
    """
    off = measured - predicted
    seen = np.isfinite(off)
    if not seen.any():
        return seen
    away = np.abs(off - np.median(off[seen]))
    # as most of the image is off: where more than half of it is not as predicted, nothing stands out
    beyond = seen & (away > np.fmax(decisions.FAR * robust_std(off[seen]), least))
    with np.errstate(invalid="ignore"):
        pieces = binary_opening(beyond & (away > FAR * (predicted if depth is None else depth)), iterations=2)
    if not pieces.any():
        return pieces
    # a floor meets its wall, and a thing its ground: it is one piece down to where it can no more be told from them
    return np.asarray(binary_dilation(binary_propagation(pieces, mask=beyond), iterations=_rim(pieces)))


def _rim(pieces: NDArray[np.bool_]) -> int:
    return round(reach(RIM_PX, pieces.shape[1]))


@dataclass(frozen=True, eq=False)
class Stays:
    """What stays where it is in frames (n, h, w) [m], in some of which something passes before it.

    Attributes:
        step: (h, w) [m], from a depth (h, w) [m], that rounding does not make of one and the same.
    """

    frames: NDArray[np.floating]
    step: Callable[[Image], Image | float] = lambda depth: 0.0

    @cached_property
    def depth(self) -> Image:
        """(h, w) [m], NaN where unknown."""
        known = np.isfinite(self.frames)
        order = np.sort(np.where(known, self.frames, np.inf), axis=0)
        place = np.minimum(np.ceil(AWAY * known.sum(axis=0)), known.sum(axis=0) - 1).astype(int)
        return np.where(known.any(axis=0), np.take_along_axis(order, np.maximum(place, 0)[None], axis=0)[0], np.nan)

    @cached_property
    def noise(self) -> Image:
        """(h, w) standard deviation [m] of single frames: by noise neighbours differ, in a thing not; 0: unknown."""
        sides = [(axis, step) for axis in (1, 2) for step in (1, -1)]
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)  # pixels without any depth
            change = self.frames - np.nanmedian(self.frames, axis=0)
            beside = np.concatenate([np.abs(change - np.roll(change, step, axis)) for axis, step in sides])
            return np.nan_to_num(MAD_TO_STD / np.sqrt(2) * np.nanmedian(beside, axis=0))

    def hidden(self, frame: Image) -> NDArray[np.bool_]:
        """(h, w) pixels of a frame [m] before which something passes: nearer in one piece, beyond noise."""
        with np.errstate(invalid="ignore"):
            nearer = self.depth - frame
            pieces = nearer > np.fmax(FAR * self.depth, self.step(self.depth))
            pieces = binary_opening(pieces, iterations=2) if pieces.any() else pieces
            if pieces.any():  # its noise takes far longer to find, and single pixels are far off everywhere
                pieces = binary_opening(pieces & (nearer > decisions.FAR * self.noise), iterations=2)
        return np.asarray(binary_dilation(pieces, iterations=_rim(pieces)) if pieces.any() else pieces)


def outliers_of(observations: "Observations") -> list[OutlyingRecording]:
    """Recordings with something that is not in their mesh, and those in which nothing was measured."""
    out: dict[str, str] = {}
    measured = {patch.block.place for patch in observations.patches if patch.block.count.any()}
    empty = {p.block.stage.recording.path.name for p in observations.patches if p.block.place not in measured}
    for patch, near in zip(observations.patches, things(observations.patches), strict=True):
        name = patch.block.stage.recording.path.name
        if patch.block.passed:
            out[name] = f"somebody or something passes in {patch.block.passed} of its frames; left out of them"
        where = foreign(patch.block.mean, patch.predicted, patch.depth, patch.next_level)
        where = where if where.any() else near
        if where.any():
            off = np.nanmedian((patch.block.mean - patch.predicted)[where])
            share, side = np.mean(where), "before" if off < 0 else "behind"
            v, u = (int(np.median(at)) for at in np.nonzero(where))
            text = f"something that the mesh does not have stands {abs(off):.2g} m {side} the scene in {share:.1%} of "
            text += f"the image, about pixel ({u}, {v}); left out"
            out.setdefault(name, text)
    out |= dict.fromkeys(sorted(empty), "no pixel has a depth in any frame; nothing of it is compared")
    return [OutlyingRecording(name, text, name in empty) for name, text in out.items()]
