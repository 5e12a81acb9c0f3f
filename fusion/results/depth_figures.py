"""A depth calibration in the numbers that a caller wants first."""

from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

from fusion.calibration.depth.calibration import DepthCalibration


@dataclass(frozen=True)
class WallFigures:
    """One wall: where it stood, how wrong the depth was there, and what the law leaves when it took no part."""

    recording: str
    distance_m: float
    error_m: float
    error_std_m: float
    left_heldout_m: float
    tilt_rad: float
    share_of_image: float


@dataclass(frozen=True)
class CurveFigures:
    """The error over the distance with its interval."""

    distance_m: NDArray[Any]
    error_m: NDArray[Any]
    half_width_90_m: NDArray[Any]


@dataclass(frozen=True)
class LeftFigures:
    """What is left on the optical axis by all that is known, from half the nearest distance to twice the farthest."""

    distance_m: NDArray[Any]
    std_m: NDArray[Any]


@dataclass(frozen=True)
class DepthFigures:
    """The law, the errors [m] on walls left out, and what was not seen."""

    law: str
    heldout_before_m: float
    heldout_after_m: float
    heldout_axis_m: float
    radial_limit_px: float | None
    walls: tuple[WallFigures, ...]
    candidates: dict[str, float]
    curve: CurveFigures | None
    left: LeftFigures | None
    not_seen: tuple[str, ...]
    notes: tuple[str, ...]


def depth_figures(found: DepthCalibration) -> DepthFigures:
    """The numbers of a calibration."""
    rows = zip(found.walls, found.offset, found.offset_std, found.best.rms, strict=True)
    curve = found.curve
    return DepthFigures(
        law=found.best.candidate.name,
        heldout_before_m=found.before.error,
        heldout_after_m=found.best.error,
        heldout_axis_m=found.best.axis_error,
        radial_limit_px=found.radial_limit,
        walls=tuple(
            WallFigures(wall.name, wall.distance, error, std, left, wall.plane.tilt, float(wall.mask.mean()))
            for wall, error, std, left in rows
        ),
        candidates={judged.candidate.name: judged.error for judged in found.judged},
        curve=None if curve is None else CurveFigures(curve.distance, curve.bias, curve.half_width),
        left=None if found.left is None else LeftFigures(found.left.distance, found.left.std),
        not_seen=tuple(sorted({f"{v.term.effect}.{v.term.parameter}" for v in found.visibility if not v.seen})),
        notes=tuple(text for _, text in found.notes),
    )
