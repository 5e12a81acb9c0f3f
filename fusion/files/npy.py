"""Arrays in NumPy's own files: numbers only, as many as the file holds."""

from pathlib import Path

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from fusion.errors import FusionError
from fusion.files.limits import check_size
from fusion.files.reading import open_regular

NUMBERS = "iuf"  # kinds of NumPy's types


def read_npy(path: Path | str, error: type[FusionError] = FusionError, what: str = "the array") -> NDArray[np.float64]:
    """The numbers of a `.npy` file; nothing in it is run, and no more memory is taken than the file fills.

    Raises:
        FusionError: of the kind `error`: no such file, not of this format, other things than numbers, cut short.
    """
    with open_regular(path, error, what) as file:
        try:
            read = {(1, 0): npy.read_array_header_1_0, (2, 0): npy.read_array_header_2_0}[npy.read_magic(file)]
            shape, columns_first, kind = read(file)
            if min(shape, default=0) < 0:
                raise ValueError(f"shape {shape}")
            size = kind.itemsize * int(np.prod(shape, dtype=object))
        except Exception as problem:  # whatever NumPy makes of a header that anybody wrote
            raise error(f"{what} is no .npy file", path, str(problem)[:100], "an array that NumPy wrote") from problem
        check_size(size, path, error, what)
        if kind.kind not in NUMBERS:
            raise error(f"{what} holds no numbers", path, kind, "numbers")
        data = file.read(size)
    if len(data) < size:
        raise error(f"{what} is cut short", path, f"{len(data)} bytes of numbers", f"{size}, as its header says")
    return np.frombuffer(data, kind).reshape(shape, order="F" if columns_first else "C").astype(np.float64)
