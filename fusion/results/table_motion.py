"""What a turntable did, as reports read it and `turntable.json` holds it."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from fusion.certainty.sigma import SigmaFigures

Array = NDArray[np.float64]

FRAME = "the first camera's: x right, y down, z forward; mesh.ply: z up along the axis, plate at z = 0"
NO_PLATE = FRAME.replace("plate at z = 0", "z = 0 beside the middle of the object, as no plate was seen")


@dataclass(frozen=True)
class ClosingGap:
    """How far two views about a full turn apart miss each other, as `Gap` has it; None where the turn is not full."""

    angle_rad: float | None = None
    distance: float | None = None
    deviations: float | None = None


@dataclass(frozen=True)
class SlipFound:
    """The first frame after a slip, and how far the table turned beyond what was expected."""

    frame: int
    angle_rad: float


@dataclass(frozen=True)
class UsedCamera:
    """The camera of the result [px], and whether the scan itself found it."""

    fx: float
    fy: float
    cx: float
    cy: float
    refined: bool


@dataclass(frozen=True)
class FocalFigures:
    """What the turning object says of the focal length: its relative error, with deviation, and the right one [px]."""

    relative: float
    std: float
    fx: float


@dataclass(frozen=True, kw_only=True)
class TableMotion:
    """The axis, the angles and what does not fit one rigid axis. Fields are the keys of `turntable.json`."""

    frame: str = FRAME
    # axis_point, axis_direction: (3,) in the first camera's frame [m], out of the plate
    axis_point: Array
    axis_direction: Array
    # the object stands on it; `hidden_m`: so far above it the two cannot be told apart, and the sides are carried down
    plate_seen: bool = False
    hidden_m: float = 0.0
    radius: float = float("nan")  # of the camera's circle [m]
    # angles_rad, angles_std_rad, told_rad: (n,) how far the object has turned, its deviation, and what the log or the
    # stated step says; NaN where a frame is rejected, None where nothing was said
    angles_rad: Array
    angles_std_rad: Array | None = None
    told_rad: Array | None = None
    # verdict, reasons: what the scan is worth
    verdict: str = ""
    reasons: tuple[str, ...] = ()
    direction: int = 1  # sign of the angles about the axis
    # radial_rms, axial_rms: of the tracked centres off the circle [m]
    radial_rms: float = float("nan")
    axial_rms: float = float("nan")
    # closure, closure_raw: after the post-pass and before
    closure: ClosingGap = ClosingGap()
    closure_raw: ClosingGap = ClosingGap()
    wobble_rad: float = float("nan")  # rms rocking of the axis over the freely tracked poses
    step_mean_rad: float = float("nan")
    step_std_rad: float = float("nan")
    # rejected_frames, rejected_reasons: frames that take no part
    rejected_frames: tuple[int, ...] = ()
    rejected_reasons: dict[int, str] = field(default_factory=dict)
    slips: tuple[SlipFound, ...] = ()
    camera: UsedCamera | None = None
    focal_length_check: FocalFigures | None = None
    # errors of depth that the scan itself showed, in words of `fusion.turntable.selfcheck`
    depth_taken_out: dict[str, float] = field(default_factory=dict)
    sigma: SigmaFigures | None = None  # how sure the vertices are; None where that was not asked
