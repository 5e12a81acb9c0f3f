"""The result of a calibration as the content of files: numbers that JSON can hold."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from fusion.calibration.lens.boards.board import BoardFile
from fusion.calibration.lens.boards.search import Search
from fusion.calibration.lens.intrinsics import CameraFit, Intrinsics
from fusion.files.json_values import json_values
from fusion.recording.native.camera_file import camera_to_dict

Array = NDArray[Any]


@dataclass(frozen=True)
class OutlierFigures:
    """A view that does not fit."""

    view: str
    rms_px: float
    reason: str


@dataclass(frozen=True)
class CorrelationFigures:
    """Of the parameters, in this order."""

    names: tuple[str, ...]
    matrix: Array


@dataclass(frozen=True)
class InfluenceFigures:
    """The view without which the parameters move most, and by how many standard deviations."""

    view: str
    sigmas: float


@dataclass(frozen=True)
class PitchFigures:
    """How far apart rows are over how far apart columns are."""

    ratio: float
    std: float


@dataclass(frozen=True)
class BowFigures:
    """How far the board's corners lie off a plane, from one side to the other [m], and over which length."""

    bow_m: float
    std_m: float
    over_m: float


@dataclass(frozen=True)
class LensFigures:
    """All numbers of one camera; parameters in pixels, distortion without unit."""

    parameters: dict[str, float]
    std: dict[str, float]
    std_scatter: dict[str, float]
    std_jackknife: dict[str, float]
    correlation: CorrelationFigures
    rms_px: float
    sigma_px: float
    pictures: int
    found: int
    used: int
    missed: list[str]
    unread: dict[str, str]
    outliers: tuple[OutlierFigures, ...]
    outliers_kept: bool
    corners_left_out: dict[str, int]
    most_influential: InfluenceFigures
    uncertainty: dict[str, float]
    coverage: float
    k3_held: bool
    row_pitch: PitchFigures
    bow: BowFigures


@dataclass(frozen=True)
class PairFigures:
    """How colour lies to depth."""

    T_color_depth: Array
    std_rotation_rad: Array
    std_translation_m: Array
    rms_px: float
    pairs: int
    left_out: list[str]


class CalibrationFigures(Struct, frozen=True, omit_defaults=True):
    """All numbers of a calibration of lenses."""

    board: BoardFile
    cameras: dict[str, LensFigures]
    warnings: tuple[str, ...]
    pair: PairFigures | None = None


def calibrated_camera(result: Intrinsics) -> dict[str, Any]:
    """The content of `camera.json`, with how it came about under "calibration"; readers ignore that."""
    return camera_to_dict(result.camera) | {"calibration": json_values(numbers(result))}


def numbers(result: Intrinsics) -> CalibrationFigures:
    """All numbers of a result."""
    cameras = {name: _fit(fit, result.searches[name]) for name, fit in result.fits.items()}
    pair = result.pair
    beside = None if pair is None else PairFigures(
        pair.T_color_depth, pair.std_rotation, pair.std_translation, pair.rms_px, len(pair.used), pair.left_out
    )  # fmt: skip
    return CalibrationFigures(result.board.file(), cameras, tuple(result.warnings), beside)


def _fit(fit: CameraFit, search: Search) -> LensFigures:
    known, judged = fit.spread, fit.judged
    named = {outlier.name for outlier in judged.outliers}
    names = judged.solution.names

    def by_name(values: Any) -> dict[str, float]:
        return dict(zip(names, map(float, values), strict=True))

    return LensFigures(
        parameters=by_name(judged.solution.parameters),
        std=by_name(known.std),
        std_scatter=by_name(known.scatter),
        std_jackknife=by_name(known.jackknife),
        correlation=CorrelationFigures(tuple(names), np.round(known.correlation, 6)),
        rms_px=judged.solution.rms,
        sigma_px=known.sigma_px,
        pictures=len(search.views) + len(search.missed),
        found=len(search.views),
        used=len(judged.views),
        missed=search.missed,
        unread=search.unread,
        outliers=tuple(OutlierFigures(o.name, o.rms_px, o.reason) for o in judged.outliers),
        outliers_kept=bool(named & {v.name for v in judged.views}),
        corners_left_out=judged.wild,
        most_influential=InfluenceFigures(*fit.most_influential),
        uncertainty=fit.uncertainty.numbers(),
        coverage=fit.coverage,
        k3_held=fit.k3_held,
        row_pitch=PitchFigures(*fit.shape.pitch),
        bow=BowFigures(*fit.shape.bow, 2 * fit.shape.half),
    )
