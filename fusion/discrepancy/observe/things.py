"""Things: what stands so near before its ground that its size does not tell it from an effect; its outline does.

An effect is a law of what is known of a pixel: smooth in it, or with a step where one of its variables has a value. A
thing ends in a step wherever it ends, and where its variables are the same elsewhere nothing is off.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation, binary_opening, label

from fusion.discrepancy import decisions
from fusion.discrepancy.observe.interior import interior, reach
from fusion.geometry.robust import robust_std
from fusion.sensor.view import Image
from fusion.sensor.where import VARIABLES

if TYPE_CHECKING:
    from fusion.discrepancy.observe.patch import Patch

Mask = NDArray[np.bool_]

STEP_PX = 2, 4  # beside a thing, from where on its ground is seen as it is, and how far it is asked for
NEARLY_ALL = 0.8  # of the outline, that is seen and a step (guess): the rest may be where a thing touches its ground
PARTS = np.linspace(0.0, 1.0, 5)  # of the values of a variable: for each of them pixels elsewhere are asked
RIM_PX = 5  # around it: mixed pixels, shadows, and light that it sends to its neighbours


@dataclass(frozen=True)
class _Seen:
    """By how much the pixels of a block are off, as most of them are not."""

    patch: "Patch"

    @cached_property
    def whole(self) -> Image:
        """(h, w) native units by which they are off; NaN where nothing is seen, or an edge beside it."""
        patch = self.patch
        inside = interior(replace(patch.view, reflectance=None))  # a thing may end on any print
        return np.where(inside, (patch.block.mean - patch.predicted) * patch.native, np.nan)

    @cached_property
    def off(self) -> Image:
        """(h, w) native units, beyond what most of them are."""
        seen = np.isfinite(self.whole)
        return self.whole - (np.median(self.whole[seen]) if seen.any() else 0.0)

    @cached_property
    def variables(self) -> dict[str, Image]:
        """Images (h, w) of all that laws are known to depend on, but edges, which nothing here is near to."""
        found = {name: of(self.patch.depth, self.patch.view) for name, of in VARIABLES.items() if name != "edge"}
        return {name: np.broadcast_to(x, self.off.shape) for name, x in found.items() if x is not None}

    def having(self, name: str, low: float, high: float) -> Mask:
        """(h, w) pixels of which a variable has a value between two; none where it is not known."""
        values = self.variables.get(name)
        return np.zeros(self.off.shape, bool) if values is None else (values >= low) & (values <= high)

    def around(self, piece: Mask) -> Mask:
        """(h, w) pixels beside a piece, where its step has ended."""
        near, far = (binary_dilation(piece, iterations=steps) for steps in STEP_PX)
        return np.asarray(far & ~near)

    def pieces(self) -> Iterator[Mask]:
        """What is off in one piece, with a step all around."""
        seen = np.isfinite(self.off)
        if not seen.any():
            return
        # neighbours on two levels of a rounding are one step apart, with an outline as sharp as a thing's
        with np.errstate(invalid="ignore"):
            least = np.abs(self.patch.next_level * self.patch.native)
            beyond = np.abs(self.off) > np.fmax(decisions.FAR * robust_std(self.off[seen]), least)
        every, count = label(binary_opening(beyond, iterations=2))
        for number in range(1, count + 1):
            piece = every == number
            within = piece & binary_dilation(~piece, iterations=STEP_PX[1])
            with np.errstate(invalid="ignore"):
                size = np.abs(self.off) / np.median(np.abs(self.off[piece]))
                ground, edge = size[self.around(piece)] < 1 / 3, size[within] > 2 / 3
            if len(ground) and min(np.mean(ground), np.mean(edge)) > NEARLY_ALL:
                yield piece


def things(patches: Sequence["Patch"]) -> list[Mask]:
    """(h, w) of each block: pixels of things that its mesh does not have, and around them."""
    every = [_Seen(patch) for patch in patches]
    out = [np.zeros(patch.depth.shape, bool) for patch in patches]
    for seen, mask in zip(every, out, strict=True):
        for piece in seen.pieces():
            if not _lawful(seen, piece, every):
                mask |= binary_dilation(piece, iterations=round(reach(RIM_PX, seen.patch.view.camera.width)))
    return out


def _lawful(seen: _Seen, piece: Mask, every: Sequence[_Seen]) -> bool:
    """True where a law of one variable, or of the pixel, may be off there: elsewhere it is off too, or not seen."""
    level = float(np.median(seen.whole[piece])), 0.5 * float(np.median(np.abs(seen.off[piece])))
    others = [(one, piece) for one in every if one.patch.block.place != seen.patch.block.place]
    if not _fine(others, *level):
        return True
    for name, x in seen.variables.items():
        ends = np.nanquantile(x[piece], PARTS)
        for low, high in pairwise(ends):
            if not _fine([(one, one.having(name, low, high) & ~(piece & (one is seen))) for one in every], *level):
                return True
    if seen.patch.view.reflectance is None:
        return False
    # light of neighbours ends where a print does
    ends = np.nanquantile(seen.patch.view.reflectance[piece], PARTS[[0, -1]])
    return bool(2 * np.sum(seen.having("reflectance", *ends) & seen.around(piece)) <= np.sum(seen.around(piece)))


def _fine(where: Sequence[tuple[_Seen, Mask]], level: float, most: float) -> bool:
    """True where more than half of some pixels are less off than `most`, and not at the level of a piece."""
    fine, count = 0, 0
    for one, inside in where:
        inside = inside & np.isfinite(one.off)
        count += int(inside.sum())
        fine += int(np.sum((np.abs(one.off[inside]) < most) & (np.abs(one.whole[inside] - level) > most)))
    return 2 * fine > count
