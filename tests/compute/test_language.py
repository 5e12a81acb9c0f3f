"""Taichi is imported and reads kernels quickly, and otherwise as it does."""

import gc
import inspect

import pytest

from fusion.compute.back_ends import taichi_copy
from fusion.compute.back_ends.taichi_copy import reading


@pytest.fixture
def own(monkeypatch):
    """This process counts as the program's own for a while."""
    monkeypatch.setattr(taichi_copy, "own_process", lambda: True)


def test_the_line_of_source_is_the_one_that_python_finds(own):
    def told() -> tuple[list[str] | None, int]:
        frame = inspect.currentframe()
        assert frame is not None
        found = inspect.getframeinfo(frame)
        return found.code_context, found.lineno

    slow = told()
    with reading():
        assert told() == slow


def test_the_collector_and_inspect_are_left_as_they_were(own):
    plain = inspect.getframeinfo
    for collected in (True, False):
        (gc.enable if collected else gc.disable)()
        try:
            with reading():
                assert not gc.isenabled()
            assert gc.isenabled() == collected
        finally:
            gc.enable()
    assert inspect.getframeinfo is plain


def test_in_a_library_they_are_not_touched():
    plain = inspect.getframeinfo
    with reading():
        assert gc.isenabled()
        assert inspect.getframeinfo is plain
