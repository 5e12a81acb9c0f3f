"""What a result is worth in one word, with its reasons: one place decides what the words mean."""

from collections.abc import Sequence
from dataclasses import dataclass

from fusion.results.light import Light


@dataclass(frozen=True)
class Worth:
    """What a result is worth.

    Attributes:
        word: "good", "doubtful" (something of it is, or may be, wrong) or "failed" (it is wrong, and not handed out).
        reasons: the lights that made it so, the worst first; none where it is good.
    """

    word: str
    reasons: tuple[Light, ...] = ()

    def sentences(self) -> list[str]:
        """The reasons for JSON, a sentence or two each."""
        return [f"{light.subject}: {light.reason} {light.do}".strip() for light in self.reasons]

    def line(self) -> str:
        """ "doubtful: camera, closing", for the first line of terminal and page."""
        subjects = dict.fromkeys(light.subject.lower() for light in self.reasons)
        return f"{self.word}: {', '.join(subjects)}" if subjects else self.word


def worth_of(lights: Sequence[Light]) -> Worth:
    """Failed where a light says so, doubtful where one is red, else good."""
    red = [light for light in lights if light.level == "bad"]
    fatal = [light for light in red if light.fails]
    if fatal:
        return Worth("failed", (*fatal, *(light for light in red if not light.fails)))
    return Worth("doubtful", tuple(red)) if red else Worth("good")
