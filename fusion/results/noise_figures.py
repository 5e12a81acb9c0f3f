"""A noise calibration in the numbers that a caller wants first; lengths in metres."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from msgspec import Struct
from msgspec.structs import asdict
from numpy.typing import NDArray

from fusion.calibration.noise.calibration import NoiseCalibration
from fusion.calibration.noise.laws.fit import NoiseFit
from fusion.sensor.effects.readout.axial_noise import AxialNoise
from fusion.sensor.effects.readout.lateral_noise import LateralNoise
from fusion.sensor.words.quantity import FittedNumber, fitted


@dataclass(frozen=True)
class FittedInterval(FittedNumber):
    """With the interval that holds the number in 90 of 100 cases."""

    interval_90: tuple[float, float]


class LawFigures(Struct, frozen=True, omit_defaults=True):
    """A fitted law; `candidates` are the scores of all that were tried."""

    law: str
    parameters: dict[str, FittedInterval]
    correlation: NDArray[Any]
    rms: float
    heldout_error: float
    scatter_share: float
    candidates: dict[str, float] = {}


class LateralFigures(LawFigures, frozen=True, kw_only=True, omit_defaults=True):
    """The same of edges, and the distance within which nine of ten stand."""

    percentile_90_m: float
    percentile_90_shadow_m: float
    shadow: LawFigures | None


@dataclass(frozen=True)
class DropoutFigures:
    """Where values are lost."""

    ir_threshold: float
    width: float


@dataclass(frozen=True)
class PoseFigures:
    """What one pose of the target showed."""

    name: str
    frames: int
    distance_m: float
    tilt_rad: float
    axial_m: float
    axial_std_m: float
    lateral_m: tuple[float, ...]
    shadowed: tuple[bool, ...]
    valid: float
    no_data: float
    outliers: float


@dataclass(frozen=True)
class NoiseFigures:
    """The laws, the poses that they are from, and what was not seen."""

    axial: LawFigures
    lateral: LateralFigures | None
    dropout: DropoutFigures | None
    poses: tuple[PoseFigures, ...]
    not_seen: Any
    kept: Any
    notes: tuple[str, ...]


def noise_figures(found: NoiseCalibration) -> NoiseFigures:
    """The numbers of a calibration."""
    axial, lateral = found.axial, found.lateral
    return NoiseFigures(
        axial=_law(axial.best, AxialNoise, axial.fits),
        lateral=None
        if lateral is None
        else LateralFigures(
            **asdict(_law(lateral.best, LateralNoise, lateral.fits)),
            percentile_90_m=lateral.percentile,
            percentile_90_shadow_m=lateral.percentile_shadow,
            shadow=None if lateral.shadow is None else _law(lateral.shadow, LateralNoise),
        ),
        dropout=None if found.dropout is None else DropoutFigures(*found.dropout.numbers),
        poses=tuple(map(_pose, found.poses)),
        not_seen=axial.visible.hidden,
        kept=axial.kept,
        notes=tuple(text for _, text in found.notes),
    )


def _law(fit: NoiseFit, effect: Any, tried: Sequence[NoiseFit] = ()) -> LawFigures:
    wide = fit.half_width()
    numbers = {}
    for name, value, std in zip(fit.form.names, fit.numbers, fit.std, strict=True):
        one = fitted(effect, name, value, std)
        interval = (value - wide * std, value + wide * std)
        numbers[name] = FittedInterval(one.value, one.std, one.unit, one.determined, interval)
    scores = {one.form.title: one.score for one in tried}
    return LawFigures(fit.form.title, numbers, fit.correlation, fit.rms, fit.score, fit.scatter, scores)


def _pose(pose: Any) -> PoseFigures:
    seen = pose.seen
    return PoseFigures(
        name=pose.name,
        frames=seen.frames,
        distance_m=pose.depth,
        tilt_rad=pose.tilt,
        axial_m=pose.axial,
        axial_std_m=pose.axial_std,
        lateral_m=tuple(seen.lateral),
        shadowed=tuple(pose.shadowed),
        valid=seen.valid,
        no_data=seen.no_data,
        outliers=seen.outliers,
    )
