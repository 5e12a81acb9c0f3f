"""Arrays in NumPy's own files: plain values only, as many as the file holds."""

import zipfile
from pathlib import Path
from typing import IO

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from fusion.errors import FusionError
from fusion.files.limits import check_size
from fusion.files.reading import open_regular

NUMBERS, PLAIN = "iuf", "iufbU"  # kinds of NumPy's types: numbers; and truth values and text
PACKED = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)  # as NumPy writes


def read_npy(path: Path | str, error: type[FusionError] = FusionError, what: str = "the array") -> NDArray[np.float64]:
    """The numbers of a `.npy` file; nothing in it is run, and no more memory is taken than the file fills.

    Raises:
        FusionError: of the kind `error`: no such file, not of this format, other things than numbers, cut short.
    """
    with open_regular(path, error, what) as file:
        array = _array(file, path, error, what)
    if array.dtype.kind not in NUMBERS:
        raise error(f"{what} holds no numbers", path, array.dtype, "numbers")
    return array.astype(np.float64)


def npy_header(
    path: Path | str, error: type[FusionError] = FusionError, what: str = "the array"
) -> tuple[tuple[int, ...], np.dtype]:
    """Shape and type of the array in a `.npy` file, as its header says. Raises as `read_npy`."""
    with open_regular(path, error, what) as file:
        shape, _, kind = _header(file, path, error, what)
    return shape, kind


def read_npz(
    path: Path | str, error: type[FusionError] = FusionError, what: str = "the arrays", only: str = ""
) -> dict[str, NDArray]:
    """The arrays of a `.npz` file by their name, unpacked only where all of them fit into what is allowed.

    Args:
        only: the one array that is wanted where there are several; the only one whatever its name.

    Raises:
        FusionError: of the kind `error`: as `read_npy`, or the archive is damaged, or does not hold `only`.
    """
    with open_regular(path, error, what) as file:
        try:
            with zipfile.ZipFile(file) as archive:
                parts = {info.filename.removesuffix(".npy"): info for info in archive.infolist()}
                if only:
                    name = only if only in parts or len(parts) != 1 else next(iter(parts))
                    parts = {name: parts[name]}
                check_size(sum(info.file_size for info in parts.values()), path, error, what)
                found = {}
                for name, info in parts.items():
                    if info.compress_type not in PACKED:
                        raise ValueError(f"{name[:40]} is packed in a way that NumPy does not use")
                    with archive.open(info) as part:
                        found[name] = _array(part, path, error, f"{what}: {name[:40]}")
                        if part.read(1):
                            raise ValueError(f"{name[:40]} holds more than its header says")
        except FusionError:
            raise
        except KeyError:
            raise error(f"{what} cannot be read", path, f"no array {only}", f"an array {only}") from None
        except Exception as problem:  # whatever the packers make of damaged bytes
            raise error(f"{what} cannot be read", path, str(problem)[:100], "a whole file of NumPy") from problem
    return found


def _header(
    file: IO[bytes], path: Path | str, error: type[FusionError], what: str
) -> tuple[tuple[int, ...], bool, np.dtype]:
    """(shape, column by column, type) of the array that begins here. Raises as `read_npy`."""
    try:
        read = {(1, 0): npy.read_array_header_1_0, (2, 0): npy.read_array_header_2_0}[npy.read_magic(file)]
        shape, columns_first, kind = read(file)
        if min(shape, default=0) < 0:
            raise ValueError(f"shape {shape}")
    except Exception as problem:  # whatever NumPy makes of a header that anybody wrote
        raise error(
            f"{what} is no .npy file", path, "a header that cannot be read", "an array that NumPy wrote"
        ) from problem
    return shape, columns_first, kind


def _array(file: IO[bytes], path: Path | str, error: type[FusionError], what: str) -> NDArray:
    """The array that begins here. Raises as `read_npy`."""
    shape, columns_first, kind = _header(file, path, error, what)
    size = kind.itemsize * int(np.prod(shape, dtype=object))
    check_size(size, path, error, what)
    if kind.kind not in PLAIN:
        raise error(f"{what} holds no numbers", path, kind, "numbers")
    data = file.read(size)
    if len(data) < size:
        raise error(f"{what} is cut short", path, f"{len(data)} bytes of numbers", f"{size}, as its header says")
    return np.frombuffer(data, kind).reshape(shape, order="F" if columns_first else "C")
