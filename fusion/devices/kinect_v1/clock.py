"""The device's clock: 32 bits of some 60 MHz, which begin anew every 72 s, and frames that it says are missing."""

from collections import deque

import numpy as np

TICKS = 60e6  # a second; widely reported, the maker says nothing
RATE = 30.0  # frames a second
ROUND = 1 << 32
KNOWN = 3  # steps between frames whose middle is taken for the usual one
SHOWN = 15  # of the latest steps


class DeviceClock:
    """Turns ticks into seconds without jumps, and gaps into a number of frames."""

    def __init__(self) -> None:
        self._last: tuple[int, float] | None = None
        self._steps: deque[int] = deque(maxlen=SHOWN)
        self._anew = False
        self.seconds = 0.0

    def restart(self) -> None:
        """The next frame comes from a device that began anew: its clock says nothing of the time between."""
        self._anew = True

    def at(self, ticks: int, host: float) -> tuple[float, int]:
        """The device's time [s] of a frame that came at `host` [s], and how many frames are missing before it."""
        before, self._last = self._last, (ticks, host)
        if before is None:
            self.seconds = ticks / TICKS
            return self.seconds, 0
        if self._anew:
            self._anew = False
            gap = max(0.0, host - before[1])
            self.seconds += gap
            return self.seconds, max(0, round(gap * RATE) - 1)
        step = (ticks - before[0]) % ROUND
        self.seconds += step / TICKS
        usual = float(np.median(self._steps)) if len(self._steps) >= KNOWN else 0.0
        missing = max(0, round(step / usual) - 1) if usual > 0 else 0
        if not missing:
            self._steps.append(step)
        return self.seconds, missing
