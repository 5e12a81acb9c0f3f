"""Whether what a camera walked round stayed as it was: frames of each part of the way beside the model that all made.

A thing that bends or is moved, and poses that run apart, leave a model of what most frames saw. The frames of one part
of the way then see something before it, or through it. What was seen once only agrees with itself.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from fusion.results.light import AGAINST, Light, level
from fusion.volume.beside import beside
from fusion.volume.prepared import Prepared
from fusion.volume.volume import Volume

Array = NDArray[np.float64]
FRAMES = 16  # evenly from the way, as for a turntable: more say nothing new
PARTS = 4  # of the way, of which the worst counts: what bends once does so in one of them (guess)
LEAST = 500  # pixels that show the model: fewer say nothing (guess)


@dataclass(frozen=True)
class Changed:
    """Looks at frames as they go by.

    Attributes:
        volume: the model that all frames made.
        poses: (n, 4, 4) `T_world_camera`, NaN where a frame has no place.
        found: of each frame looked at the shares of its pixels that see something before the model, and through it.
    """

    volume: Volume
    poses: Array
    found: dict[int, tuple[float, float]] = field(default_factory=dict)

    def look(self, index: int, frame: Prepared) -> None:
        """Look at a frame, if it is its turn."""
        last = max(self.found, default=None)
        if last is not None and index - last < len(self.poses) / FRAMES:
            return
        seen = beside(self.volume, frame, self.poses[index])
        count = int(seen.shown.sum())
        if count < LEAST:
            return
        # what is nearer than the truncation took part in the model's surface
        limit = np.maximum(seen.limit, self.volume.settings.truncation)
        before, through = (float((seen.shown & (side > limit)).sum() / count) for side in (-seen.off, seen.off))
        self.found[index] = before, through

    def light(self) -> Light | None:
        """What they said; None where fewer frames were looked at than there are parts."""
        if len(self.found) < PARTS:
            return None
        parts = np.array_split(sorted(self.found), PARTS)
        shares = [np.median([self.found[k] for k in part], axis=0) for part in parts]
        worst = int(np.argmax([share.sum() for share in shares]))
        before, through = shares[worst]
        judged = level(float(before + through), AGAINST)
        if judged == "ok":
            return Light("ok", "Agreement", "Frames see the surface where it is, from the first to the last.")
        said = f"Frames {parts[worst][0]} to {parts[worst][-1]} contradict the surface in {before + through:.0%} of "
        said += (
            f"what they show (median): they see something before it ({before:.0%}) or look through it ({through:.0%})."
        )
        do = "What was scanned bent or was moved, or the poses are wrong there: scan what keeps its shape, with "
        do += "nothing else moving, or leave these frames out."
        return Light(judged, "Agreement", said, do)
