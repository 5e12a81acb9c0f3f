"""Searching the periods of waves: one after the other, each again when another has come."""

import numpy as np
from numpy.typing import NDArray

from fusion.calibration.depth.laws.information import Information

Array = NDArray[np.floating]
SWEEPS = 2


def search_waves(
    information: Information, fixed: list[int], waves: NDArray[np.intp], number: int, begin: list[int]
) -> list[int]:
    """Columns of the sines of the best waves.

    Args:
        information: of the walls to fit.
        fixed: columns of the other terms of the law.
        waves: (p,) columns of all sines; each cosine is the next column.
        number: how many are wanted.
        begin: those found already for a smaller number.
    """
    found = list(begin)
    while len(found) < number:
        found.append(_best(information, _columns(fixed, found), waves))
        if len(found) == 1:
            continue
        for _ in range(SWEEPS):
            before = list(found)
            for place in range(len(found)):
                others = found[:place] + found[place + 1 :]
                found[place] = _best(information, _columns(fixed, others), waves)
            if found == before:
                break
    return found


def _columns(fixed: list[int], sines: list[int]) -> list[int]:
    return fixed + [column for sine in sines for column in (sine, sine + 1)]


def _best(information: Information, fixed: list[int], waves: NDArray[np.intp]) -> int:
    """The wave that explains most of what the fixed terms leave over."""
    M, b = information.penalised, information.b
    pairs = np.stack([waves, waves + 1], axis=1)
    own = M[pairs[:, :, None], pairs[:, None, :]]
    rest = b[pairs]
    if fixed:
        scale = np.sqrt(np.maximum(np.diag(M)[fixed], 1e-300))
        inner = np.linalg.pinv(M[np.ix_(fixed, fixed)] / np.outer(scale, scale), rcond=1e-10, hermitian=True)
        inner /= np.outer(scale, scale)
        cross = M[np.ix_(pairs.ravel(), np.asarray(fixed))].reshape(len(waves), 2, len(fixed))
        taken = cross @ inner
        own = own - taken @ cross.transpose(0, 2, 1)
        rest = rest - taken @ b[fixed]
    det = own[:, 0, 0] * own[:, 1, 1] - own[:, 0, 1] ** 2
    whole = np.diag(M)[waves] * np.diag(M)[waves + 1]
    x, y = rest[:, 0], rest[:, 1]
    with np.errstate(all="ignore"):
        gain = (own[:, 1, 1] * x * x - 2 * own[:, 0, 1] * x * y + own[:, 0, 0] * y * y) / det
    # where nothing of the wave is left beside those that are there, it gains nothing
    return int(waves[np.argmax(np.where(det > 1e-8 * whole, gain, -1.0))])
