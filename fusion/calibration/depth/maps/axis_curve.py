"""The curve of a calibration with its interval: the law's own numbers, and the other laws that may hold as well."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fusion.calibration.depth.laws.fitted import FitSetting, Fitted
from fusion.calibration.depth.laws.law_sensor import LawNumbers, with_law
from fusion.calibration.depth.laws.selection import JudgedLaw
from fusion.calibration.depth.laws.terms import LawTerm
from fusion.calibration.depth.maps.curve import (
    POINTS,
    DepthCurve,
    Rival,
    among_rivals,
    axis_terms,
    deviation_of,
    light_of,
    measured_offsets,
    span,
)
from fusion.calibration.depth.walls.wall import Wall
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import View

UNLIKELY = 1e-3  # weight below which another law is not looked at


def axis_curve(
    walls: list[Wall], rivals: list[Rival], fitted: Fitted, setting: FitSetting
) -> tuple[DepthCurve | None, NDArray, NDArray]:
    """The curve (None when no distance is known), and the walls' own errors (w,) [m] with their deviations.

    Args:
        walls: as read.
        rivals: the law in use, then others that may hold as well, as `rivals_of` has them.
        fitted: the law in use.
        setting: camera and known sensor.
    """
    if not any(np.isfinite(wall.distance) for wall in walls):
        unknown = np.full(len(walls), np.nan)
        return None, unknown, unknown
    distance = np.linspace(*span(walls), POINTS)
    place = (setting.camera, setting.known, light_of(walls))
    rows = axis_terms(fitted.terms, distance, *place)
    own, *others = rivals
    straight = axis_terms(own.terms, distance, *place) @ own.numbers
    beside = [(rival, axis_terms(rival.terms, distance, *place)) for rival in others]
    std = among_rivals(straight, deviation_of(rows, fitted.covariance), beside)
    light = light_of(walls)
    at = np.array([w.distance if np.isfinite(w.distance) else w.true_plane.distance for w in walls])
    curve = DepthCurve(distance, axis_bias(fitted.numbers, distance, setting, light), std)
    return curve, *measured_offsets(fitted.evidence, axis_bias(fitted.numbers, at, setting, light))


def axis_bias(numbers: LawNumbers, distance: NDArray, setting: FitSetting, light: float) -> NDArray[np.floating]:
    """(n,) error [m] of the law's effects at depths (n,) [m] on the optical axis; `light`: IR times squared depth."""
    pixel = replace(setting.camera, width=1, height=1, cx=0.0, cy=0.0, distortion=(), color=None)
    ideal = Sensor(principle=setting.known.principle, baseline=setting.known.baseline)
    sensor = with_law(ideal, pixel, replace(numbers, ratio=None))
    found = []
    for z in map(float, distance):
        depth = np.full((1, 1), z)
        ir = np.full((1, 1), light / z**2) if light > 0 else None
        found.append(float(sensor.predict(depth, View(pixel, depth, ir=ir))[0, 0]) - z)
    return np.array(found)


def rivals_of(judged: list[JudgedLaw], chosen: int, terms: list[LawTerm]) -> list[Rival]:
    """The law in use, then those that may hold as well by the walls left out; surfaces are no part of a curve.

    Pixels of one wall err together, so chi2 counts in units of what the best law leaves of a wall (quasi-likelihood,
    Burnham and Anderson 2002, section 2.5): a law may also be likelier than the one that is used for its millimetres.
    """
    by_key = {term.key: term for term in terms}
    own = judged[chosen].law
    plain = [j for j in judged if not j.candidate.surface]
    left = min(float(j.chi2.sum()) for j in judged if j.law is own)
    usual = max(1.0, min(float(j.chi2.mean()) for j in plain))
    rivals = [Rival(tuple(by_key[key] for key in own.keys), own.numbers, own.covariance, 1.0)]
    for j in plain:
        weight = float(np.exp(np.clip((left - j.chi2.sum()) / (2 * usual), -50, 50)))
        if j.law is not own and weight > UNLIKELY:
            rivals.append(Rival(tuple(by_key[key] for key in j.law.keys), j.law.numbers, j.law.covariance, weight))
    return rivals
