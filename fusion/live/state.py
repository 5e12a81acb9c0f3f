"""What is known of a live scan at one moment: small, frozen, and handed over whole; the newest one wins."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

SECTORS = 36  # of the ring of seen angles, 10 degrees each


@dataclass(frozen=True)
class ShownSurface:
    """Points of the surface so far."""

    points: NDArray[np.float32]  # (n, 3) float32 in the first camera's frame [m]
    sigma: NDArray[np.float32]  # (n,) float32 standard deviation by the noise of the pixels alone [m]


@dataclass(frozen=True)
class LiveState:
    """One moment."""

    phase: str = "looking"  # "looking" for what turns, "scanning", "paused", or "finishing"
    recorded: int = 0  # frames in the recording; lost: on the wire
    lost: int = 0
    # tracked, untracked: frames placed, and frames that could not be; dropped: frames too late for the view
    tracked: int = 0
    untracked: int = 0
    dropped: int = 0
    rate: float = 0.0  # frames placed a second
    behind: float = 0.0  # [s] between a frame's arrival and its place in the view, median of the last ones
    # "good", "weak" or "lost"; reason: why it is not good, in a sentence; back_to: table angle [deg] to turn back to,
    # or None
    tracking: str = "lost"
    reason: str = "nothing turns yet"
    back_to: float | None = None
    turned: float = 0.0  # [deg] since the first frame
    seen: tuple[bool, ...] = (False,) * SECTORS  # for each sector of the turn, whether it was seen
    distance: float = float("nan")  # of the object [m], NaN while unknown; band: "too near", "good" or "too far"
    band: str = ""
    exposure: str = ""  # of the colours, in a word or two
    warm: float = 0.0  # how long the source runs [s]
    memory: int = 0  # of this process [bytes]; left: [s] until the source ends or the disk is full, or None
    left: float | None = None
    surface: ShownSurface | None = field(default=None, repr=False)  # or None before there is one
    # color, depth: small pictures (h, w, 3) uint8, or None
    color: NDArray[np.uint8] | None = field(default=None, repr=False)
    depth: NDArray[np.uint8] | None = field(default=None, repr=False)

    def line(self) -> str:
        """For a terminal."""
        angle = f"{abs(self.turned):.0f} deg turned, {sum(self.seen) * 360 // SECTORS} seen"
        why = f": {self.reason}" if self.reason else ""
        lost = f", {self.lost} lost" if self.lost else ""
        kept = f"{self.recorded} recorded{lost}, {self.tracked} in the view, {self.dropped} too late for it"
        return f"{self.phase}, tracking {self.tracking}{why}; {angle}; {kept}; {self.rate:.0f} a second"
