"""A job: one command on one recording, and the row that it leaves."""

import re
from dataclasses import dataclass, field
from pathlib import Path

from fusion.errors import FusionError

RECORDING, OUT = "{rec}", "{out}"
KEY_LENGTH = 12  # digits of the key in a folder's name: two of 10^6 jobs share them once in 500 batches


@dataclass(frozen=True)
class JobLimits:
    """What one job may take; None: all there is."""

    seconds: float | None = None  # of the clock
    gigabytes: float | None = None  # of memory, of its process and those that it starts


@dataclass(frozen=True)
class Job:
    """One command on one recording."""

    named: str  # the recording, as the list names it
    name: str  # for people and folders
    key: str  # of recording, words, files that they name, and version
    words: tuple[str, ...]  # of the command, with `{out}` where the result's folder stands
    home: str  # the batch's folder, absolute: where the command runs, and its folder appears
    runner: str  # "module:function" that runs words and gives an exit status
    limits: JobLimits = field(default_factory=JobLimits)  # what it may take
    again: bool = False  # an earlier result is replaced

    @property
    def folder(self) -> str:
        """Name of its folder in `home`."""
        return f"{self.name}-{self.key[:KEY_LENGTH]}"

    @property
    def said(self) -> list[str]:
        """The words as they are run, in `home`: so no result holds where the batch stands."""
        return [word.replace(OUT, self.folder) for word in self.words] + ["--overwrite"] * self.again


@dataclass(frozen=True)
class JobRow:
    """What became of a job."""

    recording: str  # as the list names it
    name: str  # of the job
    status: str  # "done"; "refused", the command said why and would again; "stopped", it may work another time
    light: str  # "good", "doubtful", "failed", or "done" where the command judges nothing
    reason: str = ""  # one sentence, "" where all is well
    folder: str = ""  # of the result, "" where there is none
    key: str = ""  # of the job
    # of the result's JSON files, by their name and keys
    numbers: dict[str, float | int | bool | str] = field(default_factory=dict)


def plain_name(path: Path) -> str:
    """A name that any file system takes: of a file without its ending."""
    name = path.stem if path.is_file() else path.name
    return re.sub(r"[^A-Za-z0-9._-]+", "_", name).strip("._-")[:60] or "job"


def filled(words: list[str], values: dict[str, str]) -> tuple[str, ...]:
    """The words of a command with `{rec}` and further columns filled in; `{out}` stays.

    Raises:
        FusionError: a name in braces that nobody knows.
    """

    def value(found: re.Match[str]) -> str:
        if found[0] == OUT:
            return OUT
        if found[1] not in values:
            known = ", ".join(sorted(f"{{{name}}}" for name in [*values, "out"]))
            raise FusionError("a word in braces is not known", "COMMAND", found[0], known)
        return values[found[1]]

    return tuple(re.sub(r"\{(\w+)\}", value, word) for word in words)
