"""What a law leaves out: offsets, scales and disparities of usual size, as far as the walls allow them beside it."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fusion.calibration.depth.laws.fitted import FitSetting, Fitted
from fusion.calibration.depth.laws.information import information_of, terms_of
from fusion.calibration.depth.laws.terms import LawTerm
from fusion.calibration.depth.maps.curve import Rival, axis_terms, light_of, span
from fusion.calibration.depth.walls.samples import WallSamples
from fusion.calibration.depth.walls.wall import Wall

# what a unit may be wrong by at all distances alike; curves and waves have priors of their own
STRAIGHT = ("offset", "scale", "disparity")
Array = NDArray[np.floating]


class Laws(NamedTuple):
    """The law in use and others that may hold as well, as `rivals_of` has them; the first fitted to its end."""

    rivals: list[Rival]
    fitted: Fitted
    left_out: tuple[LawTerm, ...]  # straight terms that are not in it


class AxisErrors(NamedTuple):
    """Standard deviation (n,) [m] of what is left on the optical axis at depths (n,) [m]."""

    distance: Array
    std: Array


def axis_errors(walls: list[Wall], laws: Laws, setting: FitSetting) -> AxisErrors:
    """At half the nearest wall's distance, at the nearest, middle and farthest, and at twice that."""
    near, far = span(walls)
    distance = np.array([near / 2, near, (near + far) / 2, far, 2 * far])

    def on_axis(terms: tuple[LawTerm, ...]) -> Array:
        return axis_terms(terms, distance, setting.camera, setting.known, light_of(walls))

    law, others = on_axis(laws.fitted.terms), on_axis(laws.left_out)
    own, *rivals = laws.rivals
    chosen, total = on_axis(own.terms) @ own.numbers, sum(law.weight for law in laws.rivals)
    apart = [np.sqrt(one.weight / total) * (on_axis(one.terms) @ one.numbers - chosen) for one in rivals]
    fields = np.column_stack([law @ root(laws.fitted.covariance), left_out(laws, law, others), *apart])
    return AxisErrors(distance, np.asarray(np.linalg.norm(fields, axis=1)))


def left_out(laws: Laws, law: Array, others: Array) -> Array:
    """(n, e) independent errors of depth by the straight terms left out, less what the law's numbers take of them.

    Each term alone may show plainly on walls at one distance, and two of them together not at all.

    Args:
        laws: the law in use and what it leaves out.
        law: (n, k) change of the depth per unit of its terms.
        others: (n, e) the same of those left out.
    """
    if not laws.left_out:
        return np.zeros((len(law), 0))
    fitted = laws.fitted
    terms = [*fitted.terms, *(replace(term, highest=term.typical) for term in laws.left_out)]
    more = [np.column_stack([e.terms, terms_of(e.samples, list(laws.left_out))]) for e in fitted.evidence]
    parts = [information_of(replace(e, terms=all_of), terms) for e, all_of in zip(fitted.evidence, more, strict=True)]
    M, k = sum(parts[1:], parts[0]).penalised, len(fitted.terms)
    size = np.sqrt(np.maximum(np.diag(M), 1e-300))  # units differ
    M = M / np.outer(size, size)
    taken = np.linalg.pinv(M[:k, :k], rcond=1e-10, hermitian=True) @ M[:k, k:]
    free = np.linalg.inv(M[k:, k:] - M[k:, :k] @ taken)
    return np.asarray((others / size[k:] - law / size[:k] @ taken) @ root(free))


def root(covariance: Array) -> Array:
    """(k, k) whose columns are independent errors of the numbers."""
    size = np.sqrt(np.maximum(np.diag(covariance), 1e-300))  # units differ
    values, vectors = np.linalg.eigh(covariance / np.outer(size, size))
    return np.asarray(size[:, None] * vectors * np.sqrt(np.maximum(values, 0)))


def straight(terms: list[LawTerm], keys: tuple[str, ...]) -> tuple[LawTerm, ...]:
    """The straight terms of these that are not among the keys of a law."""
    return tuple(term for term in terms if term.key in STRAIGHT and term.key not in keys)


def changes(terms: tuple[LawTerm, ...], at: WallSamples) -> Array:
    """(n, k) change of the depth per unit of each term."""
    return np.column_stack([np.zeros((len(at.depth), 0)), *(term.change(at) for term in terms)])
