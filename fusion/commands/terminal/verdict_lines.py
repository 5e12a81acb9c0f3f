"""A verdict on the terminal: the sentence first, then each claim: what it is, how large, how sure, what to do next."""

import textwrap
from collections.abc import Iterator
from typing import Any

LABEL = 12  # columns of the words on the left
NAMES = 8  # that are listed one by one


def verdict_lines(verdict: dict[str, Any], width: int) -> list[str]:
    """The lines of a verdict."""
    lines = textwrap.wrap(verdict["headline"], width)
    for number, entry in enumerate(verdict["missing"], start=1):
        lines += ["", *_claim(f"{number}.", entry, True, width)]
    for entry in verdict["indicated"]:
        lines += ["", *_claim("?", entry, False, width)]
    return [*lines, "", *_rest(verdict, width)]


def _claim(mark: str, entry: dict[str, Any], established: bool, width: int) -> Iterator[str]:
    from fusion.discrepancy.verdict.words import how_sure, name_of, numbers_of, rivals_said, size_of, what_it_is
    from fusion.sensor.words.in_words import plain

    yield from textwrap.wrap(f"{mark} {name_of(entry)}: {what_it_is(entry)}", width, subsequent_indent="   ")
    if size := size_of(entry):
        yield from _row("size", size, width)
    yield from _row("how sure", how_sure(entry, established), width)
    for name, values in numbers_of(entry):
        yield from _row(name, "; ".join(values), width)
    if entry["effect"] == "unknown" or entry["where"]["region"] or entry["channel"] != "bias":
        yield from _row("where", entry["where"]["text"].removeprefix(f"{entry['effect']}: "), width)
    if alike := rivals_said(entry):
        yield from _row("or it is", f"{', '.join(map(plain, alike))}: these recordings show the same for each", width)
    if entry["record_next"]:
        yield from _row("record next", plain(entry["record_next"]), width)


def _rest(verdict: dict[str, Any], width: int) -> Iterator[str]:
    """What was looked for in vain, and what these recordings cannot show."""
    from fusion.sensor.words.in_words import plain

    unseen = verdict["invisible"]
    if unseen:
        named = ", ".join(map(plain, unseen[:NAMES])) + (", ..." if len(unseen) > NAMES else "")
        yield from _row("not seen", f"{len(unseen)} effects leave no trace in such recordings: {named}", width)
    if verdict["limits"]:
        looked = f"{len(verdict['limits'])} other effects; the report says how large each could still be"
        yield from _row("not found", looked, width)


def _row(label: str, text: str, width: int) -> list[str]:
    return textwrap.wrap(text, width, initial_indent=f"   {label:<{LABEL}}", subsequent_indent=" " * (LABEL + 3))
