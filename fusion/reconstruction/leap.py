"""A step of the camera that is many times those around it: tracking leapt, as a hand does not."""

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.trajectory import Trajectory
from fusion.results.light import Light

AROUND = 3  # steps on either side that a step is held against
TIMES = 5.0  # the largest of these (guess): a hand that gathers speed needs several frames for it
RECORD = "Look at the frames there; record again with relief or print in view, or pass --poses."


def leap_of(trajectory: Trajectory, band: float, tracked: NDArray[np.bool_]) -> Light | None:
    """The largest leap as a problem; None where no step leaps.

    Args:
        trajectory: as tracked, (n) poses, NaN where a frame has no place; over such gaps nothing is judged.
        band: shorter steps [m] are no leap, whatever those around them are: what is fused hides them.
        tracked: (n,) frames that were tracked from the one before; others were found by what they show, wherever it is.
    """
    steps = np.linalg.norm(np.diff(trajectory.centres, axis=0), axis=1)
    pace = np.diff(trajectory.timestamps)
    usual = float(np.median(pace)) if len(pace) else 0.0
    # the camera may go far while no picture is taken
    steps[pace > 1.5 * usual] = np.nan
    found = [k for k, step in enumerate(steps) if tracked[k + 1] and step > band and step > TIMES * _around(steps, k)]
    if not found:
        return None
    most = max(found, key=lambda k: steps[k])
    others = f" ({len(found)} such steps in all)" if len(found) > 1 else ""
    said = f"The camera leaps by {steps[most] * 1e3:.0f} mm from frame {most} to frame {most + 1}{others}"
    said += f"; the steps around it are at most {_around(steps, most) * 1e3:.0f} mm: one side stands in a wrong place"
    return Light("bad", "Steps", f"{said}.", RECORD)


def _around(steps: np.ndarray, k: int) -> float:
    """The largest of the steps (n,) [m] beside step k; infinite unless steps of both sides are known."""
    before, after = steps[max(k - AROUND, 0) : k], steps[k + 1 : k + 1 + AROUND]
    if not np.isfinite(before).any() or not np.isfinite(after).any():
        return float("inf")
    return float(max(np.nanmax(before), np.nanmax(after)))
