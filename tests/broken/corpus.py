"""All cases, each with a name of its own."""

import importlib
import itertools
from collections.abc import Iterable, Iterator
from dataclasses import replace

from broken.case import EITHER, Case

THEMES = (
    "tables",
    "depth_pictures",
    "cameras",
    "sensors",
    "scenes",
    "poses",
    "solids",
    "boards",
    "seen",
    "options",
    "words",
    "places",
    "foreign",
    "phones",
    "recorded",
    "no_recording",
    "lifted",
)


def cases(themes: tuple[str, ...] = THEMES) -> Iterator[Case]:
    """Every case of some themes; the good inputs must have been made: see `bases.prepare`."""
    seen: dict[str, int] = {}  # how often a name came
    for theme in themes:
        for case in importlib.import_module(f"broken.inputs.{theme}").cases():
            seen[case.name] = times = seen.get(case.name, 0) + 1
            yield case if times == 1 else replace(case, name=f"{case.name} ({times})")


def spread(cases: Iterable[Case]) -> Iterator[Case]:
    """Each input at least once: with a light command whose answer is sure, every eighth with another too.

    All commands over all inputs take most of an hour; they read by the same few readers.
    """
    for number, (_, group) in enumerate(itertools.groupby(cases, key=lambda case: case.name.rsplit(": ", 1)[0])):
        found = list(group)
        first = min(found, key=lambda case: case.weight + 3 * (case.expected is EITHER))
        others = [case for case in found if case is not first]
        yield first
        if others and number % 8 == 0:
            yield others[number // 8 % len(others)]
