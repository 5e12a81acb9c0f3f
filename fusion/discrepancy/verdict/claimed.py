"""Claimed numbers: a fitted parameter as it stands in the verdict, every wave of a list with its own deviation."""

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.sensor.parameter import Parameter
from fusion.sensor.quantity import is_determined

# a law of the range or of the disparity is one of the depth too
ALSO = {"range": "depth", "disparity": "depth"}


def variables_said(names: Iterable[str]) -> list[str]:
    """Variables as a verdict lists them."""
    return list(dict.fromkeys(said for name in names for said in (name, ALSO.get(name, name))))


def claimed(about: Parameter, value: float, std: float | None) -> dict[str, Any]:
    """One number; `determined` is False where the data leave it as open as it was."""
    known = None if std is None or not np.isfinite(std) else float(std)
    sure = is_determined(about, value, std)
    return {"value": float(value), "std": known, "unit": about.unit, "determined": sure}


def claimed_list(about: Parameter, values: NDArray[np.float64], std: NDArray[np.float64]) -> dict[str, Any]:
    """A list by its first entry, as files of this format always had it, and all entries beside it."""
    known = [float(s) if np.isfinite(s) else None for s in std]
    first = claimed(about, float(values[0]), known[0])
    sure = [is_determined(about, float(value), s) for value, s in zip(values, known, strict=True)]
    return {**first, "all": values.tolist(), "all_std": known, "all_determined": sure}
