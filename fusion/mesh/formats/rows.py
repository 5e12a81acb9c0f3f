"""Text of mesh files: numbers by lines, with the number of the line that is wrong."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

SHOWN = 40  # characters of a wrong line
Lines = list[tuple[int, str]]  # number from 1, text


def filled(text: str, comment: str = "") -> Lines:
    """The lines that hold something, without what stands behind the comment's mark."""
    lines = enumerate(text.split("\n"), start=1)
    if comment and comment in text:
        lines = ((number, line.partition(comment)[0]) for number, line in lines)  # type: ignore[assignment]
    return [(number, line) for number, line in lines if line and not line.isspace()]


def table(lines: Sequence[tuple[int, str]], columns: int = 0) -> NDArray[np.float64]:
    """(lines, columns) numbers; as many columns as the first line has where they are not told.

    Raises:
        ValueError: a line with more or fewer, or with what is no number.
    """
    if not lines:
        return np.zeros((0, columns))
    columns = columns or len(lines[0][1].split())
    try:
        values = np.loadtxt([line for _, line in lines], np.float64, comments=None, ndmin=2)
    except ValueError:
        raise ValueError(_first_wrong(lines, columns)) from None
    if values.shape != (len(lines), columns):
        raise ValueError(_first_wrong(lines, columns))
    return values


def whole(values: NDArray[np.float64], lines: Sequence[tuple[int, str]]) -> NDArray[np.int64]:
    """The same as whole numbers; ValueError names the first line with one that is none, or beyond 2^53."""
    good = np.isfinite(values) & (np.abs(values) < 2.0**53)
    good[good] = values[good] == np.rint(values[good])
    if not good.all():
        raise ValueError(told(*lines[int(np.argmin(good.reshape(len(values), -1).all(axis=1)))], "whole numbers"))
    return values.astype(np.int64)


def told(number: int, line: str, expected: str) -> str:
    """`line 7: '1 2', where 3 numbers should be`."""
    shown = " ".join(line.split())
    shown = shown if len(shown) <= SHOWN else shown[:SHOWN] + "..."
    return f"line {number}: {shown!r}, where {expected} should be"


def _first_wrong(lines: Sequence[tuple[int, str]], columns: int) -> str:
    for number, line in lines:
        words = line.split()
        if len(words) != columns or not all(map(_is_number, words)):
            return told(number, line, f"{columns} number{'s' * (columns != 1)}")
    return "no table of numbers"


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return "_" not in word
