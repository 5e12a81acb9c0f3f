"""Errors a user can act on: every one says what, where, found, expected and what to do."""

import re
import unicodedata

LONGEST = 600  # characters of a message: what a terminal shows in a few lines
SHORTEST = 80  # characters that a part keeps where the message is cut
_UNUSUAL = re.compile(r"[^ -~]")


def printable(text: str, kept: str = "") -> str:
    r"""Text that a terminal shows as it is: what would move its cursor, hide or turn round other text is escaped.

    >>> printable("a\x1b[31mb")
    'a\\x1b[31mb'
    """

    def shown(found: re.Match[str]) -> str:
        one = found[0]
        usual = one.isprintable() or one in kept or unicodedata.category(one) == "Zs"
        return one if usual else one.encode("unicode_escape").decode()

    return _UNUSUAL.sub(shown, text)


def _fitting(parts: list[str]) -> list[str]:
    """The parts, the longest cut in their middle until all together are of a readable length."""
    while (spare := sum(map(len, parts)) - LONGEST) > 0:
        longest = max(range(len(parts)), key=lambda i: len(parts[i]))
        size = len(parts[longest])
        if size <= SHORTEST:
            break
        keep = max(SHORTEST, size - spare - 5) - 5
        parts[longest] = f"{parts[longest][: keep - keep // 2]} ... {parts[longest][size - keep // 2 :]}"
    return parts


class FusionError(Exception):
    """A problem with the input, told in one line.

    Args:
        what: the problem, as a short statement.
        where: file, frame or option it was met in.
        found: what was there.
        expected: what should have been there.
        do: what the user can do next.
    """

    def __init__(self, what: str, where: object = "", found: object = "", expected: object = "", do: str = "") -> None:
        self.what, self.where, self.do = what, str(where), do
        self.found, self.expected = str(found), str(expected)
        parts = [what]
        parts += [f"in {self.where}"] if self.where else []
        parts += [f"found {self.found}"] if self.found else []
        parts += [f"expected {self.expected}"] if self.expected else []
        parts += [do] if do else []
        super().__init__("; ".join(_fitting([printable(" ".join(part.split())) for part in parts])))


class RecordingError(FusionError):
    """A recording, camera or trajectory file that cannot be used."""


class MeshError(FusionError):
    """A mesh or point cloud that cannot be used."""


class SensorError(FusionError):
    """A sensor model that cannot be used."""


class TrackingError(FusionError):
    """Too few frames could be placed to go on."""


class VolumeError(FusionError):
    """The voxel volume cannot hold what was asked of it."""


class SceneError(FusionError):
    """A scene to simulate that cannot be used."""


class DeviceError(FusionError):
    """A camera that cannot be found, opened or read."""
