"""Does what the program says of a scan agree with the truth? Each disagreement is a sentence."""

import re
from dataclasses import dataclass
from pathlib import Path

from tools.sets.judging.command import Ran
from tools.sets.judging.said import content

OPEN = re.compile(
    r"no loop|no place|nothing (\w+ )*(closes|closed|twice|again)|(not|never) (\w+ )*(closed?|twice|again|checked)"
    r"|does not close|drift is (not|un)\w*|unchecked",
    re.IGNORECASE,
)
LOOP = re.compile(r"\bloops?\b|\bclos(es|ed|ure|ures|ing)\b|seen (twice|again)|\bdrift", re.IGNORECASE)
# stages as they pass and what they took are no statements; nor is a closed surface a closed loop
STAGE = re.compile(r"^\d+ s\s|^took\s")
SURFACE = re.compile(r"hole|watertight|triangles", re.IGNORECASE)
FRAMES = re.compile(r"frame|depth image", re.IGNORECASE)
LOST = re.compile(
    r"left out|not placed|\blost\b|without (a )?(pose|depth)|no (pose|depth)|could not be|rejected|empty", re.IGNORECASE
)
COURSE = re.compile(r"\bloops?\b|\bclos|drift|track|course|\blost\b|placed|jump|relocal|doubled", re.IGNORECASE)


@dataclass(frozen=True)
class Told:
    """What a run told its user.

    Attributes:
        sentences: every line of the judgement, warnings, footnotes and what the terminal showed.
        alarms: those of them that warn, or are bad.
        placed: frames told to have a pose, None where nothing is told.
        rejected: frames are named that were left out.
    """

    status: int
    sentences: tuple[str, ...]
    alarms: tuple[str, ...]
    placed: int | None
    rejected: bool

    @property
    def says_open(self) -> bool:
        """That nothing closes the walk."""
        return any(OPEN.search(text) for text in self.sentences)

    @property
    def says_closed(self) -> bool:
        """That a loop was closed, or drift taken out."""
        some = (text for text in self.sentences if LOOP.search(text) and not SURFACE.search(text))
        return any(not OPEN.search(text) for text in some)

    @property
    def says_lost(self) -> bool:
        """That frames were left out, had no depth, were lost."""
        return any(LOST.search(text) and FRAMES.search(text) for text in self.sentences)

    @property
    def course_alarm(self) -> bool:
        """A warning about where the camera went."""
        return any(COURSE.search(text) for text in self.alarms)


def read(output: Path, ran: Ran) -> Told:
    """From settings.json, exit status and terminal."""
    settings = content(output / "settings.json")
    judgement = [(x.get("level"), f"{x.get('subject')}: {x.get('reason')}") for x in settings.get("judgement") or ()]
    warnings = [str(x) for x in settings.get("warnings") or ()]
    shown = [line.strip() for line in ran.terminal.splitlines() if line.strip() and not STAGE.match(line.strip())]
    sentences = [*(text for _, text in judgement), *warnings, *map(str, settings.get("footnotes") or ()), *shown]
    alarms = warnings + [text for level, text in judgement if level != "ok" and not any(text in w for w in warnings)]
    if ran.status:
        alarms.append(ran.last)
    placed = (settings.get("result") or {}).get("placed")
    return Told(
        ran.status, tuple(dict.fromkeys(sentences)), tuple(dict.fromkeys(alarms)),
        None if placed is None else int(placed), bool(settings.get("rejected")),
    )  # fmt: skip


@dataclass(frozen=True)
class Facts:
    """What is true of a result.

    Attributes:
        frames: of the recording; `placed` have a pose in trajectory.txt.
        blank: frames without depth.
        gap: [m] by which the end misses the start, None where there is no course; `allowed` of it.
        worst: [m] largest distance of a camera from its true place; `gross`: what nobody may pass over in silence.
        returns: the end of the walk sees what its start saw; None: not known.
    """

    frames: int
    placed: int
    blank: int
    gap: float | None
    allowed: float
    worst: float
    gross: float
    returns: bool | None


def disagreements(told: Told, facts: Facts) -> list[str]:
    """None where all that is said is true, and all that matters is said."""
    if told.status:
        return [f"refused with status {told.status}"]
    out = []
    if told.placed != facts.placed:
        out.append(f"says {told.placed} frames placed, trajectory.txt has {facts.placed}")
    if facts.placed < facts.frames and not (told.rejected or told.says_lost):
        out.append(f"{facts.frames - facts.placed} frames have no pose, and nothing is said")
    if facts.blank and not (told.rejected or told.says_lost):
        out.append(f"{facts.blank} frames have no depth, and nothing is said")
    if facts.worst > facts.gross and not told.course_alarm:
        out.append(f"a camera is off by {facts.worst:.2f} m, and nothing warns")
    if facts.gap is None or facts.returns is None:
        return out
    if not facts.returns:
        if not told.says_open:
            out.append("the walk does not come back, and it is not said that nothing closes")
    elif facts.gap <= facts.allowed:
        if told.says_open or not told.says_closed:
            out.append("the loop is closed, and " + ("the contrary is said" if told.says_open else "it is not said"))
    elif not (told.says_open or told.course_alarm):
        out.append(f"the end misses the start by {1e3 * facts.gap:.0f} mm, and nothing warns of drift")
    return out
