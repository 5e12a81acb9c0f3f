"""The curve of a calibration with its interval: the law's own numbers, and the other laws that may hold as well."""

import numpy as np
from numpy.typing import NDArray

from fusion.calibration.depth.curve import (
    POINTS,
    Curve,
    Rival,
    among_rivals,
    axis_terms,
    deviation_of,
    light_of,
    measured_offsets,
    span,
)
from fusion.calibration.depth.fitted import Fitted, Setting
from fusion.calibration.depth.selection import Judged
from fusion.calibration.depth.terms import Term
from fusion.calibration.depth.wall import Wall

UNLIKELY = 1e-3  # weight below which another law is not looked at


def axis_curve(
    walls: list[Wall], choice: tuple[list[Judged], int, list[Term]], fitted: Fitted, setting: Setting
) -> tuple[Curve | None, NDArray, NDArray]:
    """The curve (None when no distance is known), and the walls' own errors (w,) [m] with their deviations.

    Args:
        walls: as read.
        choice: the candidates as judged, which is in use, and all terms.
        fitted: the law in use.
        setting: camera and known sensor.
    """
    if not any(np.isfinite(wall.distance) for wall in walls):
        unknown = np.full(len(walls), np.nan)
        return None, unknown, unknown
    distance = np.linspace(*span(walls), POINTS)
    place = (setting.camera, setting.known, light_of(walls))
    numbers = np.array([fitted.numbers.value.get(t.key, 0.0) for t in fitted.terms])
    rows = axis_terms(fitted.terms, distance, *place)
    bias = rows @ numbers
    rivals = [(rival, axis_terms(rival.terms, distance, *place)) for rival in _rivals(*choice)]
    std = among_rivals(bias, deviation_of(rows, fitted.covariance), rivals)
    at = axis_terms(fitted.terms, np.array([wall.true_plane.distance for wall in walls]), *place)
    return Curve(distance, bias, std), *measured_offsets(fitted.evidence, at @ numbers)


def _rivals(judged: list[Judged], chosen: int, terms: list[Term]) -> list[Rival]:
    """Laws without a surface that did nearly as well on the walls left out; the chosen one is not among them."""
    by_key = {term.key: term for term in terms}
    own = judged[chosen].law
    least = min(float(j.chi2.sum()) for j in judged if j.law is own)
    rivals = []
    for j in judged:
        weight = float(np.exp(np.clip((least - j.chi2.sum()) / 2, -50, 0)))
        if j.law is not own and not j.candidate.surface and weight > UNLIKELY:
            rivals.append(Rival(tuple(by_key[key] for key in j.law.keys), j.law.numbers, j.law.covariance, weight))
    return rivals
