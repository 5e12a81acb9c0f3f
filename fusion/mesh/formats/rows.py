"""Text of mesh files: its lines and their numbers, or one sentence that names the line which is wrong."""

from contextlib import suppress

import numpy as np
from numpy.typing import NDArray

SHOWN = 40  # characters of a wrong line
Lines = list[tuple[int, str]]  # number from 1, text


def filled(text: str, comment: str = "", above: int = 0) -> Lines:
    """The lines that hold something, without what stands behind the comment's mark; `above`: lines before the text."""
    lines = enumerate(text.split("\n"), start=above + 1)
    if comment and comment in text:
        lines = ((number, line.partition(comment)[0]) for number, line in lines)  # type: ignore[assignment]
    return [(number, line) for number, line in lines if line and not line.isspace()]


def joined(lines: Lines, head: str = "") -> bytes:
    """What a library is given: lines that were checked, and no others."""
    return (head + "".join(f"{line}\n" for _, line in lines)).encode()


def table(lines: Lines, columns: int = 0) -> NDArray[np.float64]:
    """(lines, columns) numbers; as many columns as the first line has where they are not told.

    Raises:
        ValueError: a line with more or fewer, or with what is no number.
    """
    if not lines:
        return np.zeros((0, columns))
    columns = columns or len(lines[0][1].split())
    with suppress(ValueError):
        values = np.loadtxt([line for _, line in lines], np.float64, comments=None, ndmin=2)
        if values.shape == (len(lines), columns):
            return values
    raise ValueError(told(*next((one for one in lines if not _fits(one[1], columns)), lines[0]), f"{columns} numbers"))


def _fits(line: str, columns: int) -> bool:
    try:
        return len([float(word) for word in line.replace("_", "?").split()]) == columns
    except ValueError:
        return False


def check_whole(values: NDArray[np.float64], lines: Lines, kind: str) -> None:
    """ValueError names the first line with a value that numpy's type `kind` of integers cannot hold."""
    limits = np.iinfo(kind)
    good = (values >= limits.min) & (values <= limits.max) & (values == np.rint(values))
    if not good.all():
        wrong = lines[int(np.argmin(good.reshape(len(lines), -1).all(axis=1)))]
        raise ValueError(told(*wrong, f"whole numbers from {limits.min} to {limits.max}"))


def told(number: int, line: str, expected: str) -> str:
    """`line 7: '1 2', where 3 numbers should be`."""
    shown = " ".join(line.split())
    shown = shown if len(shown) <= SHOWN else shown[:SHOWN] + "..."
    return f"line {number}: {shown!r}, where {expected} should be"
