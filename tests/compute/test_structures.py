"""Kernels with structures compute what those with single arguments do, on lines of the same numbers."""

from typing import NamedTuple

import numpy as np
import pytest

from fusion.compute.back_end import KNOWN
from fusion.compute.language import F32, func, kernel, ti
from fusion.compute.launch import Kernel
from fusion.compute.start import start
from fusion.compute.structures import apart, flattened


class Line(NamedTuple):
    """Places, and what they are multiplied with."""

    x: F32
    slope: ti.f32


@func
def height(line: ti.template(), i: ti.i32):
    return line.x[i] * line.slope


@kernel
def add(out: F32, line: Line, twice: ti.template()):
    """Adds a line's heights,
    once or twice."""
    for i in range(out.shape[0]):
        out[i] += height(line, i)
        if ti.static(twice):
            out[i] += line.x[i] * line.slope


@kernel
def broken(out: F32, line: Line):
    """Names something that is not there."""
    for i in range(out.shape[0]):
        out[i] = line.x[i]
        out[i] += not_there  # noqa: F821


def test_fields_arrive_whoever_calls(monkeypatch):
    start()
    for quick in (False, KNOWN):
        monkeypatch.setattr(Kernel, "quick", quick)
        for twice in (False, True):
            out = np.arange(4, dtype=np.float32)
            for slope in (3.0, 0.5):  # an earlier call's values do not stay
                add(out, Line(np.arange(4, dtype=np.float32), slope), twice)
            assert out.tolist() == [n * (1 + 3.5 * (1 + twice)) for n in range(4)]


@pytest.mark.skipif(not KNOWN, reason="no call is quick here")
def test_calls_with_structures_are_quick():
    start()
    add(np.ones(4, np.float32), Line(np.ones(4, np.float32), 1.0), False)
    assert any(add.ready.values())


def test_messages_name_the_line():
    start()
    line = broken.__wrapped__.__code__.co_firstlineno + 5
    with pytest.raises(ti.lang.exception.__dict__["TaichiNameError" if KNOWN else "QuadrantsNameError"]) as told:
        broken(np.zeros(3, np.float32), Line(np.zeros(3, np.float32), 1.0))
    assert f"line {line}, in broken" in str(told.value)


def test_a_structure_needs_the_line_of_a_docstring():
    def bare(line: Line):
        for i in range(line.x.shape[0]):
            line.x[i] = 0.0

    with pytest.raises(SyntaxError, match="bare takes structures and has no docstring"):
        flattened(bare)


def test_tuples_come_apart_in_their_places():
    assert apart((1, Line("x", 2.0), 3)) == (1, "x", 2.0, 3)
