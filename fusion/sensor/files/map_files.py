"""The maps of a sensor model: `.npy` files beside its `sensor.json`, which names them."""

import io
from itertools import count
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fusion.files.output.publish import atomic_file
from fusion.files.reading import read_bytes


def store_map(folder: Path, name: str, value: NDArray) -> str:
    """Write a map under a name that nothing else has yet, so that every file that names an older one stays right.

    Returns:
        The name: `NAME.npy`, or `NAME_2.npy` and so on where another map has that.
    """
    memory = io.BytesIO()  # np.save itself would not tell why it could not write
    np.save(memory, value)
    for number in count(1):
        path = folder / (f"{name}.npy" if number == 1 else f"{name}_{number}.npy")
        if not path.exists():
            with atomic_file(path) as partial:
                partial.write_bytes(memory.getvalue())
        elif not path.is_file() or read_bytes(path) != memory.getvalue():
            continue
        return path.name
    raise AssertionError("numbers end")
