"""What the angles say about the table: its direction, even and uneven steps, slips, the closing gap."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Slip:
    """A jump that the table's log does not show.

    Attributes:
        frame: the first frame after it.
        angle: turn beyond what was expected [rad], right-handed about the axis.
    """

    frame: int
    angle: float


@dataclass(frozen=True)
class Steps:
    """The table's behaviour.

    Attributes:
        direction: 1 right-handed about the axis, -1 left-handed.
        mean, std: of the turn between neighbouring frames, slips left out [rad].
        slips: jumps.
        warnings: sentences for a person.
    """

    direction: int
    mean: float
    std: float
    slips: tuple[Slip, ...]
    warnings: tuple[str, ...]


def judge_steps(angles: Array, angle_std: Array, commanded: Array | None = None) -> Steps:
    """Compare the measured angles with what the table was told, or with even steps.

    A slip is a step that differs from what was expected by more than six robust standard deviations of all steps,
    and by more than 1 degree (smaller ones cannot be told from uneven steps).

    Args:
        angles: (n,) measured [rad], NaN where rejected.
        angle_std: (n,) [rad].
        commanded: (n,) what the table was told [rad], of either sign; None: even steps are expected.
    """
    known = np.flatnonzero(np.isfinite(angles))
    gaps = np.diff(known)
    measured = np.diff(angles[known])
    direction = 1 if np.sum(measured) >= 0 else -1
    warnings = []
    if commanded is None:
        expected = np.multiply(float(np.median(measured / gaps)), gaps)
    else:
        told = np.diff(commanded[known])
        sign = float(np.sign(np.sum(told * measured))) or 1.0
        expected = sign * told
        if sign < 0:
            warnings.append("the table turns against the sign of its log (right-handed about the upward axis)")
    excess = measured - expected
    excess = excess - np.median(excess)
    spread = 1.4826 * float(np.median(np.abs(excess)))
    limit = max(6 * spread, np.deg2rad(1.0))
    slips = tuple(Slip(int(known[k + 1]), float(excess[k])) for k in np.flatnonzero(np.abs(excess) > limit).tolist())
    regular = np.abs(excess) <= limit
    per_frame = measured[regular] / gaps[regular]
    std = float(per_frame.std()) if len(per_frame) else 0.0
    noise = float(np.sqrt(2) * np.nanmedian(angle_std))
    if std > max(3 * noise, 0.05 * abs(float(np.median(measured)))):
        warnings.append(f"uneven steps: {np.rad2deg(std):.2f} deg around {np.rad2deg(per_frame.mean()):.2f} deg")
    warnings += [f"slip of {np.rad2deg(s.angle):+.2f} deg before frame {s.frame}" for s in slips]
    wrong_way = (np.sign(measured) != direction) & (np.abs(measured) > 3 * noise + 1e-3)
    if wrong_way.any():
        warnings.append(f"the table turns back before frames {known[1:][wrong_way][:5].tolist()}")
    return Steps(direction, float(per_frame.mean()) if len(per_frame) else 0.0, std, slips, tuple(warnings))


def closing_pair(angles: Array) -> tuple[int, int] | None:
    """Two frames (i, j) about a full turn apart, the nearest views of the two ends; None without such a pair."""
    known = np.flatnonzero(np.isfinite(angles))
    i, j = np.triu_indices(len(known), 1)
    i, j = known[i], known[j]
    turn = np.abs(angles[j] - angles[i])
    rest = np.abs((turn + np.pi) % (2 * np.pi) - np.pi)
    fit = (turn > np.pi) & (rest < np.deg2rad(50))
    if not fit.any():
        return None
    best = int(np.argmin(np.where(fit, rest - 1e-3 * (j - i), np.inf)))
    return int(i[best]), int(j[best])
