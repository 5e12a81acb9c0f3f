"""What a case of the corpus is: how its input is made, what is run over it, and what would be right."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum
from pathlib import Path


class Expected(Enum):
    """What is right for an input, told from the formats' definitions before the program is run."""

    REFUSED = "refused"  # exit status 1, or 2 where the command line itself is wrong
    ACCEPTED = "accepted"  # exit status 0
    TOLD = "told"  # refused, or accepted with a word about the part that was left out
    EITHER = "either"  # both can be defended; the rule of the judge holds all the same


REFUSED, ACCEPTED, TOLD, EITHER = Expected.REFUSED, Expected.ACCEPTED, Expected.TOLD, Expected.EITHER

Make = Callable[[Path], list[str]]  # fills a new folder, returns the words after `fusion`; paths relative to the folder
# looks at the folder after a run that ended with 0, and at what was printed; says what is wrong, or nothing
Look = Callable[[Path, str], str]


@dataclass(frozen=True)
class Case:
    """One run of the program over one input.

    `where`: of these words at least one stands in the line that refuses. `out`: the result's name in the folder, which
    may not be there after a refusal, unless it was there before and is as it was. `quick`: also part of `make test`.
    `weight`: how heavy the run is where it is accepted; see `corpus.chosen`.
    """

    name: str
    make: Make
    expected: Expected = EITHER
    where: tuple[str, ...] = ()
    out: str = "out"
    look: Look | None = None
    quick: bool = False
    weight: int = 1

    def as_quick(self) -> "Case":
        """The same, as part of `make test`."""
        return replace(self, quick=True)
