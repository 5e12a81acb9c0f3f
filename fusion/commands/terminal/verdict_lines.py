"""A verdict on the terminal: the sentence first, then each claim: what it is, how large, how sure, what to do next."""

import textwrap
from collections.abc import Iterator
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from fusion.discrepancy.verdict.claim import Claim
    from fusion.discrepancy.verdict.content import Verdict

LABEL = 12  # columns of the words on the left
NAMES = 8  # that are listed one by one


def verdict_lines(verdict: "Verdict", width: int) -> list[str]:
    """The lines of a verdict."""
    lines = textwrap.wrap(verdict.headline, width)
    for number, claim in enumerate(verdict.missing, start=1):
        lines += ["", *_claim(f"{number}.", claim, True, width)]
    for claim in verdict.indicated:
        lines += ["", *_claim("?", claim, False, width)]
    return [*lines, "", *_rest(verdict, width)]


def _claim(mark: str, claim: "Claim", established: bool, width: int) -> Iterator[str]:
    from fusion.discrepancy.verdict.words import how_sure, name_of, numbers_of, rivals_said, size_of, what_it_is
    from fusion.sensor.words.in_words import plain

    yield from textwrap.wrap(f"{mark} {name_of(claim)}: {what_it_is(claim)}", width, subsequent_indent="   ")
    if size := size_of(claim):
        yield from _row("size", size, width)
    yield from _row("how sure", how_sure(claim, established), width)
    for name, values in numbers_of(claim):
        yield from _row(name, "; ".join(values), width)
    if claim.unknown or claim.where.region or claim.channel != "bias":
        yield from _row("where", claim.where.text.removeprefix(f"{claim.effect}: "), width)
    if alike := rivals_said(claim):
        yield from _row("or it is", f"{', '.join(map(plain, alike))}: these recordings show the same for each", width)
    if claim.record_next:
        yield from _row("record next", plain(claim.record_next), width)


def _rest(verdict: "Verdict", width: int) -> Iterator[str]:
    """What was looked for in vain, and what these recordings cannot show."""
    from fusion.sensor.words.in_words import plain

    unseen = verdict.invisible
    if unseen:
        named = ", ".join(map(plain, unseen[:NAMES])) + (", ..." if len(unseen) > NAMES else "")
        yield from _row("not seen", f"{len(unseen)} effects leave no trace in such recordings: {named}", width)
    if verdict.limits:
        looked = f"{len(verdict.limits)} other effects; the report says how large each could still be"
        yield from _row("not found", looked, width)


def _row(label: str, text: str, width: int) -> list[str]:
    return textwrap.wrap(text, width, initial_indent=f"   {label:<{LABEL}}", subsequent_indent=" " * (LABEL + 3))
