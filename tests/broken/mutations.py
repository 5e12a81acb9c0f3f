"""Hypothesis strategies: any bytes, and any mutation of a good file."""

import re

from hypothesis import strategies as st

NUMBER = re.compile(rb"-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")
EXTREMES = (
    b"0",
    b"-1",
    b"1",
    b"nan",
    b"inf",
    b"NaN",
    b"-Infinity",
    b"1e300",
    b"-1e300",
    b"1e-300",
    b"1e999",
    b"2147483648",
    b"4294967295",
    b"-2147483649",
    b"18446744073709551616",
    b"9" * 400,
    b"0.1",
    b"null",
    b"[]",
    b"{}",
    b'""',
    b"true",
    b"",
    b"1_0",
    b"0x10",
    b"\xd9\xa3",
)
PIECES = (
    b"\0",
    b"\xff",
    b"\xef\xbb\xbf",
    b"\r",
    b"\n",
    b"\x1b[31m",
    b'"',
    b"{",
    b"[",
    b"]",
    b"}",
    b",",
    b" ",
    b"\xed\xa0\x80",
    b"#",
    b"../",
    b"/",
    b"\\u0000",
)
place = st.integers(0, 10**6)  # scaled to the file: the same choice means the same place in any file


def _flip(data: bytes, at: int, _: int, with_: bytes) -> bytes:
    return data[:at] + bytes([data[at] ^ (with_[0] if with_ else 1)]) + data[at + 1 :] if at < len(data) else data


def _cut(data: bytes, at: int, _: int, with_: bytes) -> bytes:
    return data[:at]


def _insert(data: bytes, at: int, _: int, with_: bytes) -> bytes:
    return data[:at] + with_ + data[at:]


def _drop(data: bytes, at: int, to: int, with_: bytes) -> bytes:
    return data[: min(at, to)] + data[max(at, to) :]


def _repeat(data: bytes, at: int, to: int, with_: bytes) -> bytes:
    part = data[min(at, to) : max(at, to)][:2000]
    return data[:at] + part + data[at:]


def _number(data: bytes, at: int, _: int, with_: bytes) -> bytes:
    """The number that stands next after a place becomes another."""
    found = NUMBER.search(data, at) or NUMBER.search(data)
    return data[: found.start()] + with_ + data[found.end() :] if found else data


def _line(data: bytes, at: int, to: int, with_: bytes) -> bytes:
    """Two lines change places."""
    lines = data.split(b"\n")
    a, b = at % len(lines), to % len(lines)
    lines[a], lines[b] = lines[b], lines[a]
    return b"\n".join(lines)


_WITH = st.one_of(st.sampled_from(EXTREMES), st.sampled_from(PIECES), st.binary(min_size=1, max_size=8))
_EDITS = st.lists(
    st.tuples(st.sampled_from((_number, _number, _flip, _cut, _insert, _drop, _repeat, _line)), place, place, _WITH),
    min_size=1,
    max_size=4,
)


def mutated(good: bytes) -> st.SearchStrategy[bytes]:
    """A good file after one to four changes; now and then bytes of no meaning, some with the good beginning."""
    return st.one_of(
        _EDITS.map(lambda edits: _edited(good, edits)),
        _EDITS.map(lambda edits: _edited(good, edits)),
        _EDITS.map(lambda edits: _edited(good, edits)),
        st.binary(max_size=200),
        st.binary(max_size=200).map(lambda end: good[:40] + end),
    )


def _edited(good: bytes, edits: list[tuple]) -> bytes:
    data = good
    for change, at, to, with_ in edits:
        data = change(data, at * len(data) // 10**6, to * len(data) // 10**6, with_)
    return data
