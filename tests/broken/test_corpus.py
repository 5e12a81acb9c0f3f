"""Broken inputs against the program: the quick part in every test, all of them among the slow ones."""

import contextlib
import itertools
import os
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from queue import SimpleQueue

import pytest

from broken import corpus
from broken.case import Case
from broken.judge import TOO_MUCH, judged
from broken.open import OPEN
from broken.runner import Fresh, Server, forget, keep_kernels, run, serving

WORKERS = min(4, os.cpu_count() or 1)


@pytest.fixture(scope="module")
def servers(good_inputs: Path) -> Iterator[SimpleQueue[Server]]:
    """Forking servers, as many as there are cores; a case takes one and puts it back."""
    free: SimpleQueue[Server] = SimpleQueue()
    started = [Server() for _ in range(1 if "PYTEST_XDIST_WORKER" in os.environ else WORKERS)]
    for server in started:
        free.put(server)
    yield free
    for server in started:
        server.close()


def _whole_demo(case: Case) -> bool:
    return case.name.endswith(": demo")


def _too_much(wrong: str) -> bool:
    return wrong.startswith(TOO_MUCH)


def broken_rules(cases: Iterable[Case], servers: SimpleQueue[Server], place: Path) -> dict[str, list[str]]:
    """Names of the cases that break the rule, with what they break."""
    count = itertools.count()

    def one(case: Case) -> tuple[str, list[str]]:
        server, folder = servers.get(), place / f"{next(count):05d}"
        try:
            return case.name, judged(case, run(case, server, folder))
        finally:
            servers.put(server)
            forget(folder)

    with ThreadPoolExecutor(servers.qsize()) as pool:
        found = list(pool.map(one, cases))
    return {name: wrong for name, wrong in found if wrong}


def held_against_open(found: dict[str, list[str]], tried: set[str]) -> None:
    """What fails is what is known to fail, no less and no more."""
    news = {name: wrong for name, wrong in found.items() if name not in OPEN}
    assert not news, "\n".join(f"{name}: {'; '.join(wrong)}" for name, wrong in news.items())
    mended = [name for name in OPEN if name in tried and name not in found]
    assert not mended, f"mended, so take them out of tests/broken/open.py: {mended}"


@pytest.mark.parametrize("theme", corpus.THEMES)
def test_quick_cases_keep_the_rule(theme, servers, tmp_path):
    cases = [case for case in corpus.cases((theme,)) if case.quick]
    held_against_open(broken_rules(cases, servers, tmp_path), {case.name for case in cases})


@pytest.mark.slow
@pytest.mark.parametrize("theme", corpus.THEMES)
def test_all_inputs_keep_the_rule(theme, servers, tmp_path):
    cases = [case for case in corpus.spread(corpus.cases((theme,))) if not _whole_demo(case)]
    held_against_open(broken_rules(cases, servers, tmp_path), {case.name for case in cases})


@contextlib.contextmanager
def one_core() -> Iterator[None]:
    """What is started here runs on one core: two threads on cores that share their parts count more time for a work."""
    if not hasattr(os, "sched_setaffinity"):  # not on every system
        yield
        return
    before = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {min(before)})
    try:
        yield
    finally:
        os.sched_setaffinity(0, before)


@pytest.mark.slow
@pytest.mark.alone
def test_whole_demos_keep_the_rule(good_inputs, tmp_path):
    """Most of a run's limit goes by in one that has a core to itself: one at a time, and beside no other test."""
    cases = [case for case in corpus.spread(corpus.cases()) if _whole_demo(case)]
    keep_kernels(tmp_path)
    with one_core(), serving() as server:
        servers: SimpleQueue[Server] = SimpleQueue()
        servers.put(server)
        found = broken_rules(cases, servers, tmp_path)
        # cores that other machines share take up to 1.4 times the time for a work: what is too much is so each time
        for again in range(2):
            slow = [case for case in cases if case.name in found and all(map(_too_much, found[case.name]))]
            for case in slow:
                del found[case.name]
            found |= broken_rules(slow, servers, tmp_path / f"again {again}")
    held_against_open(found, {case.name for case in cases})


@pytest.mark.slow
def test_processes_of_their_own_keep_the_rule(good_inputs, tmp_path):
    cases = [case for case in corpus.cases() if case.quick][::4]
    found = {}
    for number, case in enumerate(cases):
        found[case.name] = judged(case, run(case, Fresh(), tmp_path / str(number)))
        forget(tmp_path / str(number))
    held_against_open({name: wrong for name, wrong in found.items() if wrong}, {case.name for case in cases})


# one case for every text file that is read, by what its name is in each encoding
TEXTS = (
    "depth.txt: {}: convert",
    "groundtruth.txt: {}: stated",
    "camera.json: {}: convert",
    "sensor: {} sensor.json: show",
    "scene: {}: simulate",
    "board: {} board.json: intrinsics",
    "mesh: {} ascii.ply: convert",
    "mesh: {} ascii.pcd: convert",
    "mesh: {} points.xyz: convert",
    "mesh: {} cube.obj: convert",
    "mesh: {} cube.off: convert",
    "mesh: {} ascii.stl: convert",
)


@pytest.mark.slow
@pytest.mark.parametrize("encoding", ["BOM", "CRLF", "UTF-16 with BOM", "UTF-16 without BOM", "NUL after each line"])
def test_every_text_is_read_or_refused_alike(encoding, servers, tmp_path):
    named = {case.name: case for case in corpus.cases()}
    server, ended = servers.get(), {}
    for number, text in enumerate(TEXTS):
        case = named[text.format(encoding)]
        ended[case.name] = run(case, server, tmp_path / str(number)).status
    servers.put(server)
    assert len(set(ended.values())) == 1, ended


def test_the_corpus_is_as_large_as_is_said(good_inputs):
    names = [case.name for theme in corpus.THEMES for case in corpus.cases((theme,))]
    inputs = {name.rsplit(": ", 1)[0] for name in names}
    assert len(set(names)) == len(names)
    assert len(inputs) >= 400 and len(names) >= 4000
    unknown = {name for name in OPEN if not name.startswith("found: ")} - set(names)
    assert not unknown, "open.py names cases that are not there"
