"""Effects in words: how a person names an effect, and one sentence on what happens."""

import sys
from dataclasses import dataclass

from fusion.sensor.effect import Effect


@dataclass(frozen=True)
class InWords:
    """The first line of an effect's own file, "Title: what happens."."""

    title: str
    happens: str


def in_words(kind: type[Effect]) -> InWords:
    """Title and sentence of an effect; the sentence is empty where Python runs without documentation (-OO)."""
    first = (sys.modules[kind.__module__].__doc__ or "").partition("\n")[0]
    title, _, happens = first.partition(": ")
    return InWords(title, happens) if happens else InWords(plain(kind.name), "")


def plain(name: str) -> str:
    """An effect's name as words."""
    return name.replace("_", " ")
