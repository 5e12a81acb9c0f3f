"""Progress is told to whom the caller chooses, to nobody by default; every second belongs to one stage."""

import threading
from types import SimpleNamespace

import pytest

from fusion import progress
from fusion.progress import each, following, note, seconds, stage


@pytest.fixture
def clock(monkeypatch):
    """Goes on when it is told to."""
    clock = SimpleNamespace(now=1000.0)
    monkeypatch.setattr(progress.time, "perf_counter", lambda: clock.now)
    return clock


class Heard:
    """Remembers what it is told."""

    def __init__(self) -> None:
        self.places: list[tuple[tuple[str, ...], int, int | None]] = []
        self.notes: list[str] = []

    def at(self, stages, done, total) -> None:
        self.places.append((stages, done, total))

    def note(self, text) -> None:
        self.notes.append(text)


def work() -> list[int]:
    with stage("reading"):
        note("once")
    return list(each([1, 2], "tracking"))


def test_nobody_is_told_by_default_and_the_work_is_the_same():
    assert work() == [1, 2]
    assert seconds() == {}


def test_the_chosen_listener_is_told_every_step():
    heard = Heard()
    with following(heard):
        assert work() == [1, 2]
    assert heard.places == [
        (("reading",), 0, None),
        ((), 0, None),  # nothing is in the way of what is printed now
        (("tracking",), 0, 2),
        (("tracking",), 1, 2),
        (("tracking",), 2, 2),
        ((), 0, None),
    ]
    assert heard.notes == ["once"]
    work()
    assert len(heard.places) == 6, "nobody follows any more"


def test_items_that_do_not_know_their_number_are_told_it():
    heard = Heard()
    with following(heard):
        assert list(each(iter("ab"), "writing", 2)) == ["a", "b"]
    assert [done for _, done, total in heard.places if total == 2] == [0, 1, 2]


def test_inner_stages_are_shown_and_their_time_goes_to_the_outermost(clock):
    heard = Heard()
    with following(heard):
        for _ in each([0, 0], "looking"):
            with stage("wall"):
                clock.now += 4.0
        spent = seconds()
    assert (("looking", "wall"), 0, None) in heard.places
    assert (("looking",), 2, 2) in heard.places
    assert spent == {"looking": 8.0, "other": 0.0}


def test_every_second_is_counted_once(clock):
    with following():
        clock.now += 1.0
        for name, spent in (("reading", 2.0), ("tracking", 8.0), ("reading", 32.0)):
            with stage(name):
                clock.now += spent
            clock.now += 4.0
        assert seconds() == {"reading": 34.0, "tracking": 8.0, "other": 13.0}


def test_an_error_or_a_break_ends_the_stages_it_leaves():
    heard = Heard()
    with following(heard):
        with pytest.raises(ValueError, match="broken"), stage("tracking"):
            for item in each([1, 2], "frames"):
                raise ValueError(f"broken {item}")
        for _ in each([1, 2], "reading"):
            break
        with stage("mesh"):
            pass
        assert set(seconds()) == {"tracking", "reading", "mesh", "other"}
    assert heard.places[-2:] == [(("mesh",), 0, None), ((), 0, None)]


def test_each_thread_has_its_own_listener_or_none():
    mine, theirs = Heard(), Heard()

    def other() -> None:
        work()
        with following(theirs):
            list(each("xyz", "other"))

    with following(mine):
        thread = threading.Thread(target=other)
        thread.start()
        thread.join()
        list(each("a", "mine"))
    assert {stages for stages, _, _ in mine.places if stages} == {("mine",)}
    assert {stages for stages, _, _ in theirs.places if stages} == {("other",)}
