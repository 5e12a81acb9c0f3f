"""Results as JSON's own values: the one way from a typed result to a file or to `--json`."""

import json
import math
from collections.abc import Mapping
from pathlib import PurePath
from typing import Any


def json_values(result: object) -> Any:
    """A result as JSON holds it.

    Fields of Structs and dataclasses become keys, arrays and tuples lists, paths text, NaN and infinity null.

    Raises:
        TypeError: something in it has no form in JSON.

    >>> fusion.json_values({"rms_m": np.float64("nan"), "axis": np.zeros(3)})
    {'rms_m': None, 'axis': [0.0, 0.0, 0.0]}
    """
    import msgspec  # a tenth of a second, which help does not need

    return _finite(msgspec.to_builtins(result, str_keys=True, enc_hook=_form))


def json_text(result: object) -> str:
    """The same as text, as files hold it."""
    return json.dumps(json_values(result), indent=1)


def _form(value: Any) -> Any:
    """Arrays and numbers of NumPy, which is not loaded for this, and paths as text."""
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, Mapping):
        return dict(value)
    if isinstance(value, PurePath):
        return str(value)
    raise TypeError(f"{type(value).__name__} has no form in JSON")


def _finite(value: Any) -> Any:
    """JSON has no number that is not finite."""
    if isinstance(value, dict):
        return {key: _finite(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(entry) for entry in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
