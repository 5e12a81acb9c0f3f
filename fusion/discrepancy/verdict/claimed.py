"""Claimed numbers: a fitted parameter as it stands in the verdict, every wave of a list with its own deviation."""

from collections.abc import Iterable

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from fusion.discrepancy.verdict.claim import ClaimedNumber
from fusion.sensor.parameter import Parameter
from fusion.sensor.words.quantity import is_determined

# a law of the range or of the disparity is one of the depth too
ALSO = {"range": "depth", "disparity": "depth"}


def variables_said(names: Iterable[str]) -> tuple[str, ...]:
    """Variables as a verdict lists them."""
    return tuple(dict.fromkeys(said for name in names for said in (name, ALSO.get(name, name))))


def claimed(about: Parameter, value: float, std: float | None) -> ClaimedNumber:
    """One number; `determined` is False where the data leave it as open as it was."""
    known = None if std is None or not np.isfinite(std) else float(std)
    sure = is_determined(about, value, std)
    return ClaimedNumber(value=float(value), std=known, unit=about.unit, determined=sure)


def claimed_list(about: Parameter, values: NDArray[np.float64], std: NDArray[np.float64]) -> ClaimedNumber:
    """A list by its first entry, as files of this format always had it, and all entries beside it."""
    known = [float(s) if np.isfinite(s) else None for s in std]
    each = [claimed(about, float(value), s) for value, s in zip(values, known, strict=True)]
    sure = tuple(bool(one.determined) for one in each)
    return replace(each[0], all=tuple(values.tolist()), all_std=tuple(known), all_determined=sure)
