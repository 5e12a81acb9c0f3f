"""What scans get wrong together, apart from what they differ by."""

from dataclasses import dataclass

import numpy as np

from fusion.repeatability.repeat import Repeat


@dataclass(frozen=True)
class Apart:
    """The error of a scan in two parts, root mean squares over the surface [m]."""

    bias: float  # of the mean of all scans against the reference, less what is left of the spread in it
    spread: float  # repeatability standard deviation
    scans: int  # how many

    @property
    def single(self) -> float:
        """What one scan is off by: both together [m]."""
        return float(np.hypot(self.bias, self.spread))

    def values(self) -> dict[str, float]:
        """For JSON."""
        return {"bias_rms_m": self.bias, "spread_m": self.spread, "one_scan_rms_m": self.single, "scans": self.scans}

    def words(self) -> str:
        """ "0.31 mm rms all scans alike, 0.12 mm from scan to scan (5 scans)"."""
        bias, spread = f"{1e3 * self.bias:.3f}", f"{1e3 * self.spread:.3f}"
        return f"{bias} mm rms all scans alike, {spread} mm from scan to scan ({self.scans} scans)"


def bias_and_spread(rms: float, repeated: Repeat) -> Apart:
    """Of the distances of the mean surface to the reference, rms [m]; the mean of n scans has 1/n of their variance."""
    count, spread = len(repeated.names), repeated.repeatability.s
    return Apart(float(np.sqrt(max(rms**2 - spread**2 / count, 0.0))), spread, count)
