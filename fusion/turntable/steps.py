"""What the angles say about the table: its direction, even and uneven steps, slips, the closing gap."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.robust import robust_std

Array = NDArray[np.float64]
LEAST_SLIP = np.deg2rad(1.0)  # less cannot be told from uneven steps
SURE = 4.0  # standard deviations of the step's own noise: some frames are known worse than others
COUNTS = 4  # steps that the fit's own figure counts for, beside the spread of the steps seen (guess)
UNUSUAL = 6.0  # robust standard deviations of all steps: how evenly this table turns
RESTS = 0.1  # of a large step: less is none
OFTEN = 0.2  # share of the steps that are none from which the frames are doubled, or the table rested (guess)
BESIDE = 3  # frames on either side that must agree that the object stayed turned


@dataclass(frozen=True)
class Slip:
    """A jump that the table's log does not show."""

    frame: int  # the first frame after it
    angle: float  # turn beyond what was expected [rad], right-handed about the axis


@dataclass(frozen=True)
class Steps:
    """The table's behaviour."""

    direction: int  # 1 right-handed about the axis, -1 left-handed
    # mean, std: of the turn between neighbouring frames, slips and rests left out [rad]
    mean: float
    std: float
    slips: tuple[Slip, ...]  # jumps
    warnings: tuple[str, ...]  # sentences for a person, of what a table should not do
    notes: tuple[str, ...] = ()  # of what is only good to know
    # frames that show the object turned as the one before, where there are many: they are there twice, or the table
    # rested
    rests: int = 0


def judge_steps(angles: Array, angle_std: Array, commanded: Array | None = None) -> Steps:
    """Compare the measured angles with what the table was told, or with even steps.

    A slip is a step that differs from what was expected by more than 1 degree (smaller ones cannot be told from uneven
    steps), six robust standard deviations of all steps, and four of the step's own; and the object stays turned by it:
    a single frame whose angle is wrong makes two opposite steps and no slip.

    Args:
        angles: (n,) measured [rad], NaN where rejected.
        angle_std: (n,) [rad].
        commanded: (n,) what the table was told [rad], of either sign; None: even steps are expected.
    """
    known = np.flatnonzero(np.isfinite(angles))
    gaps = np.diff(known)
    measured = np.diff(angles[known])
    direction = 1 if np.sum(measured) >= 0 else -1
    warnings, notes = [], []
    rests = _rests(measured)
    if commanded is None:
        expected = np.where(rests, 0.0, np.multiply(float(np.median((measured / gaps)[~rests])), gaps))
    else:
        told = np.diff(commanded[known])
        sign = float(np.sign(np.sum(told * measured))) or 1.0
        expected = sign * told
        if sign < 0:
            notes.append("the table turns against the sign of its log (right-handed about the upward axis)")
    excess = measured - expected
    excess = excess - np.where(rests, 0.0, np.median(excess[~rests]))
    limit = _limits(excess, angle_std[known])
    slips = tuple(
        Slip(int(known[k + 1]), float(excess[k]))
        for k in np.flatnonzero((np.abs(excess) > limit) & _lasting(excess)).tolist()
    )
    regular = (np.abs(excess) <= limit) & ~rests
    per_frame = measured[regular] / gaps[regular]
    std = float(per_frame.std()) if len(per_frame) else 0.0
    noise = float(np.sqrt(2) * np.nanmedian(angle_std))
    if std > max(3 * noise, 0.05 * abs(float(np.median(measured)))):
        notes.append(f"uneven steps: {np.rad2deg(std):.2f} deg around {np.rad2deg(per_frame.mean()):.2f} deg")
    warnings += [f"slip of {np.rad2deg(s.angle):+.2f} deg before frame {s.frame}" for s in slips]
    wrong_way = (np.sign(measured) != direction) & (np.abs(measured) > 3 * noise + 1e-3)
    if wrong_way.any():
        warnings.append(f"the table turns back before frames {known[1:][wrong_way][:5].tolist()}")
    mean = float(per_frame.mean()) if len(per_frame) else 0.0
    return Steps(direction, mean, std, slips, tuple(warnings), tuple(notes), int(rests.sum()))


def _rests(measured: Array) -> NDArray[np.bool_]:
    """(n - 1,) steps that are none, where there are many of them."""
    turned = np.abs(measured)
    none = turned < RESTS * float(np.percentile(turned, 90)) if len(turned) else np.zeros(0, bool)
    return none if none.mean() >= OFTEN else np.zeros(len(turned), bool)


def _limits(excess: Array, angle_std: Array) -> Array:
    """How far each step (n - 1,) may be off [rad] before it is called a slip; `angle_std` (n,) of the frames."""
    spread = robust_std(excess)
    # a spread of few steps is itself uncertain: Student's quantile against the normal one, to first order (n - 1 = 4:
    # twice as wide, 24: a fifth)
    spread *= 1 + 4 / max(len(excess), 1)
    variance = np.nan_to_num(angle_std) ** 2
    own = np.sqrt(variance[1:] + variance[:-1])
    # the fit's figures count from the first frame and are careful: the more steps there are, the more count these
    said = float(np.median(own))
    if said > spread:
        own *= np.sqrt((len(excess) * spread**2 + COUNTS * said**2) / (len(excess) + COUNTS)) / said
    return np.asarray(np.maximum(np.maximum(UNUSUAL * spread, LEAST_SLIP), SURE * own))


def _lasting(excess: Array) -> NDArray[np.bool_]:
    """(n - 1,) bool: the frames behind the step stay turned against those before it by most of the step."""
    offset = np.concatenate([[0.0], np.cumsum(excess)])  # of each frame from where it was expected
    before = [np.median(offset[max(0, k - BESIDE + 1) : k + 1]) for k in range(len(excess))]
    after = [np.median(offset[k + 1 : k + 1 + BESIDE]) for k in range(len(excess))]
    # at an end the median is over two frames, and one wrong frame of two moves it by half
    return np.asarray(np.subtract(after, before) * np.sign(excess) > 0.7 * np.abs(excess))
