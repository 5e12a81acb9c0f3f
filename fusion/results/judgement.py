"""One judgement of a result, used by terminal, page and JSON alike."""

from dataclasses import dataclass

from fusion.results.light import Light
from fusion.results.worth import Worth, worth_of

WORDS = {"ok": "good", "warning": "look here", "bad": "PROBLEM"}
WIDTH = max(map(len, WORDS.values()))


@dataclass(frozen=True)
class Judgement:
    """What a run knows of its own result.

    Attributes:
        lights: what was judged, the worst first.
        footnotes: what comes with nearly every result of its kind, and changes nothing.
    """

    lights: tuple[Light, ...]
    footnotes: tuple[str, ...] = ()

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


def _joined(light: Light) -> str:
    return f"{light.reason} {light.do}".strip()
