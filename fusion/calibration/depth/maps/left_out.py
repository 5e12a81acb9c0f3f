"""What a law leaves out: offsets, scales and disparities of usual size, as far as the walls allow them beside it."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fusion.calibration.depth.laws.fitted import FitSetting, Fitted
from fusion.calibration.depth.laws.information import information_of, terms_of
from fusion.calibration.depth.laws.terms import LawTerm
from fusion.calibration.depth.maps.curve import Rival, changes, light_of, span
from fusion.calibration.depth.walls.samples import WallSamples, samples_on_axis
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

    at = samples_on_axis(distance, setting.camera, setting.known, light_of(walls))
    return AxisErrors(distance, np.asarray(np.linalg.norm(np.column_stack(law_errors(laws, at)), axis=1)))


def law_errors(laws: Laws, at: WallSamples) -> tuple[Array, Array]:
    """(n, a) independent errors of depth by the law's numbers and what it leaves out, (n, r) by that another may hold.

    The first by the covariance of the numbers, in which the walls' scatter is; the last by how far the others lie from
    the law, each by its weight.
    """
    own, *rivals = laws.rivals
    law = changes(laws.fitted.terms, at)
    of_numbers = np.column_stack([law @ root(laws.fitted.covariance), left_out(laws, law, changes(laws.left_out, at))])
    chosen, total = changes(own.terms, at) @ own.numbers, sum(one.weight for one in laws.rivals)
    apart = [np.sqrt(one.weight / total) * (changes(one.terms, at) @ one.numbers - chosen) for one in rivals]
    return of_numbers, np.column_stack([np.zeros((len(law), 0)), *apart])


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
