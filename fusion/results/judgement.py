"""One judgement of a result, used by terminal, page and JSON alike: good, doubtful or failed, and why."""

from collections.abc import Sequence
from dataclasses import dataclass

from fusion.errors import FusionError
from fusion.results.light import Light

WORDS = {"ok": "good", "warning": "look here", "bad": "PROBLEM"}
WIDTH = max(map(len, WORDS.values()))


@dataclass(frozen=True)
class Worth:
    """What a result is worth."""

    word: str  # "good", "doubtful" (something of it is, or may be, wrong) or "failed" (it is wrong, and not handed out)
    reasons: tuple[Light, ...] = ()  # the lights that made it so, the worst first; none where it is good

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


@dataclass(frozen=True)
class Judgement:
    """What a run knows of its own result."""

    lights: tuple[Light, ...]  # what was judged, the worst first
    footnotes: tuple[str, ...] = ()  # what comes with nearly every result of its kind, and changes nothing

    @property
    def level(self) -> str:
        """The worst level of all lights."""
        return self.lights[0].level if self.lights else "ok"

    @property
    def worth(self) -> Worth:
        """What the result is worth, in one word."""
        return worth_of(self.lights)

    @property
    def warnings(self) -> tuple[str, ...]:
        """What is not good, a sentence each, the worst first."""
        return tuple(f"{x.subject}: {_joined(x)}" for x in self.lights if x.level != "ok")

    def lines(self) -> list[str]:
        """For a terminal: a line for each light that is not good, then the subjects of those that are."""
        out = [f"{WORDS[x.level]:<{WIDTH}} {x.subject}: {_joined(x)}" for x in self.lights if x.level != "ok"]
        good = [x.subject for x in self.lights if x.level == "ok"]
        return out + ([f"{WORDS['ok']:<{WIDTH}} {', '.join(good)}"] if good else [])


def failure(judgement: Judgement, where: str) -> FusionError | None:
    """Why a result is not handed out, by the line of its worst light; None where it is good, or only doubtful."""
    worth = judgement.worth
    if worth.word != "failed":
        return None
    worst = worth.reasons[0]
    return FusionError(worst.reason.rstrip("."), where, do=f"{worst.do} --keep-failed writes what there is".lstrip())


def _joined(light: Light) -> str:
    return f"{light.reason} {light.do}".strip()
