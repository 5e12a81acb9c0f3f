"""Results as JSON's own values: the one way from a typed result to a file or to `--json`."""

import math
from typing import Any

import msgspec
import numpy as np


def json_values(result: object) -> Any:
    """Structs and dataclasses as objects by their fields' names, arrays and tuples as lists, NaN and infinity as null.

    Raises:
        TypeError: something in it has no form in JSON.
    """
    return _finite(msgspec.to_builtins(result, str_keys=True, enc_hook=_numpy))


def _numpy(value: object) -> Any:
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    raise TypeError(f"{type(value).__name__} has no form in JSON")


def _finite(value: Any) -> Any:
    """JSON has no number that is not finite."""
    if isinstance(value, dict):
        return {key: _finite(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(entry) for entry in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
